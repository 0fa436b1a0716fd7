use std::collections::BTreeSet;

use underbrush_classifier::evaluate::wilson;

use crate::definition::Experiment;
use crate::experiment::settings::{Folded, splits};

/// Tests that a setting with 3 + 4 reaches takes the first reaches of each scene from a campaign of 4 + 6, half of them
/// in each fold; and that at two settings with the forces of leaf and trunk swapped, each classifier is always right at
/// its own setting and always wrong at the other. A half without a category is found.
#[test]
fn settings_are_tested_on_clutter_that_was_not_trained_on() {
    let trial = |number: u64, reach: u64, force_n: f64| {
        let sample = |index: u32| {
            let force_n = force_n + 0.01 * f64::from((index * 7 + number as u32 * 3) % 11);
            underbrush_recording::Sample {
                time_s: f64::from(index) / 100.0,
                force_n,
                motion_m: Some(0.0),
                region: Some(underbrush_recording::Region {
                    taxels: 1,
                    largest_force_n: force_n,
                    force_sum_n: force_n,
                }),
                ..underbrush_recording::Sample::default()
            }
        };
        underbrush_recording::Trial {
            trial: number,
            category: Some(if reach < 4 { "leaf" } else { "trunk" }.into()),
            reach: Some(reach),
            patch: Some("forearm".into()),
            taxel: Some(0),
            samples: (0..30).map(sample).collect(),
        }
    };
    let trials = |leaf_n: f64, trunk_n: f64| -> Vec<underbrush_recording::Trial> {
        let numbers = 0..40_u64;
        let force = |reach: u64| if reach < 4 { leaf_n } else { trunk_n };
        numbers.map(|number| trial(number, number % 10, force(number % 10))).collect()
    };
    let setting = |name, trials: &[underbrush_recording::Trial]| Folded::new(name, trials, &[4, 6], &[3, 4]);
    let apart = setting("apart", &trials(0.5, 2.0));
    let reaches = |fold: &[underbrush_recording::Trial]| -> BTreeSet<u64> {
        fold.iter().filter_map(|trial| trial.reach).collect()
    };
    assert_eq!(reaches(&apart.folds[0]), BTreeSet::from([0, 1, 4, 5]));
    assert_eq!(reaches(&apart.folds[1]), BTreeSet::from([2, 6, 7]));

    // A setting at which the leaf was touched in the first half of its reaches alone.
    let mut partly = setting("partly", &trials(0.5, 2.0));
    partly.folds[1].retain(|trial| trial.category.as_deref() != Some("leaf"));
    let labels = BTreeSet::from(["leaf", "trunk"]);
    assert_eq!(apart.lack(&labels), None);
    let lack = partly.lack(&labels).unwrap();
    assert!(lack.contains("setting partly") && lack.contains("no trial of leaf"), "{lack}");

    let swapped = setting("swapped", &trials(2.0, 0.5));
    let estimators = 5;
    let found = splits(&Experiment::paper().unwrap(), &[apart, swapped]).unwrap();
    let accuracies: Vec<f64> = found.iter().map(|split| split.accuracy.accuracy).collect();
    assert_eq!(accuracies, [100.0, 0.0, 0.0, 100.0].repeat(estimators));
    for split in &found {
        let own = &split.accuracy;
        assert!(own.trials == 28 && own.balanced_accuracy == own.accuracy);
        // All trials of the seven reaches are right, or none is.
        let interval = wilson(if own.accuracy > 50.0 { 7 } else { 0 }, 7);
        assert_eq!([own.low, own.high], [interval.low, interval.high].map(|end| 100.0 * end));
        // 12 of leaf and 16 of trunk.
        assert!((own.majority_baseline - 100.0 * 16.0 / 28.0).abs() < 1e-9);
    }
}
