//! Outputs that exist already.

use std::ffi::OsString;
use std::path::Path;

use crate::support::fixture::fixture;
use crate::support::{call, copy_tree, scenes, tree, underbrush};

/// Calls that write something new below the folder, one for each kind of output.
fn calls(folder: &Path) -> Vec<Vec<OsString>> {
    let named = |name: &str| folder.join(name).into_os_string();
    let text = |words: &str| -> Vec<OsString> { words.split(' ').map(Into::into).collect() };
    let [set, table, model] = [fixture().dataset(), fixture().table_csv(), fixture().model()];
    let [set, table, model] = [set, table, model].map(|path| path.as_os_str().to_owned());
    let scene = scenes::write(folder, "few.toml", scenes::FEW_TRUNKS).into_os_string();
    let mapping = folder.join("map.toml");
    std::fs::write(&mapping, "[time]\nfrom = \"time_s\"\n[force]\nfrom = \"force_n\"\n").unwrap();
    let log = folder.join("log.csv");
    std::fs::write(&log, "time_s,force_n\n0,0\n0.01,1\n0.02,0\n").unwrap();
    let suite = folder.join("suite.toml");
    let bounds = "[[scenes]]\nscene = \"few.toml\"\nreaches = 2\n[scenes.bounds]\ngoals_reached = { at_least = 0 }\n";
    std::fs::write(&suite, format!("summary = \"Few\"\nseed = 1\n{bounds}")).unwrap();
    let parts = ["1", "2"].map(|part| {
        let out = folder.join("part").join(part).into_os_string();
        let shard = format!("--shard={part}/2").into();
        let call_ = [text("generate --reaches 2"), vec![scene.clone(), shard, "--out".into(), out.clone()]].concat();
        call(call_, "").success();
        out
    });
    let pieces: Vec<(Vec<OsString>, Vec<OsString>)> = vec![
        (text("train --states 2"), vec![table.clone(), "--out".into(), named("new.json")]),
        (text("reach"), vec![scene.clone(), "--out".into(), named("new.parquet")]),
        (text("reach"), vec![scene.clone(), "--picture".into(), named("new.png")]),
        (text("trials"), vec![set.clone(), "--out".into(), named("new.csv")]),
        (text("import"), vec![log.into(), "--mapping".into(), mapping.into(), "--out".into(), named("palm.csv")]),
        (text("evaluate"), vec![table, "--model".into(), model, "--roc".into(), named("roc.csv")]),
        (text("replay --reaches 0"), vec![set.clone(), "--out".into(), named("new.html")]),
        (text("check"), vec![suite.into(), "--out".into(), named("report")]),
        (text("generate --reaches 1"), vec![scene, "--out".into(), named("set")]),
        (text("merge"), [parts.to_vec(), vec!["--out".into(), named("merged")]].concat()),
    ];
    pieces.into_iter().map(|(words, paths)| [words, paths].concat()).collect()
}

/// Tests that every command refuses an output that exists, names `--force`, and leaves it as it is, and that `--force`
/// overwrites it.
#[test]
fn what_exists_is_overwritten_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in calls(folder.path()) {
        call(arguments.clone(), "").success();
        let before = tree(folder.path());
        let refused = call(arguments.clone(), "");
        refused.refused(&["--force"]);
        assert!(before == tree(folder.path()), "{arguments:?} has changed something");
        call([arguments, vec!["--force".into()]].concat(), "").success();
    }
}

/// Tests that `--force` is refused where nothing is written without a further option.
#[test]
fn force_needs_an_output() {
    for (arguments, missing) in [
        (&["reach", "leaf"][..], "--picture"),
        (&["evaluate", "trials.csv"], "--roc"),
        (&["inspect", "arm.toml"], "--still"),
        (&["replay", "set"], "--video"),
        (&["check", "suite.toml"], "--out"),
        (&["fit-skin", "press.csv", "--ball-radius-mm", "5"], "--out"),
    ] {
        let arguments = arguments.iter().chain(&["--force"]).map(OsString::from).collect();
        call(arguments, "").refused(&["required", missing]);
    }
}

/// Tests that an input is not overwritten by a name that leads to it through a folder that is still to be made.
#[test]
fn an_input_is_recognized_behind_a_new_folder() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("trials.csv");
    std::fs::copy(fixture().table_csv(), &table).unwrap();
    let out = folder.path().join("new/../trials.csv");
    underbrush!["trials", table, "--out", out, "--force"].refused(&["an input of this command"]);
}

/// Tests that no file is written into a data set, nor a folder for it, whether or not the set is an input.
#[test]
fn nothing_is_written_into_a_set() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    copy_tree(&fixture().dataset(), &set);
    let before = tree(&set);
    for (command, input, out) in [
        ("trials", &set, "trials.csv"),
        ("replay", &set, "new/page.html"),
        ("trials", &fixture().table_csv(), "new/trials.csv"),
    ] {
        underbrush![command, input, "--out", set.join(out)].refused(&["within the data set", "choose another folder"]);
    }
    assert!(before == tree(&set) && !set.join("new").exists());
}

/// Tests that the name of a folder in place of that of a file is refused before the work, also if there is no such folder.
#[test]
fn a_name_that_ends_in_a_slash_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let models = format!("{}/models/", folder.path().display());
    underbrush!["train", fixture().table_csv(), "--states", "2", "--out", models].refused(&["models/", "is a folder"]);
}

/// Tests that a folder that takes no files is found out before the work, and so before what is wrong with the contacts.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_without_room_is_found_out_first() {
    let answer = underbrush!["train", fixture().dataset(), "--threshold-n", "1000", "--out", "/proc/model.json"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    assert!(answer.stderr.contains("/proc/model.json: cannot write"), "{}", answer.stderr);
}

/// Tests that `--force` does not remove anything but a data set, and neither an input.
#[test]
fn force_removes_data_sets_alone() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "few.toml", scenes::FEW_TRUNKS);
    let [set, other] = ["set", "other"].map(|name| folder.path().join(name));
    let generate = |out: &Path| underbrush!["generate", scene, "--reaches", "1", "--out", out, "--force"];
    generate(&set).success();
    std::fs::write(set.join("notes.txt"), "mine").unwrap();
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("README.md"), "mine").unwrap();
    let before = tree(folder.path());
    generate(&set).refused(&["notes.txt", "beside the data set"]);
    generate(&other).refused(&["is not empty and holds no data set"]);
    std::fs::remove_file(set.join("notes.txt")).unwrap();
    underbrush!["generate", "--from", set, "--out", set, "--force"].refused(&["an input of this command"]);
    underbrush!["merge", set, "--out", set, "--force"].refused(&["set"]);
    // A campaign that is refused has made nothing that could take the set's place.
    let impossible = underbrush!["generate", scene, "--reaches", "1", "--shard", "1/2", "--out", set, "--force"];
    impossible.refused(&["2 parts, and the number of reaches is 1"]);
    let after = tree(folder.path());
    assert!(after.iter().all(|(name, bytes)| before[name] == *bytes) && after.len() + 1 == before.len());
    // What an interrupted run has left is removed, too.
    std::fs::create_dir_all(set.join("incomplete")).unwrap();
    std::fs::write(set.join("incomplete/plan.json"), "{}").unwrap();
    generate(&set).success();
    underbrush!["inspect", set].success();
}
