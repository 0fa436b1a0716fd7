//! Flipped bits, as from a failing disk, are never read without an error. `recording/src/disk/tests/flips.rs` is a fast
//! version of this test; run this one with `cargo test --release --test underbrush flipped -- --ignored`.

use std::fs;
use std::path::Path;

use underbrush_classifier::any_model::{self, AnyModel};

use super::touch;
use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::{copy_tree, tree, underbrush};

const FLIPS: u64 = 200;

/// Pseudo-random numbers, the same in every run (SplitMix64).
fn scattered(number: u64) -> u64 {
    let mixed = number.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Writes `whole` to a file with one bit flipped, and returns which bit.
fn flip(path: &Path, whole: &[u8], number: u64) -> String {
    let bit = scattered(number) % (8 * whole.len() as u64);
    let mut flipped = whole.to_vec();
    flipped[(bit / 8) as usize] ^= 1 << (bit % 8);
    fs::write(path, flipped).unwrap();
    format!("{}, bit {bit}", path.display())
}

/// Tests that `trials` and `inspect` report an error for each of 200 bits flipped in the files of a data set, and that
/// `generate --from`, which needs only the provenance, reports one for each bit flipped there.
#[test]
#[ignore = "takes minutes: the program is called four hundred times"]
fn no_flipped_bit_of_a_set_is_read_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let [set, table, again] = ["set", "trials.csv", "again"].map(|name| folder.path().join(name));
    copy_tree(&fixture().dataset(), &set);
    let files: Vec<_> = tree(&set).into_iter().collect();
    let mut unnoticed = Vec::new();
    for number in 0..FLIPS {
        let (name, whole) = &files[number as usize % files.len()];
        let path = set.join(name);
        let place = flip(&path, whole, number);
        let mut calls =
            vec![("trials", underbrush!["trials", set, "--out", table]), ("inspect", underbrush!["inspect", set])];
        if name.ends_with("provenance.json") {
            calls.push(("generate", underbrush!["generate", "--from", set, "--out", again]));
        }
        unnoticed.extend(calls.iter().filter(|(_, call)| call.status == 0).map(|(call, _)| format!("{call}: {place}")));
        fs::write(&path, whole).unwrap();
    }
    assert_eq!(unnoticed, [""; 0], "of {FLIPS} flips");
    underbrush!["inspect", set].success();
}

/// Tests that `inspect` reports an error for each of 200 bits flipped in a recording, and in a table of trials in
/// Parquet.
#[test]
#[ignore = "takes minutes: the program is called four hundred times"]
fn no_flipped_bit_of_a_file_is_read_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let [recording, table] = ["reach.parquet", "trials.parquet"].map(|name| folder.path().join(name));
    recording_with_trials(&fixture().trunk_scene(), &recording);
    fs::copy(fixture().table_parquet(), &table).unwrap();
    for path in [recording, table] {
        let whole = fs::read(&path).unwrap();
        let mut unnoticed = Vec::new();
        for number in 0..FLIPS {
            let place = flip(&path, &whole, number);
            if underbrush!["inspect", path].status == 0 {
                unnoticed.push(place);
            }
        }
        assert_eq!(unnoticed, [""; 0], "of {FLIPS} flips");
    }
}

/// Tests that a model of either kind with a flipped bit is refused, or is read as the model that it was.
#[test]
fn no_flipped_bit_changes_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    for model in [fixture().model(), touch::model()] {
        let whole = fs::read(model).unwrap();
        let mut refused = 0;
        for number in 0..60 {
            let place = flip(&path, &whole, number);
            let text = match any_model::load(&path) {
                Ok(AnyModel::OfTrials(model)) => model.save_string(),
                Ok(AnyModel::Touch(model)) => model.save_string(),
                Err(_) => {
                    refused += 1;
                    continue;
                }
            };
            assert_eq!(text.unwrap().as_bytes(), whole, "{place}");
        }
        assert!(refused >= 40, "{refused} of 60");
    }
}
