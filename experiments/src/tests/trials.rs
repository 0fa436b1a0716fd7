use underbrush_recording::{Sample, Trial};

use crate::definition::Experiment;
use crate::experiment::training_data::per_reach;
use crate::training::Trials;

fn trial(category: &str, touched: &[bool]) -> Trial {
    let sample = |touched: &bool| Sample { time_s: 0.0, force_n: 0.1, touched: Some(*touched), ..Sample::default() };
    Trial {
        trial: 0,
        category: Some(category.into()),
        reach: Some(0),
        patch: None,
        taxel: None,
        samples: touched.iter().map(sample).collect(),
    }
}

/// Tests that trials, and those in which nothing touched the skin, are counted by unit and label.
#[test]
fn trials_that_nothing_touched_are_counted() {
    let trials = Trials {
        component: Vec::new(),
        taxel: vec![trial("leaf", &[false, true]), trial("leaf", &[false, false]), trial("trunk", &[false])],
    };
    let rows = per_reach(&Experiment::paper().unwrap(), &trials);
    let counts: Vec<(usize, usize)> = rows.iter().map(|row| (row.trials, row.untouched)).collect();
    assert_eq!(counts, [(0, 0), (0, 0), (2, 1), (1, 1)]);
}

/// Tests that trials of a minimum length keep their order and are numbered from zero, and that a label replaces a
/// category.
#[test]
fn longer_trials_are_numbered_anew() {
    let lengths = [1, 3, 2, 3];
    let mut all = Trials::default();
    for (place, length) in lengths.into_iter().enumerate() {
        let own = Trials { component: Vec::new(), taxel: vec![trial("trunk", &vec![true; length])] };
        all.append(place, Some("bamboo"), own);
    }
    let lasting = all.lasting(2).taxel;
    let found: Vec<_> = lasting.iter().map(|own| (own.trial, own.reach, own.samples.len())).collect();
    assert_eq!(found, [(0, Some(1), 3), (1, Some(2), 2), (2, Some(3), 3)]);
    assert!(lasting.iter().all(|own| own.category.as_deref() == Some("bamboo")));
}

/// Tests that a label without taxel trials, or without component trials where others have some, is an error that names it.
#[test]
fn every_label_needs_trials() {
    let experiment = Experiment::paper().unwrap();
    let [leaf, trunk] = ["leaf", "trunk"].map(|category| trial(category, &[true]));
    let check = |component: &[&Trial], taxel: &[&Trial]| {
        let [component, taxel] = [component, taxel].map(|own| own.iter().map(|own| (*own).clone()).collect::<Vec<_>>());
        Trials { component, taxel }.check_labels(&experiment)
    };
    check(&[], &[&leaf, &trunk]).unwrap();
    check(&[&trunk, &leaf], &[&leaf, &trunk]).unwrap();
    for found in [check(&[], &[&leaf]), check(&[&leaf], &[&leaf, &trunk])] {
        let error = found.unwrap_err().to_string();
        assert!(error.contains("no trial of trunk") && error.contains("has 20 samples"), "{error}");
    }
}
