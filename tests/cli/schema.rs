//! `underbrush schema`.

use serde_json::Value;

use crate::support::underbrush;

fn schema(file: &str) -> Value {
    serde_json::from_str(&underbrush!["schema", file].success()).unwrap()
}

/// Pins that the schema of scenes is the default, forbids unknown keys and knows every kind of object.
#[test]
fn the_schema_lists_the_keys_of_a_scene() {
    let scene = schema("scene");
    assert_eq!(
        scene,
        serde_json::from_str::<Value>(&underbrush!["schema"].success()).unwrap()
    );
    assert_eq!(scene["additionalProperties"], false);
    let objects = scene["$defs"]["Objects"]["properties"].as_object().unwrap();
    let mut kinds: Vec<_> = objects.keys().map(String::as_str).collect();
    kinds.sort_unstable();
    assert_eq!(kinds, ["foam_block", "foam_roll", "leaf", "trunk"]);
}

/// Pins that arm and skin files have schemas, which forbid unknown keys and give ranges.
#[test]
fn arm_and_skin_files_have_schemas() {
    for file in ["arm", "skin"] {
        assert_eq!(schema(file)["additionalProperties"], false);
    }
    assert_eq!(schema("arm")["properties"]["friction"]["maximum"], 2.0);
    assert_eq!(
        schema("skin")["$defs"]["CylinderTable"]["properties"]["radius_m"]["unit"],
        "m"
    );
}

/// Pins that an unknown kind of file is refused with the kinds that there are.
#[test]
fn an_unknown_kind_is_refused() {
    underbrush!["schema", "robot"].refused(&["robot", "scene", "arm", "skin"]);
}
