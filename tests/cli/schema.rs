//! `underbrush schema`.

use serde_json::{Value, json};
use underbrush_classifier::registry::CLASSIFIERS;
use underbrush_experiments::suite::metric::METRICS;

use crate::support::fixture::fixture;
use crate::support::json_schema::faults;
use crate::support::underbrush;

fn schema(file: &str) -> Value {
    serde_json::from_str(&underbrush!["schema", file].success()).unwrap()
}

/// Tests that the schema of scenes is the default, forbids unknown keys and knows every kind of object.
#[test]
fn the_schema_lists_the_keys_of_a_scene() {
    let scene = schema("scene");
    assert_eq!(scene, serde_json::from_str::<Value>(&underbrush!["schema"].success()).unwrap());
    assert_eq!(scene["additionalProperties"], false);
    let objects = scene["$defs"]["Objects"]["properties"].as_object().unwrap();
    let mut kinds: Vec<_> = objects.keys().map(String::as_str).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, ["foam_block", "foam_roll", "leaf", "plant", "table", "trunk", "water_bottle"]);
}

/// Tests that the schema of scenes gives a range for every number, also in lists and maps.
#[test]
fn every_number_of_a_scene_has_a_range_in_its_schema() {
    fn find_bare(schema: &Value, place: &str, bare: &mut Vec<String>) {
        let is_number = |kind: &Value| kind == "number" || kind == "integer";
        if (is_number(&schema["type"]) || is_number(&schema["type"][0])) && schema["minimum"].is_null() {
            bare.push(place.to_owned());
        }
        match schema {
            Value::Object(parts) => {
                parts.iter().for_each(|(key, part)| find_bare(part, &format!("{place}/{key}"), bare));
            }
            Value::Array(parts) => parts.iter().for_each(|part| find_bare(part, place, bare)),
            _ => {}
        }
    }
    let mut scene = schema("scene");
    // A number before its field gives it a range.
    scene["$defs"].as_object_mut().unwrap().remove("Quantity");
    let mut bare = Vec::new();
    find_bare(&scene, "", &mut bare);
    assert_eq!(bare, Vec::<String>::new());
    let force = &scene["properties"]["allowed_force_n"]["additionalProperties"];
    assert_eq!((&force["maximum"], &force["unit"]), (&json!(100.0), &json!("N")));
}

/// Tests that arm and skin files have schemas, which forbid unknown keys and give ranges.
#[test]
fn arm_and_skin_files_have_schemas() {
    for file in ["arm", "skin"] {
        assert_eq!(schema(file)["additionalProperties"], false);
    }
    assert_eq!(schema("arm")["properties"]["friction"]["maximum"], 2.0);
    assert_eq!(schema("skin")["$defs"]["CylinderTable"]["properties"]["radius_m"]["unit"], "m");
}

/// Tests that the schema of suites lists every metric, with bounds by category where the metric has one.
#[test]
fn the_schema_lists_the_metrics_of_a_suite() {
    let suite = schema("suite");
    assert_eq!(suite["additionalProperties"], false);
    let bounds = &suite["$defs"]["Bounds"];
    assert_eq!(bounds["additionalProperties"], false);
    let metrics = bounds["properties"].as_object().unwrap();
    assert_eq!(metrics.len(), METRICS.len());
    for metric in METRICS {
        assert_eq!(metrics[metric.name]["additionalProperties"].is_object(), metric.by_category, "{}", metric.name);
    }
    assert_eq!(suite["$defs"]["Bound"]["properties"]["at_most"]["type"], json!(["number", "null"]));
}

/// Tests that an unknown kind of file is refused with the known kinds.
#[test]
fn an_unknown_kind_is_refused() {
    underbrush!["schema", "robot"].refused(&["robot", "scene", "arm", "skin", "model"]);
}

/// Tests that the model file of every classifier follows the schema, and that a file with a missing or wrong entry does
/// not. The validator shares no code with the schema or the reader, and the reader must accept and refuse the same
/// files.
#[test]
fn model_files_follow_their_schema() {
    let schema = schema("model");
    let is_valid = |model: &Value| faults(&schema, model).is_empty();
    let folder = tempfile::tempdir().unwrap();
    let (path, table) = (folder.path().join("model.json"), fixture().table_csv());
    let reads = |model: &Value| {
        let mut unsealed = model.clone();
        unsealed.as_object_mut().unwrap().remove("blake3");
        underbrush_classifier::Model::from_json("m.json", &unsealed.to_string()).is_ok()
    };
    for kind in CLASSIFIERS {
        underbrush!["train", table, "--classifier", kind.name, "--out", path, "--force"].success();
        let model: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let faults = faults(&schema, &model);
        assert!(faults.is_empty() && reads(&model), "{}: {faults:?}", kind.name);

        let own = match kind.name {
            "hmm" => [
                ("/models/leaf/transition/0/0", json!("often")),
                ("/recipe/states", json!(0)),
                ("/features/0", json!("force")),
                ("/models", json!({})),
            ],
            _ => [
                ("/options/features", json!("warmth")),
                ("/options", json!({ "features": "force", "depth": 3 })),
                ("/parameters", json!([])),
                ("/categories", json!([])),
            ],
        };
        let common = [
            ("/format", json!("underbrush-model/0")),
            ("/classifier", json!("oracle")),
            ("/decision", json!({ "rule": "guess" })),
            ("/provenance", json!({ "program": 1 })),
        ];
        for (place, value) in own.into_iter().chain(common) {
            let mut broken = model.clone();
            match broken.pointer_mut(place) {
                Some(entry) => *entry = value,
                None => broken[&place[1..]] = value,
            }
            // A feature may also have the name that it has on the command line.
            let expected = place == "/features/0";
            let judged = [is_valid(&broken), reads(&broken)];
            assert_eq!(judged, [expected; 2], "{} with another {place}", kind.name);
        }
        for key in model.as_object().unwrap().keys() {
            let mut broken = model.clone();
            broken.as_object_mut().unwrap().remove(key);
            assert_eq!(is_valid(&broken), reads(&broken), "{} without {key}", kind.name);
        }
    }
}
