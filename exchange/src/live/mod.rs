//! The live stream: frames of a skin as lines of JSON (docs/live-stream.md).

mod json;
mod line;
mod lines;

pub use json::LineError;
pub use line::{LineParser, Message};
pub use lines::Lines;
