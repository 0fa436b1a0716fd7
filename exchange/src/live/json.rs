//! Reads JSON key by key, so that an error can name the field and quote its value.

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
}

/// A value with its path in the line.
#[derive(Clone)]
pub struct Spot<'a> {
    pub path: String,
    pub value: &'a Value,
}

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

/// Largest number of characters of a line that an error quotes.
const MAX_QUOTED: usize = 60;

/// Reads a whole line as one value.
pub fn parse(text: &str) -> Result<Value, LineError> {
    let parsed: Result<Unique, serde_json::Error> = serde_json::from_str(text);
    parsed.map(|Unique(value)| value).map_err(|error| {
        let message = error.to_string();
        // serde's line number is always 1; the answer gives the line's number in the stream.
        let cause = message.rsplit_once(" at line ").map_or(&*message, |(cause, _)| cause);
        let found = format!("{cause} at byte {} of {}", error.column(), shortened(text, MAX_QUOTED));
        LineError::new("line", found, "one JSON object, each key once")
    })
}

impl<'a> Spot<'a> {
    /// The value, if it is an object.
    pub fn object(self, allowed: &str) -> Result<Self, LineError> {
        if self.value.is_object() { Ok(self) } else { Err(self.error(allowed)) }
    }

    /// The value of a key of an object; `None` if there is none or it is null.
    pub fn get(&self, key: &str) -> Option<Spot<'a>> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        Some(Spot { path: self.path_of(key), value })
    }

    /// The value of a required key.
    pub fn need(&self, key: &str, allowed: &str) -> Result<Spot<'a>, LineError> {
        self.get(key).ok_or_else(|| LineError::new(self.path_of(key), "nothing", allowed))
    }

    /// All keys of an object.
    pub fn keys(&self) -> impl Iterator<Item = &'a String> {
        self.value.as_object().into_iter().flat_map(Map::keys)
    }

    /// The error for a key that is not allowed.
    pub fn unknown(&self, key: &str, allowed: String) -> LineError {
        LineError::new(&self.path, format!("key {:?}", shortened(key, MAX_QUOTED)), allowed)
    }

    fn path_of(&self, key: &str) -> String {
        let dot = if self.path.is_empty() { "" } else { "." };
        format!("{}{dot}{key}", self.path)
    }

    /// The value as a list.
    pub fn list(&self, allowed: &str) -> Result<Vec<Spot<'a>>, LineError> {
        let values = self.value.as_array().ok_or_else(|| self.error(allowed))?;
        let spot = |(index, value)| Spot { path: format!("{}[{index}]", self.path), value };
        Ok(values.iter().enumerate().map(spot).collect())
    }

    /// The value as a list of `N` numbers.
    pub fn numbers<const N: usize>(&self, allowed: &str) -> Result<[f64; N], LineError> {
        let numbers = Vec::<f64>::deserialize(self.value).ok().and_then(|numbers| numbers.try_into().ok());
        numbers.ok_or_else(|| self.error(allowed))
    }

    /// The value as a whole number from 0; `None` if it is something else.
    pub fn index(&self) -> Option<usize> {
        usize::try_from(self.value.as_u64()?).ok()
    }

    /// The error for this value.
    pub fn error(&self, allowed: impl Into<String>) -> LineError {
        let field = if self.path.is_empty() { "line" } else { &self.path };
        LineError::new(field, shortened(&self.value.to_string(), MAX_QUOTED), allowed)
    }
}
