//! The page about arm and skin files, and the arm that it builds as an example.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;
use underbrush_recording::limits::short;
use underbrush_sim::arm::{self, Arm};

use crate::support::underbrush;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// A JSON Schema in which references to definitions can be followed.
struct Schema(Value);

impl Schema {
    fn resolve<'a>(&'a self, mut schema: &'a Value) -> &'a Value {
        if let Some(first) = schema["anyOf"].get(0) {
            schema = first;
        }
        match schema["$ref"].as_str() {
            Some(reference) => self.0.pointer(&reference[1..]).unwrap(),
            None => schema,
        }
    }

    /// What a value of this schema is, in words, with the schema of its numbers.
    fn kind<'a>(&'a self, schema: &'a Value) -> (String, &'a Value) {
        let schema = self.resolve(schema);
        if let Some(names) = schema["oneOf"].as_array().filter(|names| names[0]["const"].is_string()) {
            let names: Vec<String> = names.iter().map(|name| format!("`{}`", name["const"])).collect();
            return (names.join(" or "), schema);
        }
        // An optional key is of its type or null; TOML has no null.
        let name = schema["type"].as_str().or_else(|| schema["type"][0].as_str()).unwrap();
        let plain = match name {
            "string" => "text",
            "integer" => "whole number",
            "boolean" => "true or false",
            "object" => "table",
            "array" => {
                let (kind, numbers) = self.kind(&schema["items"]);
                let list = match schema["maxItems"].as_u64() {
                    Some(count) if schema["minItems"].as_u64() == Some(count) => format!("{count} {kind}s"),
                    _ if kind.ends_with('s') => format!("list of {kind}"),
                    _ => format!("list of {kind}s"),
                };
                return (list, numbers);
            }
            other => other,
        };
        (plain.to_string(), schema)
    }

    /// The rows that a table of the page must have for an object.
    fn rows(&self, object: &Value) -> BTreeSet<String> {
        let needed = |key: &str| object["required"].as_array().unwrap().contains(&key.into());
        let properties = object["properties"].as_object().unwrap();
        let row = |(key, property): (&String, &Value)| {
            let (kind, numbers) = self.kind(property);
            let limit = |name: &str| numbers[name].as_f64().map(short);
            let range = match (limit("minimum"), limit("maximum")) {
                (Some(min), Some(max)) => format!("{min} to {max}"),
                _ => String::new(),
            };
            let default = match &property["default"] {
                _ if needed(key) => "needed".to_string(),
                Value::Null | Value::Array(_) => "none".to_string(),
                Value::Number(number) => short(number.as_f64().unwrap()),
                other => format!("`{other}`"),
            };
            let unit = numbers["unit"].as_str().unwrap_or_default();
            let meaning = property["description"].as_str().unwrap().replace('\n', " ");
            format!("| `{key}` | {kind} | {unit} | {range} | {default} | {meaning} |")
        };
        properties.iter().map(row).collect()
    }
}

/// The rows of the table that follows a heading of the page.
fn listed<'a>(page: &'a str, heading: &str) -> BTreeSet<String> {
    let (_, rest) = page.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("no heading {heading:?}"));
    let table = rest.lines().skip_while(|line: &&'a str| !line.starts_with('|'));
    let rows = table.take_while(|line| line.starts_with('|'));
    rows.skip(2).map(str::to_string).collect()
}

/// Tests that `docs/arms.md` lists every key of arm and skin files with its type, unit, range, default and meaning as
/// the program that reads the files has them, and no other key.
#[test]
fn the_page_lists_every_key() {
    let page = std::fs::read_to_string(docs().join("arms.md")).unwrap();
    let files = [
        (
            arm::schema(),
            &[
                ("## The arm file", ""),
                ("### `[[joint]]`", "JointTable"),
                ("### `[[hull]]`", "HullTable"),
                ("### `[[held]]`", "HeldTable"),
                ("### `[[inertia]]`", "InertiaTable"),
            ][..],
        ),
        (
            arm::skin_schema(),
            &[
                ("## The skin file", ""),
                ("### `[[patch]]`", "PatchTable"),
                ("### `[patch.cylinder]`", "CylinderTable"),
                ("### `[patch.points]`", "PointsTable"),
                ("### Entries of `taxels`", "TaxelTable"),
            ][..],
        ),
    ];
    for (schema, tables) in files {
        let schema = Schema(schema.to_value());
        for (heading, definition) in tables {
            let object = match *definition {
                "" => &schema.0,
                name => &schema.0["$defs"][name],
            };
            assert_eq!(listed(&page, heading), schema.rows(object), "{heading}");
        }
        let objects = schema.0["$defs"].as_object().unwrap().values();
        let objects = objects.filter(|definition| definition["type"] == "object").count();
        assert_eq!(objects + 1, tables.len(), "a table of the file has no heading in the page");
    }
}

fn panda() -> PathBuf {
    docs().join("arms/panda")
}

/// Tests the kinematics of the Panda that ships with the page against Franka's published Denavit-Hartenberg parameters:
/// at zero joint angles the flange is 88 mm in front of the base's axis and 926 mm above it (333 + 316 + 384 − 107),
/// turned upside down.
#[test]
fn the_pandas_flange_is_where_franka_says() {
    let arm = Arm::load(panda().join("panda.toml")).unwrap();
    assert_eq!(arm.joints.len(), 7);
    let poses = arm.forward_kinematics(&[0.0; 7]);
    let flange = poses[arm.end_effector_link] * arm.end_effector_pose_link;
    let expected = glam::DVec3::new(0.088, 0.0, 0.926);
    assert!((flange.position - expected).length() < 1e-9, "{flange:?}");
    let down = flange.orientation * glam::DVec3::Z;
    assert!((down + glam::DVec3::Z).length() < 1e-9, "{flange:?}");
}

/// Tests that the Panda of the page works: nothing about its skin is doubtful, it reaches goals through foliage, and
/// its skin feels the leaves.
#[test]
fn the_panda_reaches_goals_through_foliage() {
    let scene = panda().join("foliage.toml");
    let found = underbrush!["inspect", scene, "--json"].json();
    assert_eq!((&found["arm"], &found["doubtful"]), (&"panda".into(), &"nothing".into()));
    let reach = underbrush!["reach", scene, "--json"].json();
    assert!(reach["goals_reached"].as_u64().unwrap() >= 2, "{reach}");
    let touched = reach["touched_frames"].as_object().unwrap();
    assert!(touched.values().any(|frames| frames.as_u64().unwrap() > 100), "{touched:?}");
}
