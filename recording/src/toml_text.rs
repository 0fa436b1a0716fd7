//! Reads text files in TOML. Errors have the line, the key, and words that a reader of the file can understand. For
//! errors that are found after parsing, the line of a key can be looked up.
//!
//! The parser drops what follows the last element that a type takes (`[0.02, 0.03, 0.04]` for two numbers), and takes an
//! array for a table, by position. Both hide mistakes. Therefore a parsed file is also compared with its JSON Schema: arrays
//! and tables must stand where the schema has them, and no array may be longer than the schema allows.

use std::path::Path;

use schemars::{JsonSchema, SchemaGenerator};
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::{InputError, line_at};

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

/// What was found and what was expected instead, as a parser's message says, with Rust's types in words. The two are separated for
/// values of a wrong type or shape, and where our own types say what is allowed. Other messages stay whole: they may list many names,
/// and those about spelling do not say all that is allowed.
fn in_words(message: &str) -> (&str, Option<&str>) {
    if let Some((found, allowed)) = message.split_once("; allowed are ") {
        return (found, Some(allowed));
    }
    let values = ["invalid type", "invalid value", "invalid length", ARRAY, TABLE];
    let is_value = |found: &str| values.iter().any(|own| found.starts_with(own));
    let parts = message.split_once(", expected ").filter(|(found, _)| is_value(found));
    let named = |found| match found {
        "invalid type: map" => TABLE,
        "invalid type: sequence" => ARRAY,
        _ => found,
    };
    match parts.map(|(found, expected)| (named(found.trim_end_matches(" as i128")), expected)) {
        None => (message.strip_suffix(", expected literal string").unwrap_or(message), None),
        Some((found, "u8")) => (found, Some("a whole number from 0 to 255")),
        Some((found, "u16")) => (found, Some("a whole number from 0 to 65535")),
        Some((found, "u32")) => (found, Some("a whole number from 0 to 4294967295")),
        Some((found, "u64" | "usize")) => (found, Some("a whole number from 0 to 18446744073709551615")),
        Some((found, "i32" | "i64")) => (found, Some("a whole number")),
        Some((found, "f32" | "f64")) => (found, Some("a number")),
        Some((found, "a sequence")) => (found, Some(ARRAY)),
        Some((found, "a map")) => (found, Some(TABLE)),
        Some((found, expected)) if expected.starts_with("struct ") => (found, Some(TABLE)),
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
    let schema = SchemaGenerator::default().into_root_schema_for::<T>();
    let misfit = misfit(schema.as_value(), text);
    let (message, place) = match (toml::from_str(text), misfit) {
        (Ok(parsed), None) => return Ok(parsed),
        (Ok(_), Some((place, message))) => (message, Some(place)),
        // Where a list of tables stands for a table, the parser's error is about the first key of that table.
        (Err(_), Some((place, message))) if message.starts_with(ARRAY) && line_of(text, place).starts_with("[[") => {
            (message, Some(place))
        }
        (Err(error), _) => {
            // What the whole file lacks is at no place.
            let span = error.span().filter(|span| span.end > 0);
            (error.message().to_owned(), span.map(|span| span.start))
        }
    };
    Err(toml_fault(path, text, kind, (&message, place), allowed))
}

/// The line at this byte of the text, without the space around it.
fn line_of(text: &str, offset: usize) -> &str {
    text.lines().nth(line_at(text, offset) - 1).unwrap_or_default().trim()
}

/// What is allowed where the text is no TOML at all.
const SPELLING: &str =
    "TOML: a line is `key = value` or `[table]`, text is in quotes, and numbers have a decimal point";
/// What is allowed where the header of a table is there twice.
const ONCE: &str = "each table once; of a list of tables, each header has double brackets, `[[…]]`";

/// An error about the text of a file, from the message of the parser and the byte at which it stopped, if it is about one.
fn toml_fault(path: &Path, text: &str, kind: &str, (message, at): (&str, Option<usize>), allowed: &str) -> InputError {
    let key = at.map(|place| key_at(text, place)).filter(|key| !key.is_empty());
    let field = key.map_or(kind.to_owned(), |key| format!("{kind}, {key}"));
    let (found, expected) = in_words(message);
    let line = at.map_or("", |place| line_of(text, place));
    let remedy = if at.is_some() { "correct this line" } else { "correct the file" };
    let (allowed, remedy) = match (found, expected) {
        ("duplicate key", _) if line.starts_with('[') => (ONCE, remedy),
        ("duplicate key", _) => ("each key once", "remove one of the two"),
        (ARRAY, _) if line.starts_with("[[") => ("a single table: its header has single brackets, `[…]`", remedy),
        (TABLE, Some(ARRAY)) if line.starts_with('[') => ("a list of tables: each header has `[[…]]`", remedy),
        (_, Some(expected)) => (expected, remedy),
        (_, None) if DeTable::parse(text).is_err() => (SPELLING, remedy),
        (_, None) => (allowed, remedy),
    };
    InputError::new(path, field, found, allowed, remedy).at_line(at.map(|place| line_at(text, place)))
}

/// The first place at which a file's text has another shape than this schema, as the byte there and a message. Only shapes are
/// looked at: the rest is the parser's.
fn misfit(schema: &Value, text: &str) -> Option<(usize, String)> {
    let table = DeTable::parse(text).ok()?;
    let span = table.span();
    misfit_within(schema, schema, &Spanned::new(span, DeValue::Table(table.into_inner())), false)
}

const ARRAY: &str = "an array";
const TABLE: &str = "a table";
const SINGLE: &str = "a single value";

/// The shape of a type of JSON Schema.
fn kind_of(name: &str) -> &'static str {
    match name {
        "array" => ARRAY,
        "object" => TABLE,
        _ => SINGLE,
    }
}

