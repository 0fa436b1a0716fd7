//! Reads an MCAP file record by record, with one chunk in memory.

use std::io::{self, Read};

use underbrush_recording::limits::MCAP_CHUNK_BYTES;

use super::{Channel, MAGIC, Schema, code};

/// What is wrong with a file.
#[derive(Debug)]
pub(crate) enum Fault {
    /// Reading failed.
    Io(io::Error),
    /// The file is not a complete MCAP file.
    Broken(String),
    /// Its chunks are compressed with an algorithm that is not supported.
    Compression(String),
}

impl Fault {
    fn broken(text: impl Into<String>) -> Self {
        Fault::Broken(text.into())
    }
}

/// An item of a file. Items are read one after another.
pub(crate) enum Item<'a> {
    /// A schema, perhaps for the second time.
    Schema(Schema),
    /// A channel, perhaps for the second time.
    Channel(Channel),
    /// A message: number of the channel, time in ns, data.
    Message(u16, u64, &'a [u8]),
}

/// The part of a record's content that has not been parsed yet.
struct Content<'a>(&'a [u8]);

impl<'a> Content<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) =
            self.0.split_at_checked(count).ok_or_else(|| Fault::broken("a record that ends too early"))?;
        self.0 = rest;
        Ok(taken)
    }

    fn u16(&mut self) -> Result<u16, Fault> {
        Ok(self.take(2)?.try_into().map_or(0, u16::from_le_bytes))
    }

    fn u32(&mut self) -> Result<u32, Fault> {
        Ok(self.take(4)?.try_into().map_or(0, u32::from_le_bytes))
    }

    fn u64(&mut self) -> Result<u64, Fault> {
        Ok(self.take(8)?.try_into().map_or(0, u64::from_le_bytes))
    }

    fn bytes(&mut self) -> Result<&'a [u8], Fault> {
        let count = self.u32()?;
        self.take(count as usize)
    }

    fn text(&mut self) -> Result<String, Fault> {
        Ok(String::from_utf8_lossy(self.bytes()?).into_owned())
    }
}

/// Parses a record; `None` if it is of a kind that is not needed.
fn item(code: u8, content: &[u8]) -> Result<Option<Item<'_>>, Fault> {
    let mut content = Content(content);
    Ok(match code {
        code::SCHEMA => Some(Item::Schema(Schema {
            id: content.u16()?,
            name: content.text()?,
            encoding: content.text()?,
            data: content.bytes()?.to_vec(),
        })),
        code::CHANNEL => Some(Item::Channel(Channel {
            id: content.u16()?,
            schema_id: content.u16()?,
            topic: content.text()?,
            message_encoding: content.text()?,
        })),
        code::MESSAGE => {
            let channel = content.u16()?;
            content.u32()?;
            let time_ns = content.u64()?;
            content.u64()?;
            Some(Item::Message(channel, time_ns, content.0))
        }
        _ => None,
    })
}

/// The records of a chunk, decompressed.
fn decompressed(content: &[u8]) -> Result<Vec<u8>, Fault> {
    let mut content = Content(content);
    content.take(16)?;
    let (size, crc) = (content.u64()?, content.u32()?);
    let compression = content.text()?;
    let length = content.u64()?;
    let records = content.take(usize::try_from(length).unwrap_or(usize::MAX))?;
    if size > MCAP_CHUNK_BYTES.most {
        return Err(Fault::broken(format!("a chunk of {size} bytes")));
    }
    let records = match compression.as_str() {
        "" => records.to_vec(),
        "zstd" => zstd::bulk::decompress(records, size as usize).map_err(|error| Fault::broken(error.to_string()))?,
        _ => return Err(Fault::Compression(compression)),
    };
    // Zero means that there is no checksum.
    if records.len() as u64 != size || (crc != 0 && crc != crc32fast::hash(&records)) {
        return Err(Fault::broken("a chunk that does not match its checksum"));
    }
    Ok(records)
}

/// Reads the records of a file.
pub(crate) struct Reader<R> {
    file: R,
}

impl<R: Read> Reader<R> {
    /// A reader for a file, from its beginning.
    pub(crate) fn new(file: R) -> Self {
        Reader { file }
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.file.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => Fault::broken("a file that ends too early"),
            _ => Fault::Io(error),
        })
    }

    /// Hands all schemas, channels and messages to `each`, in the order of the file.
    pub(crate) fn read<E: From<Fault>>(mut self, mut each: impl FnMut(Item) -> Result<(), E>) -> Result<(), E> {
        let mut magic = MAGIC;
        self.fill(&mut magic)?;
        if magic != MAGIC {
            return Err(Fault::broken("a file that does not begin as MCAP does").into());
        }
        loop {
            let mut head = [0; 9];
            self.fill(&mut head)?;
            let (code, length) = (head[0], Content(&head[1..]).u64()?);
            if length > MCAP_CHUNK_BYTES.most {
                return Err(Fault::broken(format!("a record of {length} bytes")).into());
            }
            let mut content = Vec::new();
            // Memory is not reserved at once, because the length may be damaged.
            let read = (&mut self.file).take(length).read_to_end(&mut content).map_err(Fault::Io)?;
            if read as u64 != length {
                return Err(Fault::broken("a file that ends too early").into());
            }
            match code {
                code::CHUNK => {
                    let records = decompressed(&content)?;
                    let mut records = Content(&records);
                    while !records.0.is_empty() {
                        let (code, length) = (records.take(1)?[0], records.u64()?);
                        let content = records.take(usize::try_from(length).unwrap_or(usize::MAX))?;
                        if let Some(item) = item(code, content)? {
                            each(item)?;
                        }
                    }
                }
                // The footer is the last record. The magic bytes after it show that the file is complete.
                code::FOOTER => {
                    self.fill(&mut magic)?;
                    return match magic == MAGIC {
                        true => Ok(()),
                        false => Err(Fault::broken("a file that does not end as MCAP does").into()),
                    };
                }
                code => {
                    if let Some(item) = item(code, &content)? {
                        each(item)?;
                    }
                }
            }
        }
    }
}
