//! `underbrush inspect`.

use std::path::Path;

use crate::support::fixture::fixture;
use crate::support::{scenes, underbrush};

/// Tests that the keys of `inspect --json` are names in snake_case, except where they are names from the inspected file.
#[test]
fn keys_are_names() {
    let fixture = fixture();
    let inspected = [fixture.leaf_scene(), fixture.dataset(), fixture.table_csv(), fixture.model()];
    for path in inspected {
        let found = underbrush!["inspect", path, "--json"].json();
        for key in found.as_object().unwrap().keys() {
            let allowed = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_';
            assert!(key.chars().all(allowed), "{key:?} of {}", path.display());
        }
    }
}

/// Tests that scenes, data sets, recordings, both kinds of table and models are recognized, checked and described.
#[test]
fn each_kind_of_thing_is_recognized() {
    let fixture = fixture();
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "few.toml", scenes::FEW_TRUNKS);
    let recording = folder.path().join("recording.parquet");
    underbrush!["reach", scene, "--out", recording].success();

    let describe = |path: &Path| underbrush!["inspect", path, "--json"].json();
    let found = describe(&scene);
    assert_eq!((&found["scene"], &found["objects"]["trunk"]), (&"few".into(), &3.into()));
    let found = describe(&fixture.dataset());
    assert_eq!((&found["reaches"], &found["reaches_by_scene"]["leaf"]), (&6.into(), &3.into()));
    assert_eq!((&found["taxels"]["forearm"], &found["taxels"]["flipper"]), (&384.into(), &69.into()));
    let found = describe(&recording);
    assert_eq!((&found["scene"], &found["objects"]), (&"few".into(), &3.into()));
    let tables = [fixture.table_csv(), fixture.table_parquet()].map(|table| describe(&table));
    assert_eq!(tables[0]["trials_by_category"], tables[1]["trials_by_category"]);
    assert!(tables[0]["trials_by_category"]["leaf"].as_u64().unwrap() >= 4);
    let found = describe(&fixture.model());
    assert_eq!(found["states_by_category"], serde_json::json!({ "leaf": 3, "trunk": 3 }));
    assert_eq!(found["features"], serde_json::json!(["force_n"]));
}

/// Tests that the torques of a set balance, and that options for one kind of input are refused for others.
#[test]
fn torques_balance() {
    let fixture = fixture();
    let found = underbrush!["inspect", fixture.dataset(), "--audit", "--json"].json();
    let scene = &found["torque_balance"]["trunk"];
    assert!(scene["windows"].as_u64().unwrap() > 10, "{scene}");
    assert!(scene["residual_share"].as_f64().unwrap() < scene["bound"].as_f64().unwrap(), "{scene}");
    underbrush!["inspect", "mixed", "--audit"].refused(&["mixed", "data sets"]);
    underbrush!["inspect", fixture.dataset(), "--seed", "5"].refused(&["--seed is for scenes"]);
}

/// Tests that a folder of recordings is inspected: each of them, one per line, and the sum of their frames.
#[test]
fn a_folder_of_recordings_is_inspected() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "few.toml", scenes::FEW_TRUNKS);
    let (one, both) = (folder.path().join("b.parquet"), folder.path().join("both"));
    underbrush!["reach", scene, "--out", one].success();
    std::fs::create_dir(&both).unwrap();
    for name in ["a.parquet", "b.parquet"] {
        std::fs::copy(&one, both.join(name)).unwrap();
    }
    let found = underbrush!["inspect", both, "--json"].json();
    let frames = underbrush!["inspect", one, "--json"].json()["frames"].as_u64().unwrap();
    assert_eq!((&found["reaches"], &found["frames"]), (&2.into(), &(2 * frames).into()));
    let text = underbrush!["inspect", both].success();
    let lines: Vec<&str> = text.lines().skip_while(|line| *line != "recordings:").collect();
    assert!(lines[3].contains("a.parquet") && lines[4].contains("b.parquet"), "{text}");
}
