//! JSON that a person can read.

use serde_json::Value;

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

pub(super) fn write_object<'a>(entries: impl Iterator<Item = (&'a str, &'a Value)>, indent: usize, text: &mut String) {
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
