//! Whether arrays and tables of a TOML file are where a JSON Schema asks for them, and arrays no longer than it allows.
//!
//! The parser drops what follows the last element that a type takes (`[0.02, 0.03, 0.04]` for two numbers), and takes an
//! array for a table, by position. Both hide mistakes.

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The first place at which a file's text has another shape than this schema, as the byte there and a message. The text was
/// parsed before as what the schema describes, so only shapes are looked at.
pub(crate) fn misfit(schema: &Value, text: &str) -> Option<(usize, String)> {
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
