//! `underbrush arrange`.

use std::fs;
use std::path::Path;

use crate::support::{scenes, underbrush};

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