/// As [`misfit`], of a part of the schema `root`, within which references are found. Unknown keys tell choices apart;
/// otherwise the parser has accepted them.
fn misfit_within(root: &Value, schema: &Value, value: &Spanned<DeValue>, is_choice: bool) -> Option<(usize, String)> {
    if let Some(name) = schema["$ref"].as_str() {
        return misfit_within(root, root.pointer(name.trim_start_matches('#'))?, value, is_choice);
    }
    for choices in [&schema["oneOf"], &schema["anyOf"]].into_iter().filter_map(Value::as_array) {
        // Where no choice fits, the one that fits the furthest is meant.
        let misfits: Option<Vec<_>> = choices.iter().map(|choice| misfit_within(root, choice, value, true)).collect();
        if let Some(furthest) = misfits.and_then(|all| all.into_iter().max_by_key(|(place, _)| *place)) {
            return Some(furthest);
        }
    }
    let fault = |found: String, expected: &str| Some((value.span().start, format!("{found}, expected {expected}")));
    let kinds = match &schema["type"] {
        Value::Array(kinds) => kinds.as_slice(),
        Value::Null => &[],
        kind => std::slice::from_ref(kind),
    };
    let wanted: Vec<&str> = kinds.iter().filter_map(Value::as_str).map(kind_of).collect();
    let is_wanted = |kind: &str| wanted.is_empty() || wanted.contains(&kind);
    match value.get_ref() {
        DeValue::Array(_) if !is_wanted(ARRAY) => fault(ARRAY.into(), wanted[0]),
        DeValue::Table(_) if !is_wanted(TABLE) => fault(TABLE.into(), wanted[0]),
        DeValue::Array(all) => {
            if let Some(most) = schema["maxItems"].as_u64().filter(|most| all.len() as u64 > *most) {
                return fault(format!("{ARRAY} of {}", all.len()), &format!("{ARRAY} of {most}"));
            }
            let schema_of = |place: usize| schema["prefixItems"].get(place).unwrap_or(&schema["items"]);
            all.iter().enumerate().find_map(|(place, own)| misfit_within(root, schema_of(place), own, is_choice))
        }
        DeValue::Table(table) => table.iter().find_map(|(key, own)| {
            let others = &schema["additionalProperties"];
            match schema["properties"].get(key.get_ref().as_ref()) {
                Some(schema) => misfit_within(root, schema, own, is_choice),
                None if others == false => {
                    is_choice.then(|| (key.span().start, format!("unknown field `{}`", key.get_ref())))
                }
                None => misfit_within(root, others, own, is_choice),
            }
        }),
        // The parser takes single values for nothing else.
        _ => None,
    }
}

/// The line at which a file sets a field such as `goals.count` or `objects.leaf[1].height_m`, counted from 1; `None` if it does
/// not.
pub fn line_setting(text: &str, field: &str) -> Option<usize> {
    line_giving(text, field, &|_| true)
}

