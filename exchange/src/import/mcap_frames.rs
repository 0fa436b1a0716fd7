//! Frames from an MCAP file: each message of a topic is a frame.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Read};
use std::path::Path;

use mcap::McapError;
use mcap::records::{Channel, Record};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use underbrush_recording::InputError;
use underbrush_recording::limits::MCAP_CHUNK_BYTES;

use super::cutter::{Cutter, Place};
use super::message::{Decoder, decoder};
use super::{Mapping, opened};

/// Nanoseconds per second.
const PER_SECOND: f64 = 1e9;

/// The error about a file that cannot be read.
fn io_error(path: &Path, error: io::Error) -> InputError {
    let error = InputError::new(path, "file", error.to_string(), "a readable file", "check the path");
    InputError { storage: true, ..error }
}

/// The error about a file that is not MCAP, or not complete.
fn mcap_error(path: &Path, error: McapError) -> InputError {
    let (found, allowed, remedy) = match error {
        McapError::UnsupportedCompression(name) => (
            format!("chunks compressed with {name}"),
            "chunks compressed with zstd, or not compressed",
            "write the file again with `mcap compress --compression zstd`",
        ),
        error => {
            let remedy = "repair it with `mcap recover`, or record it again";
            (format!("{error:#}"), "a complete MCAP file", remedy)
        }
    };
    InputError::new(path, "MCAP", found, allowed, remedy)
}

/// Passes all records of a file to `each` in their order, also those in chunks. A file must end as MCAP does, and its
/// checksums must match.
fn read_records(path: &Path, mut each: impl FnMut(Record) -> Result<(), InputError>) -> Result<(), InputError> {
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(MCAP_CHUNK_BYTES.most as usize);
    let mut file = BufReader::new(opened(path)?);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| mcap_error(path, error))? {
            LinearReadEvent::ReadRequest(bytes) => {
                let count = file.read(reader.insert(bytes)).map_err(|error| io_error(path, error))?;
                reader.notify_read(count);
            }
            LinearReadEvent::Record { opcode, data } => {
                each(mcap::parse_record(opcode, data).map_err(|error| mcap_error(path, error))?)?;
            }
        }
    }
    Ok(())
}

/// What has been read so far, except the messages.
struct Reading<'a> {
    path: &'a Path,
    mapping: &'a Mapping,
    topic: &'a str,
    /// Names of the schemas.
    schemas: BTreeMap<u16, String>,
    /// Decoders of the channels of the topic.
    decoders: BTreeMap<u16, Decoder>,
    /// All topics, for an error.
    topics: BTreeMap<String, String>,
    messages: usize,
    readings: Vec<f64>,
    /// Time of the first message, ns. Times count from it, because Unix time in seconds would have a resolution of only
    /// 0.2 µs.
    start: Option<u64>,
}

impl Reading<'_> {
    fn channel(&mut self, channel: Channel) -> Result<(), InputError> {
        let schema = self.schemas.get(&channel.schema_id).map_or("", String::as_str);
        self.topics.insert(channel.topic.clone(), schema.to_owned());
        if channel.topic == self.topic && !self.decoders.contains_key(&channel.id) {
            let from = &self.mapping.force.from;
            let decoder = decoder(&channel.message_encoding, schema, from).map_err(|allowed| {
                let found =
                    format!("{:?} with schema {schema:?} and encoding {}", self.topic, channel.message_encoding);
                self.mapping.fault("force.topic", found, allowed)
            })?;
            self.decoders.insert(channel.id, decoder);
        }
        Ok(())
    }

    fn record(&mut self, record: Record, cutter: &mut Cutter) -> Result<(), InputError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
                Ok(())
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => self.message(header.channel_id, header.log_time, &data, cutter),
            _ => Ok(()),
        }
    }

    fn message(&mut self, channel: u16, time_ns: u64, data: &[u8], cutter: &mut Cutter) -> Result<(), InputError> {
        let Some(decoder) = self.decoders.get(&channel) else {
            return Ok(());
        };
        self.messages += 1;
        decoder.decode(data, &mut self.readings).map_err(|(found, allowed)| {
            let remedy = "correct `from` of the mapping, or record the topic again";
            let field = format!("message of {}", self.topic);
            InputError::new(self.path, field, found, allowed, remedy).at_line(self.messages)
        })?;
        let start = *self.start.get_or_insert(time_ns);
        let since_ns = i128::from(time_ns) - i128::from(start);
        let place = Place {
            line: self.messages,
            reach: 0,
            category: self.mapping.trial.category.as_deref().unwrap_or_default(),
            time_s: since_ns as f64 / PER_SECOND,
        };
        cutter.push(&place, &self.readings)
    }
}

/// Hands all messages of the topic to the cutter.
pub(super) fn read(path: &Path, mapping: &Mapping, cutter: &mut Cutter) -> Result<(), InputError> {
    let not_for_mcap = [
        ("time.from", mapping.time.from.is_some()),
        ("time.unit", mapping.time.unit.is_some()),
        ("time.rate_hz", mapping.time.rate_hz.is_some()),
        ("force.taxels", mapping.force.taxels.is_some()),
        ("trial.category_from", mapping.trial.category_from.is_some()),
        ("trial.reach_from", mapping.trial.reach_from.is_some()),
    ];
    for (field, is_set) in not_for_mcap {
        mapping.refuse(field, is_set, "MCAP")?;
    }
    let Some(topic) = &mapping.force.topic else {
        return Err(mapping.fault("force.topic", "nothing".into(), "the topic of the forces"));
    };
    let mut reading = Reading {
        path,
        mapping,
        topic,
        schemas: BTreeMap::new(),
        decoders: BTreeMap::new(),
        topics: BTreeMap::new(),
        messages: 0,
        readings: Vec::new(),
        start: None,
    };
    read_records(path, |record| reading.record(record, cutter))?;
    if reading.messages == 0 {
        let topics = reading.topics.iter().map(|(topic, schema)| format!("{topic} ({schema})"));
        let topics = topics.collect::<Vec<_>>().join(", ");
        let allowed = format!("a topic of {} with messages: {topics}", path.display());
        return Err(mapping.fault("force.topic", format!("{topic:?}, which has no message"), allowed));
    }
    Ok(())
}
