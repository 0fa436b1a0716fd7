//! Writes an MCAP file with chunks, their index and a summary.

use std::collections::BTreeMap;
use std::io;

use super::{Channel, MAGIC, Map, Schema, code};

/// Uncompressed bytes at which a chunk ends. Choice: as in other writers, so that a viewer reads little when it jumps
/// in time.
const BYTES_PER_CHUNK: usize = 1 << 20;
/// Level of zstd.
const ZSTD_LEVEL: i32 = 3;

/// A record that is being composed, or a part of one.
#[derive(Default)]
struct Record(Vec<u8>);

impl Record {
    fn u16(mut self, number: u16) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn u32(mut self, number: u32) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    fn u64(mut self, number: u64) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    /// Bytes, preceded by their number. Nothing that is written here is as large as 4 GB.
    fn bytes(mut self, bytes: &[u8]) -> Self {
        self = self.u32(bytes.len() as u32);
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Self {
        self.bytes(text.as_bytes())
    }

    fn map(self, map: &Map) -> Self {
        let pairs = map.iter();
        let pairs = pairs.fold(Record::default(), |pairs, (name, value)| pairs.text(name).text(value));
        self.bytes(&pairs.0)
    }

    /// Numbers by channel.
    fn by_channel(self, map: &BTreeMap<u16, u64>) -> Self {
        let pairs = map.iter();
        let pairs = pairs.fold(Record::default(), |pairs, (channel, number)| pairs.u16(*channel).u64(*number));
        self.bytes(&pairs.0)
    }

    /// Appends the record to `out`, with its code and length.
    fn put(self, code: u8, out: &mut Vec<u8>) {
        out.push(code);
        out.extend((self.0.len() as u64).to_le_bytes());
        out.extend(self.0);
    }
}

fn schema_record(schema: &Schema) -> Record {
    let record = Record::default().u16(schema.id);
    record.text(&schema.name).text(&schema.encoding).bytes(&schema.data)
}

fn channel_record(channel: &Channel) -> Record {
    let record = Record::default().u16(channel.id).u16(channel.schema_id);
    record.text(&channel.topic).text(&channel.message_encoding).map(&Map::new())
}

/// Messages that are not yet in the file.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    /// Time and place in `records` of each message, by channel.
    messages: BTreeMap<u16, Vec<(u64, u64)>>,
    /// Times of the first and last message.
    span: Option<(u64, u64)>,
}

fn joined(span: Option<(u64, u64)>, time: u64) -> Option<(u64, u64)> {
    Some(span.map_or((time, time), |(first, last)| (first.min(time), last.max(time))))
}

/// A file that is being written, in memory.
pub(crate) struct Writer {
    out: Vec<u8>,
    schemas: Vec<Schema>,
    channels: Vec<Channel>,
    chunk: Chunk,
    chunk_indexes: Vec<Record>,
    metadata_indexes: Vec<Record>,
    counts: BTreeMap<u16, u64>,
    span: Option<(u64, u64)>,
    sequence: u32,
}

impl Writer {
    /// Begins a file; `library` names the program that writes it.
    pub(crate) fn new(library: &str) -> Self {
        let mut out = MAGIC.to_vec();
        Record::default().text("").text(library).put(code::HEADER, &mut out);
        Writer {
            out,
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk: Chunk::default(),
            chunk_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
            counts: BTreeMap::new(),
            span: None,
            sequence: 0,
        }
    }

    /// Adds facts about the whole file.
    pub(crate) fn metadata(&mut self, name: &str, facts: &Map) {
        let start = self.out.len() as u64;
        Record::default().text(name).map(facts).put(code::METADATA, &mut self.out);
        let length = self.out.len() as u64 - start;
        self.metadata_indexes.push(Record::default().u64(start).u64(length).text(name));
    }

