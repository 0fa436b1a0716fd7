//! Options that choose one of some names, options that are numbers, and which options are given.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use serde::de::value::Error as Unread;
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde_json::{Value, json};

use crate::Failure;

/// Reads one of these names, each with a line of help.
pub fn named<T>(names: &'static [(&'static str, &'static str)]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    let values = names.iter().map(|(name, help)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(values)
        .try_map(|name| T::deserialize(IntoDeserializer::<Unread>::into_deserializer(name)))
}

/// Reads a number that is allowed; the text says which numbers are.
pub fn number<T: FromStr + 'static>(
    is_allowed: fn(&T) -> bool,
    allowed: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| text.parse().ok().filter(is_allowed).ok_or_else(|| allowed.to_owned())
}

/// Two values with a sign between them, such as leaf=0.7; `None` if a text is anything else.
pub fn pair<A: FromStr, B: FromStr>(text: &str, sign: char) -> Option<(A, B)> {
    let (first, second) = text.split_once(sign)?;
    Some((first.parse().ok()?, second.parse().ok()?))
}

/// The options that are given, as they are written. Each field is an option of its name; what is not given is
/// `None`, `false` or empty.
pub fn given(options: &impl Serialize) -> Vec<String> {
    let options = serde_json::to_value(options).unwrap_or_default();
    let is_given = |value: &Value| !matches!(value, Value::Null | Value::Bool(false)) && *value != json!([]);
    let given = options.as_object().into_iter().flatten().filter(|(_, value)| is_given(value));
    given.map(|(name, _)| format!("--{}", name.replace('_', "-"))).collect()
}

/// Refuses the first of these options, for this reason.
///
/// # Errors
/// If there is one.
pub fn refuse(options: impl IntoIterator<Item = String>, reason: &str) -> Result<(), Failure> {
    match options.into_iter().next() {
        None => Ok(()),
        Some(option) => Err(Failure::usage(format!("{option} {reason}; leave it out"))),
    }
}
