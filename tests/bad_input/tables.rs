//! Invalid tables of trials.

use std::path::Path;

use super::{Fault, assert_empty};
use crate::support::fixture::fixture;
use crate::support::underbrush;

const HEADER: &str = "trial,category,time_s,force_n";

/// Demands that every command that reads tables refuses this file and writes nothing.
#[track_caller]
fn refuses_file(file: &Path, line: Option<usize>, parts: &[&str]) {
    let outputs = tempfile::tempdir().unwrap();
    let [model, table] = ["model.json", "trials.parquet"].map(|name| outputs.path().join(name));
    let fault = Fault { file, line, parts };
    fault.check(&underbrush!["train", file, "--out", model]);
    fault.check(&underbrush!["evaluate", file]);
    fault.check(&underbrush!["score", fixture().model(), file]);
    fault.check(&underbrush!["classify", fixture().model(), file]);
    fault.check(&underbrush!["trials", file, "--out", table]);
    fault.check(&underbrush!["inspect", file]);
    assert_empty(outputs.path());
}

#[track_caller]
fn refuses(text: &str, line: Option<usize>, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.csv");
    std::fs::write(&file, text).unwrap();
    refuses_file(&file, line, parts);
}

/// Tests that a table with only a header and an empty file are refused.
#[test]
fn empty() {
    refuses(&format!("{HEADER}\n"), None, &["rows: found none", "one row per sample", "at least one row"]);
    refuses("", None, &["trial: found no columns"]);
}

/// Tests that a missing column is named together with the columns found, and that a robot's log may be imported.
#[test]
fn missing_column() {
    let parts = ["force_n: found only the columns trial, category, time_s", "force_n", "case-sensitive"];
    refuses("trial,category,time_s\n0,leaf,0.0\n", None, &parts);
    refuses("run,stamp,ft_0\n0,0,1\n", None, &["trial: found only the columns run, stamp", "`underbrush import`"]);
    let goals = fixture().dataset().join("truth/goals/chunk-000/file-000.parquet");
    underbrush!["inspect", goals].refused(&["found only the columns episode_index"]);
}

/// Tests that an incomplete row is refused with its line.
#[test]
fn missing_cell() {
    let parts = ["row: found 3 cells", "4 cells, as in the header", "correct the line"];
    refuses(&format!("{HEADER}\n0,leaf,0.0,1\n0,leaf,0.01\n"), Some(3), &parts);
    refuses(&format!("{HEADER}\n0\n"), Some(2), &["row: found 1 cell\n"]);
}

/// Tests that NaN, infinity and text are refused as forces, with their line.
#[test]
fn bad_force() {
    for force in ["NaN", "inf", "much"] {
        let text = format!("{HEADER}\n0,leaf,0.0,1\n0,leaf,0.01,{force}\n");
        refuses(
            &text,
            Some(3),
            &[&format!("force_n: found \"{force}\""), "a number from -1 to 10000 N", "correct the cell"],
        );
    }
}

/// Tests that repeated or decreasing times within a trial are refused, while another trial may start again from any
/// time.
#[test]
fn time_that_does_not_increase() {
    for time in ["0.01", "0.0"] {
        let text = format!("{HEADER}\n7,leaf,0.0,1\n7,leaf,0.01,1\n7,leaf,{time},1\n");
        let found = format!("time_s: found {}", time.parse::<f64>().unwrap());
        refuses(&text, Some(4), &[&found, "more than 0.01, the previous time in trial 7", "sort the rows"]);
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.csv");
    std::fs::write(&file, format!("{HEADER}\n7,leaf,0.5,1\n8,leaf,0.0,1\n")).unwrap();
    underbrush!["inspect", file].success();
}

/// Tests that a trial with two categories is refused.
#[test]
fn two_categories_in_one_trial() {
    let text = format!("{HEADER}\n0,leaf,0.0,1\n0,trunk,0.01,1\n");
    refuses(&text, Some(3), &["category: found trunk", "leaf, as in earlier rows of trial 0", "give each value"]);
}

/// Tests that a table without categories can be scored but not used for training or evaluation, and that the error
/// names the table.
#[test]
fn no_ground_truth() {
    let folder = tempfile::tempdir().unwrap();
    let (file, model) = (folder.path().join("bare.csv"), folder.path().join("model.json"));
    std::fs::write(&file, "trial,time_s,force_n\n0,0.0,1\n0,0.01,1\n").unwrap();
    let parts = ["category", "use trials with ground truth"];
    let fault = Fault { file: &file, line: None, parts: &parts };
    fault.check(&underbrush!["train", file, "--out", model]);
    fault.check(&underbrush!["evaluate", file]);
    assert!(!model.exists());
}

/// Tests that missing tables, recordings and data sets are reported as missing, not as the wrong kind of file.
#[test]
fn missing_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["absent.csv", "absent.parquet", "absent-set"] {
        refuses_file(&folder.path().join(name), None, &["no such file or folder", "check the path"]);
    }
    let absent = folder.path().join("absent.parquet");
    let parts = ["no such file or folder", "check the path"];
    let online = underbrush!["classify", fixture().model(), absent, "--online"];
    Fault { file: &absent, line: None, parts: &parts }.check(&online);
}

/// Tests that a folder that is not a data set is refused.
#[test]
fn foreign_folder() {
    let folder = tempfile::tempdir().unwrap();
    refuses_file(folder.path(), None, &["found no meta/info.json", "check the path, or generate"]);
    // Neither is it a folder of recordings, which all of these commands would take.
    underbrush!["evaluate", folder.path()].refused(&["or a folder with recordings"]);
    underbrush!["evaluate", folder.path(), "--classifier", "touch"].refused(&["or a folder with recordings"]);
}

/// Tests that --online refuses a table of trials, which has no frames.
#[test]
fn table_given_for_frames() {
    let fixture = fixture();
    let online = |table| underbrush!["classify", fixture.model(), table, "--online"];
    online(fixture.table_csv()).refused(&["trials.csv", "bytes that are not Parquet", "such as a recording"]);
    online(fixture.table_parquet()).refused(&["trials.parquet", "no such key in the Parquet metadata"]);
}
