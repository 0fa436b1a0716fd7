//! A line as JSON, and errors that name a field and quote its value.

use serde::Serialize;
use serde_json::Value;
use underbrush_recording::shortened;

/// What is wrong with a line, as printed in the answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LineError {
    /// The field, for instance `taxels[3].sensed_force_n`.
    pub field: String,
    /// What was found.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
}

impl LineError {
    pub(super) fn new(field: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        LineError { field: field.into(), found: found.into(), allowed: allowed.into() }
    }

    /// The error for a value, which is null if it is missing.
    pub(super) fn at(field: impl Into<String>, value: &Value, allowed: impl Into<String>) -> Self {
        let found = if value.is_null() { "nothing".to_owned() } else { shortened(&value.to_string(), MAX_QUOTED) };
        LineError::new(field, found, allowed)
    }
}

/// Largest number of characters of a line that an error quotes.
pub const MAX_QUOTED: usize = 60;

/// Reads a whole line as one object.
pub fn parse(text: &str) -> Result<Value, LineError> {
    let parsed: Result<Value, serde_json::Error> = serde_json::from_str(text);
    let found = match parsed {
        Ok(line) if line.is_object() => return Ok(line),
        Ok(_) => shortened(text, MAX_QUOTED),
        Err(error) => {
            let message = error.to_string();
            // serde's line number is always 1; the answer gives the line's number in the stream.
            let cause = message.rsplit_once(" at line ").map_or(&*message, |(cause, _)| cause);
            format!("{cause} at byte {} of {}", error.column(), shortened(text, MAX_QUOTED))
        }
    };
    Err(LineError::new("line", found, "one JSON object"))
}
