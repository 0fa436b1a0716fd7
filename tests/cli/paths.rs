//! Paths that are not UTF-8.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;

use crate::support::fixture::fixture;
use crate::support::{copy_tree, scenes, underbrush};

/// Tests that every command reads and writes paths that are not UTF-8, even with --json, and shows invalid bytes as
/// U+FFFD.
#[test]
fn any_path_is_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join(OsStr::from_bytes(b"\xff\xfe"));
    std::fs::create_dir(&folder).unwrap();
    let named = |end: &str| -> PathBuf {
        let mut name = OsStr::from_bytes(b"\x80").to_os_string();
        name.push(end);
        folder.join(name)
    };
    let [scene, set, table, binary_table, model] = [".toml", "set", ".csv", "table.parquet", ".json"].map(&named);
    let [recording, picture] = ["reach.parquet", ".png"].map(named);
    std::fs::write(&scene, scenes::TRUNKS_AT_FOREARM).unwrap();
    copy_tree(&fixture().dataset(), &set);
    let shown = |answer: crate::support::Answer, key: &str| {
        let report = answer.json();
        assert!(report[key].as_str().is_some_and(|path| path.contains('\u{fffd}')), "{report}");
    };
    for out in [&table, &binary_table] {
        shown(underbrush!["trials", set, "--out", out, "--json"], "file");
    }
    shown(underbrush!["train", table, "--out", model, "--states", "2", "--json"], "model");
    underbrush!["reach", scene, "--out", recording, "--picture", picture, "--json"].success();
    shown(underbrush!["generate", scene, "--reaches", "1", "--out", named("new"), "--json"], "dataset");
    // The files of an arm name each other, and TOML is UTF-8.
    let arm = named("arm.toml");
    underbrush!["arm", "new", scene, "--tip", "hand", "--out", arm, "--json"].refused(&["a name in UTF-8"]);
    assert!(!arm.exists());
    for (path, key) in
        [(&set, "dataset"), (&recording, "recording"), (&table, "table"), (&binary_table, "table"), (&model, "model")]
    {
        shown(underbrush!["inspect", path, "--json"], key);
    }
    underbrush!["inspect", scene].success();
    underbrush!["classify", model, recording, "--online"].success();
    underbrush!["score", model, binary_table].success();
    underbrush!["evaluate", table, "--group", "position", "--json"].success();
    // Errors also name such paths.
    underbrush!["inspect", named("absent.toml")].refused(&["\u{fffd}absent.toml", "no such file"]);
}
