//! Reads text files in TOML. Errors have the line, the key, and words that a reader of the file can understand.

use std::path::Path;

use schemars::{JsonSchema, SchemaGenerator};
use serde::de::DeserializeOwned;

use crate::InputError;
use crate::text_line::line_at;
use crate::toml_shape::misfit;

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

/// What was found and what was expected instead, as a parser's message says, with Rust's types of numbers in words. The two are
/// separated only for values of a wrong type or shape. Other messages stay whole: they may list many names, and those about spelling do
/// not say all that is allowed.
fn in_words(message: &str) -> (&str, Option<&str>) {
    let is_value =
        |found: &str| ["invalid type", "invalid value", "an array", "a table"].iter().any(|own| found.starts_with(own));
    match message.split_once(", expected ").filter(|(found, _)| is_value(found)) {
        None => (message, None),
        Some((found, "u8")) => (found, Some("a whole number from 0 to 255")),
        Some((found, "u16")) => (found, Some("a whole number from 0 to 65535")),
        Some((found, "u32" | "u64" | "usize")) => (found, Some("a whole number, 0 or more")),
        Some((found, "i32" | "i64")) => (found, Some("a whole number")),
        Some((found, "f32" | "f64")) => (found, Some("a number")),
        Some((found, expected)) => (found, Some(expected)),
    }
}

/// Parses the text of a file. `kind` is what it holds, such as `scene`, and `allowed` what it may hold.
///
/// # Errors
/// [`InputError`] with the line and the key for text that is not TOML, unknown keys, and values of another type. Arrays must not be
/// longer than their type, and are not taken for tables.
pub fn parse_toml<T>(path: &Path, text: &str, kind: &str, allowed: &str) -> Result<T, InputError>
where
    T: DeserializeOwned + JsonSchema,
{
    let parsed = toml::from_str(text).map_err(|error| {
        let start = error.span().unwrap_or_default().start;
        toml_fault(path, text, kind, (error.message(), start), allowed)
    })?;
    let schema = SchemaGenerator::default().into_root_schema_for::<T>();
    match misfit(schema.as_value(), text) {
        Some((place, message)) => Err(toml_fault(path, text, kind, (&message, place), allowed)),
        None => Ok(parsed),
    }
}

/// An error about the text of a file, from the message of the parser and the byte at which it stopped.
fn toml_fault(path: &Path, text: &str, kind: &str, (message, offset): (&str, usize), allowed: &str) -> InputError {
    let key = key_at(text, offset);
    let field = if key.is_empty() { kind.to_owned() } else { format!("{kind}, {key}") };
    let (found, expected) = in_words(message);
    let (allowed, remedy) = match message {
        "duplicate key" => ("each key once", "remove one of the two"),
        _ => (expected.unwrap_or(allowed), "correct this line"),
    };
    InputError::new(path, field, found, allowed, remedy).at_line(line_at(text, offset))
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
        assert_eq!(found, ("invalid value: integer `-3`", Some("a whole number, 0 or more")));
        for message in [
            "unknown field `heigth_m`, expected one of `height_m`",
            "missing field `count`",
            "invalid boolean, expected `true`",
        ] {
            assert_eq!(in_words(message), (message, None));
        }
    }
}