/// The line at which a file gives a field a value whose text is the one that is looked for. Where `field` names a list of
/// tables without a number, this is in the first table that gives such a value.
pub fn line_giving(text: &str, field: &str, is_value: &dyn Fn(&str) -> bool) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let is_value = |value: &Spanned<DeValue>| is_value(&text[value.span()]);
    Some(line_at(text, place(table.get_ref(), field, &is_value)?))
}

/// The byte at which a table gives a field such a value.
fn place(table: &DeTable, field: &str, is_value: &dyn Fn(&Spanned<DeValue>) -> bool) -> Option<usize> {
    let (first, rest) = field.split_once('.').map_or((field, None), |(first, rest)| (first, Some(rest)));
    let numbered = first.strip_suffix(']').and_then(|first| first.split_once('['));
    let (name, number) = numbered.map_or((first, None), |(name, number)| (name, number.parse::<usize>().ok()));
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == name)?;
    let within = |value: &Spanned<DeValue>| match (value.get_ref(), rest) {
        (DeValue::Table(table), Some(rest)) => place(table, rest, is_value),
        (_, Some(_)) => None,
        (_, None) => is_value(value).then(|| value.span().start),
    };
    match (value.get_ref(), number) {
        (DeValue::Array(all), Some(number)) => within(all.get(number)?),
        (DeValue::Array(all), None) if rest.is_some() => all.iter().find_map(within),
        _ => within(value).map(|place| if rest.is_none() { key.span().start } else { place }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file whose lines are looked up.
    const TEXT: &str = "top = { inner = 1 }\nstates = [5, 10]\n\n[goals]\ncount = 4\n\"quoted\" = 2\n\n[[objects.leaf]]\ncount = 3\n\n\
                        [[objects.leaf]]\nplace.x_m = 0.5\ncount_of_all = 1\ncount = 1_0.0\n";

    /// Tests that no error names a number type of Rust, and that other messages stay as they are.
    #[test]
    fn types_are_named_in_words() {
        for (message, found, allowed) in [
            ("integer `-3`, expected u32", "integer `-3`", "a whole number from 0 to 4294967295"),
            ("integer `99` as i128, expected u8", "integer `99`", "a whole number from 0 to 255"),
            ("integer `3`, expected struct GoalsTable", "integer `3`", "a table"),
            ("integer `3`, expected a sequence", "integer `3`", "an array"),
        ] {
            let [message, found] = [message, found].map(|text| format!("invalid type: {text}"));
            assert_eq!(in_words(&message), (found.as_str(), Some(allowed)));
        }
        for (message, found, allowed) in [
            ("invalid type: map, expected a string", "a table", "a string"),
            ("invalid type: sequence, expected a map", "an array", "a table"),
            ("invalid length 2, expected struct Place with 3 elements", "invalid length 2", "a table"),
            ("category \"Reed\"; allowed are small letters", "category \"Reed\"", "small letters"),
        ] {
            assert_eq!(in_words(message), (found, Some(allowed)));
        }
        for message in [
            "unknown field `heigth_m`, expected one of `height_m`",
            "missing field `count`",
            "invalid boolean, expected `true`",
        ] {
            assert_eq!(in_words(message), (message, None));
        }
    }

    /// Tests that a field is found under its table, in inline tables, as a dotted or quoted key and by its number in a list,
    /// and that a longer key is not taken for it.
    #[test]
    fn a_field_is_found_where_it_is_set() {
        let lines = [
            ("top.inner", Some(1)),
            ("states", Some(2)),
            ("goals", Some(4)),
            ("goals.count", Some(5)),
            ("goals.quoted", Some(6)),
            ("objects.leaf[0]", Some(8)),
            ("objects.leaf[0].count", Some(9)),
            ("objects.leaf[1]", Some(11)),
            ("objects.leaf[1].place.x_m", Some(12)),
            ("objects.leaf[1].count", Some(14)),
            ("objects.leaf.count", Some(9)),
            ("objects.leaf[2].count", None),
            ("goals.retries", None),
            ("inner", None),
        ];
        for (field, line) in lines {
            assert_eq!(line_setting(TEXT, field), line, "{field}");
        }
    }

    /// Tests that of a list of tables the one with the value counts.
    #[test]
    fn a_value_is_found_in_the_table_that_gives_it() {
        assert_eq!(line_giving(TEXT, "objects.leaf.count", &|text| text == "1_0.0"), Some(14));
        assert_eq!(line_giving(TEXT, "states", &|text| text.contains("10")), Some(2));
        assert_eq!(line_giving(TEXT, "objects.leaf.count", &|text| text == "7"), None);
    }

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
}
