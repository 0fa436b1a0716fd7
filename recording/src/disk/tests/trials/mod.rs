//! Tables of trials, written and read back.

mod csv;
mod parquet;

use std::fs;

use proptest::prelude::*;

use super::Change;
use crate::disk::{read_trials, write_trials};
use crate::limits::{self, Limits};
use crate::{DiskError, InputError, Region, Sample, Trial};

/// Any number within these limits, including extreme ones.
fn within(limits: Limits) -> impl Strategy<Value = f64> {
    let awkward = [0.0, -0.0, f64::MIN_POSITIVE / 8.0, 0.1, limits.min, limits.max];
    let awkward: Vec<f64> = awkward.into_iter().filter(|value| limits.hold(*value)).collect();
    prop_oneof![
        3 => limits.min..limits.max,
        1 => prop::sample::select(awkward),
    ]
}

fn any_region() -> impl Strategy<Value = Region> {
    (1..=65_536u32, within(limits::REGION_LARGEST_FORCE_N), 0.0..1.0f64).prop_map(|(taxels, largest, share)| Region {
        taxels,
        largest_force_n: largest,
        force_sum_n: (largest * (1.0 + share * f64::from(taxels - 1))).min(limits::REGION_FORCE_SUM_N.max),
    })
}

fn any_trials() -> impl Strategy<Value = Vec<Trial>> {
    let felt = (
        within(limits::FORCE_N),
        prop::option::of(within(limits::MOTION_M)),
        prop::option::of(any_region()),
        prop::option::of(any::<bool>()),
    );
    let samples = prop::collection::btree_map(-1_000_000..1_000_000i32, felt, 1..9);
    type Felt = (f64, Option<f64>, Option<Region>, Option<bool>);
    let sample = |(time, (force_n, motion_m, region, touched)): (i32, Felt)| Sample {
        time_s: f64::from(time) * 0.01,
        force_n,
        motion_m,
        region,
        touched,
        ..Sample::default()
    };
    // Spaces around a cell of a CSV table do not count.
    let name = || prop::option::of("\\PC{1,8}".prop_filter("spaces around it", |text| text.trim() == text));
    let facts = (name(), prop::option::of(any::<u64>()), name(), prop::option::of(any::<u32>()));
    prop::collection::btree_map(any::<u64>(), (facts, samples), 1..9).prop_map(move |trials| {
        let trial = move |(trial, ((category, reach, patch, taxel), samples))| {
            let samples: std::collections::BTreeMap<_, _> = samples;
            Trial { trial, category, reach, patch, taxel, samples: samples.into_iter().map(sample).collect() }
        };
        // Largest number first, because the order of the rows counts, not the order of the numbers.
        trials.into_iter().rev().map(trial).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Tests that reading gives back what was written, down to the sign of a zero, and with quotes and line breaks in
    /// names.
    #[test]
    fn any_trials_come_back_from_both_formats(trials in any_trials()) {
        let folder = tempfile::tempdir().unwrap();
        for name in ["trials.csv", "trials.parquet", "TRIALS.CSV"] {
            let path = folder.path().join(name);
            write_trials(&path, &trials).unwrap();
            prop_assert_eq!(format!("{:?}", read_trials(&path).unwrap()), format!("{trials:?}"));
        }
    }

    /// Tests that any text is either a table or an error, and that no trial of a table is empty.
    #[test]
    fn no_text_panics_the_reader(text in "(trial,time_s,force_n\n)?([0-9.,\"\n\r-]|\\PC){0,60}") {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.csv");
        fs::write(&path, text).unwrap();
        if let Ok(trials) = read_trials(&path) {
            prop_assert!(trials.iter().all(|trial| !trial.samples.is_empty()));
        }
    }
}

fn refused(result: Result<Vec<Trial>, DiskError>) -> InputError {
    match result {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Tests that the file's extension alone decides its format, and that a missing file is bad input.
#[test]
fn other_extensions_and_absent_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(refused(read_trials(folder.path().join("trials.xlsx"))).field, "file name");
    let written = write_trials(folder.path().join("trials"), &[]);
    assert!(matches!(written, Err(DiskError::Input(error)) if error.field == "file name"));
    for name in ["absent.csv", "absent.parquet"] {
        assert_eq!(refused(read_trials(folder.path().join(name))).found, "no such file");
    }
}

/// Tests that each rule for tables of trials is checked before the file appears.
#[test]
fn trials_that_could_not_be_read_back_are_not_written() {
    let sample = Sample { time_s: 0.0, force_n: 1.0, ..Sample::default() };
    let good =
        Trial { trial: 1, category: Some("leaf".into()), reach: None, patch: None, taxel: None, samples: vec![sample] };
    let changes: [Change<Trial>; 9] = [
        ("trial 1, trial", |trial| trial.trial = 1),
        ("trial 2, category", |trial| trial.category = Some(String::new())),
        ("trial 2, category", |trial| trial.category = Some("uncertain".into())),
        ("trial 2, samples", |trial| trial.samples.clear()),
        ("trial 2, motion_m", |trial| trial.samples[0].motion_m = Some(f64::INFINITY)),
        ("trial 2, force_n", |trial| trial.samples[0].force_n = -5.0),
        ("trial 2, time_s", |trial| trial.samples[0].time_s = 1e300),
        ("trial 2, region_force_sum_n", |trial| {
            trial.samples[0].region = Some(Region { taxels: 2, largest_force_n: 1.0, force_sum_n: 0.5 });
        }),
        ("trial 2, time_s", |trial| trial.samples.push(trial.samples[0].clone())),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (expected, change) in changes {
        let mut bad = Trial { trial: 2, ..good.clone() };
        change(&mut bad);
        for name in ["trials.csv", "trials.parquet"] {
            let path = folder.path().join(name);
            match write_trials(&path, &[good.clone(), bad.clone()]) {
                Err(DiskError::Unwritable { field, .. }) => assert_eq!(field, expected),
                other => panic!("{expected}: {other:?}"),
            }
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left behind");
        }
    }
}

/// Tests that other columns of numbers come back as channels from both formats, with gaps, also one that the first trial
/// lacks, and that a channel with the name of another column is refused.
#[test]
fn channels_come_back() {
    let sample = |time_s, channels: &[(&str, f64)]| Sample {
        time_s,
        force_n: 1.0,
        channels: channels.iter().copied().collect(),
        ..Sample::default()
    };
    let trial = |trial, samples| Trial { trial, samples, ..Trial::default() };
    let first = trial(1, vec![sample(0.0, &[("shear x, N", -0.25)]), sample(0.01, &[("slip", 1e-300)])]);
    let trials = [first.clone(), trial(2, vec![sample(0.0, &[("shear x, N", 3.0), ("slip", 0.5), ("heat", 20.5)])])];
    let folder = tempfile::tempdir().unwrap();
    for name in ["trials.csv", "trials.parquet"] {
        let path = folder.path().join(name);
        write_trials(&path, &trials).unwrap();
        assert_eq!(read_trials(&path).unwrap(), trials, "{name}");
        for bad in [("reach", 1.0), ("slip", f64::NAN)] {
            let written = write_trials(&path, &[first.clone(), trial(2, vec![sample(0.0, &[bad])])]);
            let field = "trial 2, channels";
            assert!(
                matches!(&written, Err(DiskError::Unwritable { field: found, .. }) if found == field),
                "{written:?}"
            );
        }
    }
}
