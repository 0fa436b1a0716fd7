#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::PathBuf;

use super::*;
use crate::progress::Silent;

fn plan(seed: u64, quick: bool, experiment: &str) -> Plan {
    let hash = experiment.to_owned();
    Plan::new(&Experiment { hash, ..Experiment::paper().unwrap() }, seed, quick)
}

fn this() -> Plan {
    plan(3, true, "paper")
}

/// The result in the file, made anew as these values if it is not taken; and whether it was made.
fn kept(path: &Path, plan: Plan, values: &[f64]) -> (Vec<f64>, bool) {
    let mut is_made = false;
    let found = result(path, plan, &Silent, || {
        is_made = true;
        Ok(values.to_vec())
    });
    (found.unwrap(), is_made)
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seed-3.json");
    (folder, path)
}

/// Tests that a cached result is used only by the run that made it: another seed, size, experiment, name or build
/// computes it again.
#[test]
fn only_the_same_run_takes_a_kept_result() {
    let (folder, path) = folder();
    let values = vec![64.2, 0.1 + 0.2];
    assert_eq!(kept(&path, this(), &values), (values.clone(), true));
    assert_eq!(kept(&path, this(), &[0.0]), (values.clone(), false));
    let text = std::fs::read_to_string(&path).unwrap();
    for other in [plan(4, true, "paper"), plan(3, false, "paper"), plan(3, true, "other")] {
        std::fs::write(&path, &text).unwrap();
        assert_eq!(kept(&path, other, &[1.0]), (vec![1.0], true));
    }
    let renamed = folder.path().join("splits-3.json");
    std::fs::write(&renamed, &text).unwrap();
    assert_eq!(kept(&renamed, this(), &[1.0]), (vec![1.0], true));
    // Another build writes another hash of its sources.
    for hash in [env!("UNDERBRUSH_ANALYSIS_SOURCES"), env!("UNDERBRUSH_DATA_SOURCES")] {
        let other = text.replace(hash, "0123456789abcdef");
        assert_ne!(other, text);
        let mut sealed: Kept = serde_json::from_str(&other).unwrap();
        sealed.blake3 = sealed.hash();
        files::write_json(&path, &sealed).unwrap();
        assert_eq!(kept(&path, this(), &[1.0]), (vec![1.0], true), "{hash}");
    }
}

/// Tests that a result whose numbers were edited, or that is truncated, or in the form of an earlier version, is not used but
/// computed and cached again.
#[test]
fn an_edited_result_is_made_again() {
    let (_folder, path) = folder();
    let values = [64.2, 85.3];
    kept(&path, this(), &values);
    let text = std::fs::read_to_string(&path).unwrap();
    let edited = text.replace("85.3", "95.3");
    let earlier = json!({ "blake3": "0123", "content": { "made_by": {}, "result": [1.0] } }).to_string();
    for damaged in [edited.as_str(), &text[..text.len() / 2], &earlier] {
        assert_ne!(damaged, text);
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(kept(&path, this(), &values), (values.to_vec(), true), "{damaged}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}

/// Tests that a result is read back as it was written, and that a file with a single flipped bit never gives another
/// result.
#[test]
fn a_file_with_a_flipped_bit_gives_no_other_result() {
    let (_folder, path) = folder();
    let values = vec![0.1 + 0.2, -0.0, 1e300, 64.25];
    let made_by = MadeBy { name: "seed-3".into(), analysis: ANALYSIS_VERSION.into(), plan: this() };
    let read = || Kept::read::<Vec<f64>>(&path, &made_by, &Silent);
    assert_eq!(read(), None);
    kept(&path, this(), &values);
    assert_eq!(read(), Some(values.clone()));
    let whole = std::fs::read(&path).unwrap();
    for place in 0..whole.len() {
        for bit in 0..8 {
            let mut flipped = whole.clone();
            flipped[place] ^= 1 << bit;
            std::fs::write(&path, flipped).unwrap();
            let taken = read();
            assert!(taken.is_none() || taken.as_ref() == Some(&values), "byte {place}, bit {bit}: {taken:?}");
        }
    }
}
