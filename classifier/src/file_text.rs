//! The text of model files of both kinds: JSON that a person can read, with a seal.

use serde_json::{Value, json};

use crate::seal;

/// The order of keys in a file: short entries first, for readability.
const ORDER: [&str; 18] = [
    "format",
    "classifier",
    "categories",
    "features",
    "recipe",
    "options",
    "decision",
    "provenance",
    "scaling",
    "models",
    "parameters",
    "training",
    "touched",
    "category",
    "of_objects",
    "unknown_objects",
    "stiffness",
    seal::KEY,
];

/// The text of a file with these entries and their seal. Empty entries are left out.
pub(crate) fn sealed(mut entries: Vec<(&str, Value)>) -> String {
    entries.retain(|(_, value)| !value.is_null() && *value != json!({}));
    let hash = seal::of(entries.iter().map(|(key, value)| (*key, value)));
    entries.push((seal::KEY, hash.into()));
    entries.sort_by_key(|(key, _)| ORDER.iter().position(|known| known == key));
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
