//! `underbrush arrange`.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::json;

use crate::support::{scenes, underbrush};

/// Tests that a folder with the name of a shipped scene, such as a data set of it, does not hide the scene.
#[test]
fn a_folder_does_not_hide_a_shipped_scene() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("trunk")).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_underbrush"));
    let answer = program.args(["arrange", "trunk", "--out", "drawn.toml"]).current_dir(&folder).output().unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    assert!(fs::read_to_string(folder.path().join("drawn.toml")).unwrap().contains("[[objects.trunk]]"));
}

/// Tests that the share of goals reached in a suite is that of the goals which a scene lists, and not of `goals.count`.
#[test]
fn listed_goals_are_all_goals_of_a_suite() {
    let folder = tempfile::tempdir().unwrap();
    // No objects are in the way of the two goals. A reach has four if none are listed.
    let goals = "summary = \"Two goals\"\n[goals]\npositions_m = [[0.6, -0.2, -0.25], [0.6, 0.0, -0.25]]\n";
    fs::write(folder.path().join("two.toml"), goals).unwrap();
    let suite = folder.path().join("suite.toml");
    let bounds = "[[scenes]]\nscene = \"two.toml\"\nreaches = 2\n[scenes.bounds]\ngoals_reached = { at_least = 1.0 }\n";
    fs::write(&suite, format!("summary = \"Two goals\"\nseed = 1\n{bounds}")).unwrap();
    let report = underbrush!["check", suite, "--json"].json();
    let scene = &report["suites"][0]["scenes"][0];
    assert_eq!((&scene["goals"]["reached"], &scene["bounds"][0]["found"]), (&json!(4), &json!(1.0)), "{report}");
    let reach = underbrush!["reach", folder.path().join("two.toml"), "--json"].json();
    assert_eq!((&reach["all_goals"], &reach["goals_reached"]), (&json!(2), &json!(2)));
}

/// Tests that a reach through an arranged scene is the reach through the scene, byte for byte, that an object which is moved
/// in the file stands elsewhere in the reach, and that a file that is there is kept.
#[test]
fn an_arranged_scene_is_the_scene_until_it_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "few.toml", scenes::FEW_TRUNKS);
    // A scene of the same name in another folder.
    let arranged = folder.path().join("arranged/few.toml");
    underbrush!["arrange", scene, "--seed", "3", "--index", "2", "--out", arranged].success();
    let reach = |scene: &Path, name: &str| {
        let out = folder.path().join(name);
        underbrush!["reach", scene, "--seed", "3", "--index", "2", "--out", out].success();
        fs::read(out).unwrap()
    };
    assert_eq!(reach(&arranged, "arranged.parquet"), reach(&scene, "drawn.parquet"));
    let text = fs::read_to_string(&arranged).unwrap();
    let height = text.lines().find(|line| line.starts_with("height_m")).unwrap();
    fs::write(&arranged, text.replacen(height, "height_m = 0.47", 1)).unwrap();
    assert_ne!(reach(&arranged, "changed.parquet"), reach(&scene, "again.parquet"));
    underbrush!["arrange", scene, "--out", arranged].refused(&["few.toml", "exists already", "--force"]);
}

/// Tests that the command that is printed is one for a shell, also if the name of the file has a space.
#[test]
fn the_next_command_can_be_copied() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "few.toml", scenes::FEW_TRUNKS);
    let arranged = folder.path().join("a few.toml");
    let said = underbrush!["arrange", scene, "--out", arranged].success();
    let next = format!("with 3 objects and 1 goal. Next: underbrush reach '{}'", arranged.display());
    assert!(said.contains(&next), "{said}");
}
