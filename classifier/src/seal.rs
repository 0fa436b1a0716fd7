//! The text of model files of both kinds, JSON that a person can read, and its seal: a hash over everything else in the file,
//! so that damage is noticed.
//!
//! A model file is text that people and other programs edit, so the hash covers the content and not the bytes: the order
//! of keys, white space and the spelling of a number (`1`, `1.0` or `10e-1`) do not matter.

use std::collections::BTreeMap;
use std::path::Path;

use blake3::Hasher;
use schemars::Schema;
use serde_json::{Map, Value, json};
use underbrush_recording::InputError;

/// The key of the hash.
pub(crate) const KEY: &str = "blake3";

/// Whole numbers up to here are the same as an integer and in double precision.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// The hash over all keys except [`KEY`], hexadecimal.
pub(crate) fn of<'a>(entries: impl IntoIterator<Item = (&'a str, &'a Value)>) -> String {
    let mut hasher = Hasher::new();
    add_object(&mut hasher, entries.into_iter().filter(|(key, _)| *key != KEY));
    hasher.finalize().to_hex().to_string()
}

/// Checks the hash in a file. A file without one is used, with a warning.
pub(crate) fn check(path: &Path, file: &Map<String, Value>) -> Result<(), InputError> {
    let Some(stored) = file.get(KEY) else {
        log::warn!(
            "warning: {}: this model has no seal (the key {KEY}), so damage to the file cannot be noticed",
            path.display()
        );
        return Ok(());
    };
    let found = of(file.iter().map(|(key, value)| (key.as_str(), value)));
    if stored.as_str() == Some(&found) {
        return Ok(());
    }
    let stored = stored.as_str().map_or_else(|| stored.to_string(), str::to_owned);
    let remedy = "copy the file again if it is damaged; delete this key to use a file that was edited by hand";
    let found = format!("a file whose content has the hash {found}");
    Err(InputError::new(path, KEY, found, stored, remedy))
}

/// Adds the key to the JSON Schema of a model file.
pub(crate) fn describe(schema: &mut Schema) {
    let key = json!({
        "description": "BLAKE3 hash over the rest of the file. Delete this key to use a file that you have edited.",
        "type": "string",
    });
    if let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        properties.insert(KEY.into(), key);
    }
}

fn add_object<'a>(hasher: &mut Hasher, entries: impl Iterator<Item = (&'a str, &'a Value)>) {
    hasher.update(b"{");
    for (key, value) in entries.collect::<BTreeMap<_, _>>() {
        add(hasher, &json!(key));
        hasher.update(b":");
        add(hasher, value);
        hasher.update(b",");
    }
    hasher.update(b"}");
}

fn add(hasher: &mut Hasher, value: &Value) {
    match value {
        Value::Object(entries) => add_object(hasher, entries.iter().map(|(key, value)| (key.as_str(), value))),
        Value::Array(items) => {
            hasher.update(b"[");
            for item in items {
                add(hasher, item);
                hasher.update(b",");
            }
            hasher.update(b"]");
        }
        plain => {
            hasher.update(spelled(plain).as_bytes());
        }
    }
}

/// A plain value as text, with one spelling of each number.
fn spelled(value: &Value) -> String {
    match value.as_f64().filter(|_| value.is_f64()) {
        Some(number) if number.fract() == 0.0 && number.abs() <= LARGEST_WHOLE => format!("{number:.0}"),
        _ => value.to_string(),
    }
}

/// The order of keys in a file, which ends in the seal: short entries first, for readability.
const ORDER: &str = "format classifier categories features recipe options decision provenance scaling models parameters \
                     training touched category of_objects unknown_objects stiffness";

/// The text of a file with these entries and their seal. Empty entries are left out.
pub(crate) fn sealed(mut entries: Vec<(&str, Value)>) -> String {
    entries.retain(|(_, value)| !value.is_null() && *value != json!({}));
    let hash = of(entries.iter().map(|(key, value)| (*key, value)));
    entries.sort_by_key(|(key, _)| ORDER.split(' ').position(|known| known == *key));
    entries.push((KEY, hash.into()));
    let mut text = String::new();
    write_object(entries.iter().map(|(key, value)| (*key, value)), 0, &mut text);
    text.push('\n');
    text
}