    /// Adds a channel, and its schema unless there is one of this name. Returns the number of the channel.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        message_encoding: &str,
        schema: &str,
        encoding: &str,
        data: &[u8],
    ) -> u16 {
        let known = self.schemas.iter().find(|known| known.name == schema);
        let schema_id = known.map(|known| known.id).unwrap_or_else(|| {
            let new = Schema {
                id: self.schemas.len() as u16 + 1,
                name: schema.into(),
                encoding: encoding.into(),
                data: data.into(),
            };
            schema_record(&new).put(code::SCHEMA, &mut self.chunk.records);
            self.schemas.push(new);
            self.schemas.len() as u16
        });
        let channel = Channel {
            id: self.channels.len() as u16,
            schema_id,
            topic: topic.into(),
            message_encoding: message_encoding.into(),
        };
        channel_record(&channel).put(code::CHANNEL, &mut self.chunk.records);
        self.counts.insert(channel.id, 0);
        self.channels.push(channel);
        self.channels.len() as u16 - 1
    }

    /// Adds a message at a time, ns.
    pub(crate) fn message(&mut self, channel: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        if self.chunk.records.len() >= BYTES_PER_CHUNK {
            self.end_chunk()?;
        }
        let place = self.chunk.records.len() as u64;
        self.chunk.messages.entry(channel).or_default().push((time_ns, place));
        self.chunk.span = joined(self.chunk.span, time_ns);
        self.span = joined(self.span, time_ns);
        *self.counts.entry(channel).or_default() += 1;
        let mut record = Record::default().u16(channel).u32(self.sequence).u64(time_ns).u64(time_ns);
        record.0.extend(data);
        record.put(code::MESSAGE, &mut self.chunk.records);
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    fn end_chunk(&mut self) -> io::Result<()> {
        let Chunk { records, messages, span } = std::mem::take(&mut self.chunk);
        if records.is_empty() {
            return Ok(());
        }
        let (first, last) = span.unwrap_or_default();
        // One thread, so that the bytes do not depend on the number of cores.
        let compressed = zstd::bulk::compress(&records, ZSTD_LEVEL)?;
        let start = self.out.len() as u64;
        let chunk = Record::default().u64(first).u64(last).u64(records.len() as u64);
        let mut chunk = chunk.u32(crc32fast::hash(&records)).text("zstd").u64(compressed.len() as u64);
        chunk.0.extend(&compressed);
        chunk.put(code::CHUNK, &mut self.out);
        let length = self.out.len() as u64 - start;
        let mut indexes = BTreeMap::new();
        for (channel, messages) in messages {
            indexes.insert(channel, self.out.len() as u64);
            let places = messages.iter();
            let places = places.fold(Record::default(), |list, (time, place)| list.u64(*time).u64(*place));
            Record::default().u16(channel).bytes(&places.0).put(code::MESSAGE_INDEX, &mut self.out);
        }
        let indexes_length = self.out.len() as u64 - start - length;
        let index = Record::default().u64(first).u64(last).u64(start).u64(length);
        let index = index.by_channel(&indexes).u64(indexes_length).text("zstd");
        self.chunk_indexes.push(index.u64(compressed.len() as u64).u64(records.len() as u64));
        Ok(())
    }

    /// Ends the file with its summary and returns its bytes. Without a summary, readers would have to read the whole
    /// file, or would refuse it.
    pub(crate) fn finish(mut self) -> io::Result<Vec<u8>> {
        self.end_chunk()?;
        let mut out = self.out;
        // A checksum of everything before this record is optional; chunks have their own.
        Record::default().u32(0).put(code::DATA_END, &mut out);
        let summary_start = out.len();
        let (first, last) = self.span.unwrap_or_default();
        let statistics = Record::default().u64(self.counts.values().sum()).u16(self.schemas.len() as u16);
        let statistics = statistics.u32(self.channels.len() as u32).u32(0).u32(self.metadata_indexes.len() as u32);
        let statistics = statistics.u32(self.chunk_indexes.len() as u32).u64(first).u64(last).by_channel(&self.counts);
        let groups = [
            (code::SCHEMA, self.schemas.iter().map(schema_record).collect()),
            (code::CHANNEL, self.channels.iter().map(channel_record).collect()),
            (code::STATISTICS, vec![statistics]),
            (code::CHUNK_INDEX, self.chunk_indexes),
            (code::METADATA_INDEX, self.metadata_indexes),
        ];
        let mut offsets = Vec::new();
        for (code, records) in groups {
            let start = out.len() as u64;
            let is_there = !records.is_empty();
            records.into_iter().for_each(|record: Record| record.put(code, &mut out));
            let mut offset = Record(vec![code]);
            offset = offset.u64(start).u64(out.len() as u64 - start);
            offsets.extend(is_there.then_some(offset));
        }
        let offsets_start = out.len();
        offsets.into_iter().for_each(|offset| offset.put(code::SUMMARY_OFFSET, &mut out));
        // The checksum of the summary includes the footer up to the checksum itself.
        let footer = Record::default().u64(summary_start as u64).u64(offsets_start as u64);
        footer.u32(0).put(code::FOOTER, &mut out);
        let checksum = out.len() - 4;
        let crc = crc32fast::hash(&out[summary_start..checksum]);
        out[checksum..].copy_from_slice(&crc.to_le_bytes());
        out.extend(MAGIC);
        Ok(out)
    }
}
