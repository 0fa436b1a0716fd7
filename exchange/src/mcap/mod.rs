//! MCAP, the container of messages of ROS 2 and Foxglove (<https://mcap.dev/spec>). Only the parts that are written and
//! read here are implemented. Chunks may be compressed with zstd; attachments are skipped. The crate `mcap` is not
//! used: it brings fifteen crates, among them two families of macros, which take ten times as long to build as this.

mod read;
#[cfg(test)]
mod tests;
mod write;

use std::collections::BTreeMap;

pub(crate) use read::{Fault, Item, Reader};
pub(crate) use write::Writer;

/// The bytes at both ends of a file.
const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Codes of records.
mod code {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0B;
    pub(super) const METADATA: u8 = 0x0C;
    pub(super) const METADATA_INDEX: u8 = 0x0D;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(super) const DATA_END: u8 = 0x0F;
}

/// The shape of the messages of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Schema {
    /// Number in the file, from 1.
    pub(crate) id: u16,
    /// Name, such as `sensor_msgs/msg/JointState`.
    pub(crate) name: String,
    /// Encoding of the definition, such as `ros2msg` or `jsonschema`.
    pub(crate) encoding: String,
    /// The definition.
    pub(crate) data: Vec<u8>,
}

/// A stream of messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Channel {
    /// Number in the file.
    pub(crate) id: u16,
    /// Number of the schema; 0 for none.
    pub(crate) schema_id: u16,
    /// Topic.
    pub(crate) topic: String,
    /// Encoding of the messages, such as `cdr` or `json`.
    pub(crate) message_encoding: String,
}

/// Facts of a metadata record, by name.
pub(crate) type Map = BTreeMap<String, String>;
