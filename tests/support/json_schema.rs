//! Validates JSON values against a JSON Schema, for the keywords that this project's schemas use. It shares no code
//! with schemars, which makes the schemas, nor with serde, which reads the files.
//!
//! It is written here because the validators on crates.io turn on features of crates under the physics engine, so that
//! the tests would compile the engine a second time.

use serde_json::Value;

/// The places where a value violates the schema, each with the keyword.
pub fn faults(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, schema, value, "", &mut found);
    found
}

fn check(root: &Value, schema: &Value, value: &Value, place: &str, found: &mut Vec<String>) {
    let Value::Object(keywords) = schema else {
        if *schema == Value::Bool(false) {
            found.push(format!("{place}: nothing is allowed here"));
        }
        return;
    };
    let holds = |schema: &Value| {
        let mut found = Vec::new();
        check(root, schema, value, place, &mut found);
        found.is_empty()
    };
    let is_kind = |kind: &Value| match kind.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("unknown type {other}"),
    };
    let count = |argument: &Value| argument.as_u64().unwrap() as usize;
    for (keyword, argument) in keywords {
        let list = || argument.as_array().unwrap().iter();
        let is_met = match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" | "default" | "format" | "then" | "properties" => true,
            "$ref" => {
                let definition = root.pointer(&argument.as_str().unwrap()[1..]).unwrap();
                check(root, definition, value, place, found);
                true
            }
            "allOf" => {
                list().for_each(|part| check(root, part, value, place, found));
                true
            }
            "if" => {
                if holds(argument) {
                    check(root, &keywords["then"], value, place, found);
                }
                true
            }
            "anyOf" => list().any(holds),
            "oneOf" => list().filter(|part| holds(part)).count() == 1,
            "prefixItems" => {
                for (index, (part, item)) in list().zip(value.as_array().into_iter().flatten()).enumerate() {
                    check(root, part, item, &format!("{place}/{index}"), found);
                }
                true
            }
            "type" => argument.as_array().map_or_else(|| is_kind(argument), |kinds| kinds.iter().any(is_kind)),
            "pattern" => {
                let pattern = regex_lite::Regex::new(argument.as_str().unwrap()).unwrap();
                value.as_str().is_none_or(|text| pattern.is_match(text))
            }
            "const" => value == argument,
            "enum" => list().any(|allowed| allowed == value),
            "minimum" => value.as_f64().is_none_or(|number| number >= argument.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|number| number <= argument.as_f64().unwrap()),
            "minItems" => value.as_array().is_none_or(|items| items.len() >= count(argument)),
            "maxItems" => value.as_array().is_none_or(|items| items.len() <= count(argument)),
            "minProperties" => value.as_object().is_none_or(|entries| entries.len() >= count(argument)),
            "uniqueItems" => value
                .as_array()
                .is_none_or(|items| (1..items.len()).all(|index| !items[..index].contains(&items[index]))),
            "required" => {
                value.as_object().is_none_or(|entries| list().all(|key| entries.contains_key(key.as_str().unwrap())))
            }
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, argument, item, &format!("{place}/{index}"), found);
                }
                true
            }
            "additionalProperties" => {
                let known = keywords.get("properties").and_then(Value::as_object);
                let entries = value.as_object().into_iter().flatten();
                for (key, entry) in entries.filter(|(key, _)| !known.is_some_and(|known| known.contains_key(*key))) {
                    check(root, argument, entry, &format!("{place}/{key}"), found);
                }
                true
            }
            other => panic!("the judge does not know the keyword {other}"),
        };
        if !is_met {
            found.push(format!("{place}: {keyword} {argument}"));
        }
    }
    for (key, part) in keywords.get("properties").and_then(Value::as_object).into_iter().flatten() {
        if let Some(entry) = value.get(key) {
            check(root, part, entry, &format!("{place}/{key}"), found);
        }
    }
}

/// Tests that the validator finds each kind of fault, and panics at a keyword that it does not know instead of ignoring
/// it.
#[test]
fn the_judge_finds_faults() {
    use serde_json::json;
    let schema = json!({
        "type": "object",
        "properties": { "count": { "type": "integer", "minimum": 1 }, "names": { "items": { "enum": ["leaf"] } } },
        "additionalProperties": false,
        "required": ["count"],
    });
    assert!(faults(&schema, &json!({ "count": 1, "names": ["leaf"] })).is_empty());
    for (broken, place) in [
        (json!({ "count": 0 }), "/count"),
        (json!({ "count": 1.5 }), "/count"),
        (json!({ "count": 1, "names": ["leaf", "trunk"] }), "/names/1"),
        (json!({ "count": 1, "depth": 2 }), "/depth"),
        (json!({}), ""),
        (json!([]), ""),
    ] {
        let found = faults(&schema, &broken);
        assert!(found.len() == 1 && found[0].starts_with(&format!("{place}:")), "{broken}: {found:?}");
    }
    let unknown = json!({ "exclusiveMinimum": 0 });
    assert!(std::panic::catch_unwind(|| faults(&unknown, &json!(1))).is_err());
}
