//! Truncated and changed Parquet files.

use std::path::Path;

use super::{Fault, assert_empty};
use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::underbrush;

const PARTS: [&str; 3] = ["Parquet: found", "a complete Parquet file", "copy the file again"];

/// Demands that every command that reads the file refuses it and writes nothing.
#[track_caller]
fn refused_everywhere(file: &Path) {
    let outputs = tempfile::tempdir().unwrap();
    let [model, table] = ["model.json", "trials.csv"].map(|name| outputs.path().join(name));
    let fault = Fault { file, line: None, parts: &PARTS };
    fault.check(&underbrush!["inspect", file]);
    fault.check(&underbrush!["train", file, "--out", model]);
    fault.check(&underbrush!["evaluate", file]);
    fault.check(&underbrush!["trials", file, "--out", table]);
    fault.check(&underbrush!["score", fixture().model(), file]);
    fault.check(&underbrush!["classify", fixture().model(), file]);
    fault.check(&underbrush!["classify", fixture().model(), file, "--online"]);
    assert_empty(outputs.path());
}

/// Truncates the file at many lengths, all of which must be refused.
#[track_caller]
fn refused_when_truncated(whole: &[u8], file: &Path) {
    for length in [0, 3, 4, 8, 12, whole.len() / 3, whole.len() - 8, whole.len() - 1] {
        std::fs::write(file, &whole[..length]).unwrap();
        refused_everywhere(file);
    }
}

/// Tests that a recording truncated at any length is refused by every command that reads it.
#[test]
fn truncated_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("reach.parquet");
    recording_with_trials(&fixture().trunk_scene(), &file);
    refused_when_truncated(&std::fs::read(&file).unwrap(), &file);
}

/// Tests that a table of trials truncated at any length is refused by every command that reads it.
#[test]
fn truncated_trials() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.parquet");
    refused_when_truncated(&std::fs::read(fixture().table_parquet()).unwrap(), &file);
}

/// Tests that a footer with any damaged byte is either read or refused as bad input, without showing a panic message,
/// and that some of this damage does make the Parquet decoder panic.
#[test]
fn a_changed_footer_never_shows_a_panic() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.parquet");
    std::fs::write(folder.path().join("few.csv"), "trial,time_s,force_n\n0,0.0,1\n0,0.01,2\n").unwrap();
    underbrush!["trials", folder.path().join("few.csv"), "--out", file].success();
    let mut whole = std::fs::read(&file).unwrap();
    // Without a checksum, as in tables of other programs; with one, most damage would not reach the decoder.
    let key = b"underbrush.blake3";
    let place = whole.windows(key.len()).rposition(|part| part == key).unwrap();
    whole[place] = b'x';
    let length = u32::from_le_bytes(whole[whole.len() - 8..whole.len() - 4].try_into().unwrap()) as usize;
    let mut panics = 0;
    for place in whole.len() - 8 - length..whole.len() {
        let mut bytes = whole.clone();
        // The footer encodes negative numbers as odd ones, so this gives negative lengths and offsets.
        bytes[place] = if bytes[place] == 1 { 3 } else { 1 };
        std::fs::write(&file, bytes).unwrap();
        let answer = underbrush!["inspect", file];
        if answer.status != 0 {
            answer.refused(&[&file.display().to_string()]);
            panics += usize::from(answer.stderr.contains("damaged bytes that cannot be decoded"));
        }
    }
    assert!(panics > 0, "no change makes the decoder panic any more: damage the file in another way");
}
