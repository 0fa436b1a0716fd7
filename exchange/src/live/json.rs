//! A line as JSON, and errors that name a field and quote its value.

use std::fmt;

use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
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

/// A value in which no object has a key twice. With two values it would be unclear which one is meant.
struct Unique(Value);

/// Visits of values that hold no others.
macro_rules! plain {
    ($($visit:ident: $of:ty),*) => {
        $(fn $visit<E: Error>(self, value: $of) -> Result<Unique, E> {
            Ok(Unique(value.into()))
        })*
    };
}

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyValue;
        impl<'de> Visitor<'de> for AnyValue {
            type Value = Unique;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("JSON")
            }

            fn visit_unit<E: Error>(self) -> Result<Unique, E> {
                Ok(Unique(Value::Null))
            }

            plain!(visit_bool: bool, visit_i64: i64, visit_u64: u64, visit_f64: f64, visit_str: &str);

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Unique, A::Error> {
                let mut values = Vec::new();
                while let Some(Unique(value)) = list.next_element()? {
                    values.push(value);
                }
                Ok(Unique(values.into()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Unique, A::Error> {
                let mut entries = Map::new();
                while let Some((key, Unique(value))) = map.next_entry::<String, Unique>()? {
                    if entries.contains_key(&key) {
                        return Err(A::Error::custom(format!("key {:?} more than once", shortened(&key, MAX_QUOTED))));
                    }
                    entries.insert(key, value);
                }
                Ok(Unique(entries.into()))
            }
        }
        deserializer.deserialize_any(AnyValue)
    }
}

/// Reads a whole line as one object.
pub fn parse(text: &str) -> Result<Value, LineError> {
    let parsed: Result<Unique, serde_json::Error> = serde_json::from_str(text);
    let found = match parsed {
        Ok(Unique(line)) if line.is_object() => return Ok(line),
        Ok(_) => shortened(text, MAX_QUOTED),
        Err(error) => {
            let message = error.to_string();
            // serde's line number is always 1; the answer gives the line's number in the stream.
            let cause = message.rsplit_once(" at line ").map_or(&*message, |(cause, _)| cause);
            format!("{cause} at byte {} of {}", error.column(), shortened(text, MAX_QUOTED))
        }
    };
    Err(LineError::new("line", found, "one JSON object, each key once"))
}
