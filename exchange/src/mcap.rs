//! MCAP, the container of messages of ROS 2 and Foxglove (<https://mcap.dev/spec>), through the crate `mcap`.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read};

use mcap::records::{MessageHeader, Metadata, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{Compression, McapError, WriteOptions};
use underbrush_recording::limits::MCAP_CHUNK_BYTES;

/// Facts of a metadata record, by name.
pub(crate) type Map = BTreeMap<String, String>;

/// Level of zstd.
const ZSTD_LEVEL: u32 = 3;

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

impl From<McapError> for Fault {
    fn from(error: McapError) -> Self {
        match error {
            McapError::UnsupportedCompression(name) => Fault::Compression(name),
            error => Fault::Broken(format!("{error:#}")),
        }
    }
}

/// Passes all records of a file to `each` in their order, also those in chunks. A file must end as MCAP does, and its
/// checksums must match.
pub(crate) fn read<E: From<Fault>>(
    mut file: impl Read,
    mut each: impl FnMut(Record) -> Result<(), E>,
) -> Result<(), E> {
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(MCAP_CHUNK_BYTES.most as usize);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(Fault::from)? {
            LinearReadEvent::ReadRequest(bytes) => {
                let count = file.read(reader.insert(bytes)).map_err(Fault::Io)?;
                reader.notify_read(count);
            }
            LinearReadEvent::Record { opcode, data } => {
                each(mcap::parse_record(opcode, data).map_err(Fault::from)?)?;
            }
        }
    }
    Ok(())
}

/// A file that is being written, in memory.
pub(crate) struct Writer {
    writer: mcap::Writer<Cursor<Vec<u8>>>,
    sequence: u32,
}

/// The failure to write into memory.
fn failed(error: McapError) -> io::Error {
    io::Error::other(error)
}

impl Writer {
    /// Begins a file; `library` names the program that writes it.
    pub(crate) fn new(library: &str) -> io::Result<Self> {
        let options = WriteOptions::new()
            .library(library)
            .compression(Some(Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            // One thread, so that the bytes do not depend on the number of cores.
            .compression_threads(0);
        Ok(Writer { writer: options.create(Cursor::default()).map_err(failed)?, sequence: 0 })
    }

    /// Adds facts about the whole file.
    pub(crate) fn metadata(&mut self, name: &str, facts: Map) -> io::Result<()> {
        self.writer.write_metadata(&Metadata { name: name.into(), metadata: facts }).map_err(failed)
    }

    /// Adds a channel, and its schema unless there is one of this name. Returns the number of the channel.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        message_encoding: &str,
        schema: &str,
        encoding: &str,
        data: &[u8],
    ) -> io::Result<u16> {
        let schema = self.writer.add_schema(schema, encoding, data).map_err(failed)?;
        self.writer.add_channel(schema, topic, message_encoding, &Map::new()).map_err(failed)
    }

    /// Adds a message at a time, ns.
    pub(crate) fn message(&mut self, channel_id: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time: time_ns, publish_time: time_ns };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, data).map_err(failed)
    }

    /// Ends the file with its index, and returns its bytes.
    pub(crate) fn finish(mut self) -> io::Result<Vec<u8>> {
        self.writer.finish().map_err(failed)?;
        Ok(self.writer.into_inner().into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of three channels. Two of them have so many messages that the file has several chunks.
    fn example() -> Vec<u8> {
        let mut writer = Writer::new("a test").unwrap();
        writer.metadata("facts", Map::from([("seed".into(), "7".into())])).unwrap();
        let json = |writer: &mut Writer, topic: &str| writer.channel(topic, "json", "mine.A", "jsonschema", b"{}");
        let channels = [json(&mut writer, "/a").unwrap(), json(&mut writer, "/b").unwrap()];
        writer.channel("/c", "cdr", "mine.C", "ros2msg", b"float64 x").unwrap();
        for index in 0..5000_u64 {
            let text = format!("{{\"number\":{index},\"text\":\"{}\"}}", "x".repeat((index % 700) as usize));
            writer.message(channels[index as usize % 2], 10 * index, text.as_bytes()).unwrap();
        }
        writer.finish().unwrap()
    }

    fn messages(bytes: &[u8]) -> Result<Vec<(u64, Vec<u8>)>, Fault> {
        let mut messages = Vec::new();
        read(bytes, |record| {
            if let Record::Message { header, data } = record {
                messages.push((header.log_time, data.into_owned()));
            }
            Ok::<(), Fault>(())
        })?;
        Ok(messages)
    }

    /// Tests that messages come back in their order, that a file has several chunks, and that it has the same bytes when it
    /// is written again.
    #[test]
    fn messages_come_back() {
        let bytes = example();
        let found = messages(&bytes).unwrap();
        assert_eq!(found.len(), 5000);
        for (index, (time_ns, data)) in found.iter().enumerate() {
            assert_eq!(*time_ns, 10 * index as u64);
            assert!(data.starts_with(format!("{{\"number\":{index},").as_bytes()));
        }
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        assert!(summary.chunk_indexes.len() > 1 && summary.metadata_indexes.len() == 1);
        assert_eq!((summary.schemas.len(), summary.channels.len()), (2, 3));
        assert_eq!(example(), bytes);
    }

    /// Tests that a file that is cut off anywhere, or has a changed chunk, is refused and not silently read in part.
    #[test]
    fn a_damaged_file_is_refused() {
        let bytes = example();
        for cut in (0..bytes.len()).step_by(997) {
            assert!(matches!(messages(&bytes[..cut]), Err(Fault::Broken(_))), "cut at {cut}");
        }
        let mut changed = bytes.clone();
        // In the first chunk.
        changed[2000] ^= 1;
        assert!(matches!(messages(&changed), Err(Fault::Broken(_))));
        let mut lz4 = bytes;
        let place = lz4.windows(4).position(|window| window == b"zstd").unwrap();
        lz4[place..place + 4].copy_from_slice(b"lz4f");
        assert!(matches!(messages(&lz4), Err(Fault::Compression(name)) if name == "lz4f"));
    }
}