/// Indented JSON with lists of plain values on one line, so that a matrix looks like one.
fn write_value(value: &Value, indent: usize, text: &mut String) {
    match value {
        Value::Object(object) if !object.is_empty() => {
            write_object(object.iter().map(|(key, value)| (key.as_str(), value)), indent, text);
        }
        Value::Array(items) if items.iter().any(|item| item.is_array() || item.is_object()) => {
            text.push('[');
            for (index, item) in items.iter().enumerate() {
                new_line(index > 0, indent + 1, text);
                write_value(item, indent + 1, text);
            }
            new_line(false, indent, text);
            text.push(']');
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(Value::to_string).collect();
            text.push_str(&format!("[{}]", items.join(", ")));
        }
        plain => text.push_str(&plain.to_string()),
    }
}

fn write_object<'a>(entries: impl Iterator<Item = (&'a str, &'a Value)>, indent: usize, text: &mut String) {
    text.push('{');
    for (index, (key, value)) in entries.enumerate() {
        new_line(index > 0, indent + 1, text);
        text.push_str(&format!("{}: ", Value::from(key)));
        write_value(value, indent + 1, text);
    }
    new_line(false, indent, text);
    text.push('}');
}

fn new_line(comma: bool, indent: usize, text: &mut String) {
    text.push_str(if comma { ",\n" } else { "\n" });
    text.push_str(&"  ".repeat(indent));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> Map<String, Value> {
        serde_json::from_str(text).unwrap()
    }

    fn hash(text: &str) -> String {
        of(file(text).iter().map(|(key, value)| (key.as_str(), value)))
    }

    /// Tests that the seal does not depend on the order of keys, white space or how a number or a letter is written.
    #[test]
    fn what_editors_change_does_not_break_the_seal() {
        let own = hash(r#"{"a": [1.0, 0.1, 1e300, -0.0], "b": {"c": "ü", "d": null}}"#);
        for same in [
            r#"{"b":{"d":null,"c":"ü"},"a":[1,0.1,1E+300,-0]}"#,
            "{\n \"a\": [10e-1, 1.0e-1, 1.0e300, -0.0], \"b\": {\"c\": \"\\u00fc\", \"d\": null}, \"blake3\": \"1\"}",
        ] {
            assert_eq!(hash(same), own, "{same}");
        }
    }

    /// Tests that every change of the content changes the seal.
    #[test]
    fn a_change_of_the_content_breaks_the_seal() {
        let own = hash(r#"{"a": [1, 0], "b": "12"}"#);
        for other in [
            r#"{"a": [1, -0.0], "b": "12"}"#,
            r#"{"a": [1.0000000000000002, 0], "b": "12"}"#,
            r#"{"a": [1, 0], "b": 12}"#,
            r#"{"a": [[1], 0], "b": "12"}"#,
            r#"{"a": [1, 0], "b": "12", "c": null}"#,
            r#"{"a": [1, 0, "b"], "": "12"}"#,
        ] {
            assert_ne!(hash(other), own, "{other}");
        }
        // Whole numbers that double precision cannot tell apart.
        assert_ne!(hash(r#"{"seed": 9007199254740993}"#), hash(r#"{"seed": 9007199254740992}"#));
    }

    /// Tests that a wrong seal is refused with the key and the remedy.
    #[test]
    fn a_wrong_seal_is_refused() {
        let text = r#"{"a": 1, "blake3": "00"}"#;
        let error = check(Path::new("m.json"), &file(text)).unwrap_err();
        assert_eq!((error.field.as_str(), error.allowed.as_str()), ("blake3", "00"));
        assert!(error.remedy.contains("delete this key"), "{error}");
        let sealed = text.replace("00", &hash(text));
        check(Path::new("m.json"), &file(&sealed)).unwrap();
    }
}
