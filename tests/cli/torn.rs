//! Data sets that were damaged after they were finished.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::support::fixture::fixture;
use crate::support::{copy_tree, underbrush};

const DATA: &str = "data/chunk-000/file-000.parquet";

/// A copy of the fixture's data set to damage.
fn copy() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    copy_tree(&fixture().dataset(), &set);
    (folder, set)
}

/// Demands that every command that reads a data set refuses a damaged one with these words, and that no output appears.
#[track_caller]
fn refused_everywhere(set: &Path, parts: &[&str]) {
    let outputs = tempfile::tempdir().unwrap();
    let [model, table] = ["model.json", "trials.csv"].map(|name| outputs.path().join(name));
    underbrush!["inspect", set].refused(parts);
    underbrush!["train", set, "--out", model].refused(parts);
    underbrush!["evaluate", set].refused(parts);
    underbrush!["trials", set, "--out", table].refused(parts);
    underbrush!["score", fixture().model(), set].refused(parts);
    underbrush!["classify", fixture().model(), set].refused(parts);
    assert_eq!(std::fs::read_dir(outputs.path()).unwrap().count(), 0);
}

/// Tests that a copied data set is still valid, so that the errors below come from the damage.
#[test]
fn a_whole_copy_is_sound() {
    let (_folder, set) = copy();
    assert!(underbrush!["inspect", set].success().contains("sound"));
}

/// Tests that a set without meta/info.json is refused with its path.
#[test]
fn without_info_it_is_no_data_set() {
    let (_folder, set) = copy();
    std::fs::remove_file(set.join("meta/info.json")).unwrap();
    refused_everywhere(&set, &[&set.display().to_string(), "meta/info.json", "copy the data set again"]);
}

/// Tests that every command names a truncated file before it reads any of it.
#[test]
fn a_truncated_data_file_is_named() {
    let (_folder, set) = copy();
    let bytes = std::fs::read(set.join(DATA)).unwrap();
    std::fs::write(set.join(DATA), &bytes[..bytes.len() - 100]).unwrap();
    refused_everywhere(&set, &[DATA]);
}

/// Tests that a missing file is named.
#[test]
fn a_missing_data_file_is_named() {
    let (_folder, set) = copy();
    std::fs::remove_file(set.join(DATA)).unwrap();
    refused_everywhere(&set, &[DATA]);
}

/// Tests that every command detects damage that keeps the size of a file, not only `inspect`.
#[test]
fn a_changed_byte_is_named_by_every_command() {
    let (_folder, set) = copy();
    let mut bytes = std::fs::read(set.join(DATA)).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    std::fs::write(set.join(DATA), bytes).unwrap();
    refused_everywhere(&set, &[DATA, "checksum"]);
}

/// Tests that a missing metadata file of this program is named, and that the set is not taken for one of another
/// program.
#[test]
fn a_lost_provenance_is_named() {
    let (_folder, set) = copy();
    std::fs::remove_file(set.join("meta/provenance.json")).unwrap();
    refused_everywhere(&set, &["without meta/provenance.json", "copy the data set again"]);
}

/// Tests that "every file matches its checksum" is not reported for a set with a file that is not in its list.
#[test]
fn an_extra_file_is_named() {
    let (_folder, set) = copy();
    let extra = "data/chunk-000/file-001.parquet";
    std::fs::copy(set.join(DATA), set.join(extra)).unwrap();
    refused_everywhere(&set, &[extra, "does not list"]);
}

/// Tests that every command also names a changed metadata file of this program.
#[test]
fn changed_metadata_is_named_by_every_command() {
    let (_folder, set) = copy();
    let name = "meta/provenance.json";
    let text = std::fs::read_to_string(set.join(name)).unwrap();
    let changed = text.replacen("cody-2013", "cody-2014", 1);
    assert_ne!(text, changed);
    std::fs::write(set.join(name), changed).unwrap();
    refused_everywhere(&set, &[name, "checksum"]);
}
