//! Errors of text files in TOML: the line, the key, and what a reader of the file can understand.

use std::path::Path;

use crate::InputError;
use crate::text_line::line_at;

/// The key that the line at `offset` sets, preceded by the name of its table, such as `goals.count`. Empty if the line
/// sets none and no table is open.
fn key_at(text: &str, offset: usize) -> String {
    let number = line_at(text, offset);
    let is_header = |line: &&str| line.starts_with('[');
    let lines: Vec<&str> = text.lines().take(number).map(str::trim).collect();
    let line = lines.last().copied().unwrap_or_default();
    let table = lines.iter().rev().find(|line| is_header(line));
    let table = table.map_or("", |line| line.split(']').next().unwrap_or("").trim_start_matches('['));
    let key = match line.split_once('=') {
        Some((key, _)) if !is_header(&line) => key.trim_start_matches('{').trim(),
        _ => "",
    };
    let parts: Vec<&str> = [table, key].into_iter().filter(|part| !part.is_empty()).collect();
    parts.join(".")
}

/// A message of a parser, with the number types of Rust in words.
fn in_words(message: &str) -> String {
    let Some((found, expected)) = message.split_once(", expected ") else { return message.to_owned() };
    let words = match expected {
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "i32" | "i64" => "a whole number",
        "f32" | "f64" => "a number",
        other => other,
    };
    format!("{found}, expected {words}")
}

/// An error about the text of a file, from the message of the parser and the byte at which it stopped. `kind` is what the
/// file holds, such as `scene`.
pub fn toml_fault(path: &Path, text: &str, kind: &str, (message, offset): (&str, usize), allowed: &str) -> InputError {
    let key = key_at(text, offset);
    let field = if key.is_empty() { kind.to_owned() } else { format!("{kind}, {key}") };
    let (allowed, remedy) = match message {
        "duplicate key" => ("each key once", "remove one of the two"),
        _ => (allowed, "correct this line"),
    };
    InputError::new(path, field, in_words(message), allowed, remedy).at_line(line_at(text, offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the key of a line of a table, of one before all tables, of a header, and of an inline table.
    #[test]
    fn keys_are_named_with_their_table() {
        let text = "name = 1\n\n[[objects.leaf]]\n  count = 2\npoints = [\n    { position_m = 3 },\n]\n";
        for (part, key) in [
            ("1", "name"),
            ("[[objects", "objects.leaf"),
            ("2", "objects.leaf.count"),
            ("3 }", "objects.leaf.position_m"),
        ] {
            assert_eq!(key_at(text, text.find(part).unwrap()), key);
        }
    }

    /// Tests that no error names a number type of Rust, and that other messages stay as they are.
    #[test]
    fn types_are_named_in_words() {
        let found = in_words("invalid value: integer `-3`, expected u32");
        assert_eq!(found, "invalid value: integer `-3`, expected a whole number, 0 or more");
        for message in ["unknown field `heigth_m`, expected one of `height_m`", "missing field `count`"] {
            assert_eq!(in_words(message), message);
        }
    }
}
