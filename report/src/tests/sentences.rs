use super::*;
use crate::words;
use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;
use underbrush_experiments::accuracy::Accuracy;
use underbrush_experiments::campaign::AUTHORS;
use underbrush_experiments::data;
use underbrush_experiments::example::Typical;
use underbrush_experiments::measurement::{Cell, CellKey};
use underbrush_experiments::online::Detection;
use underbrush_recording::Trial;

/// Pins that the page says of a run on which seeds something was chosen, and of the default seed and the README's that
/// nothing was.
#[test]
fn the_page_says_what_was_chosen_on_which_seeds() {
    let untouched: Vec<u64> = (data::DEFAULT_SEED..data::DEFAULT_SEED + 20).collect();
    let text = words::choices(&untouched);
    assert!(
        text.contains("not a prediction") && text.contains("seeds 1000 to 5005"),
        "{text}"
    );
    assert!(text.ends_with("Nothing was chosen on seeds 100 to 119."), "{text}");
    let text = words::choices(&[2]);
    assert!(
        text.ends_with("This run has seed 2: patience and the number of goals were chosen on some of these seeds."),
        "{text}"
    );
    assert!(words::choices(&[999, 1000]).contains("This run has seeds 999 to 1000: creep"));
}

/// Pins that cells below the majority baseline are named with it, and that a table without such cells says so.
#[test]
fn the_page_says_which_cells_one_verdict_would_beat() {
    // The majority baseline of a cell made for tests is half its accuracy.
    let mut cells = vec![cell(5, 60.2), cell(10, 70.0)];
    let text = words::table_1(&cells, AUTHORS);
    assert!(
        text.ends_with("All 2 cells are at or above the majority baseline."),
        "{text}"
    );
    cells[0].accuracy.majority_baseline = 64.2;
    let text = words::table_1(&cells, AUTHORS);
    let expected = "1 of the 2 cells lie below the majority baseline, so always naming the more frequent category would do \
                    better: taxel, force, 5 states, 60.2 % (majority 64.2 %, balanced accuracy 55.2 %).";
    assert!(text.ends_with(expected), "{text}");
}

/// Pins the paper's majority baselines against its counts: 324 of 288 + 324 components, 582 of 496 + 582 taxels.
#[test]
fn the_papers_baselines_follow_from_its_counts() {
    let of = |unit| data::paper_majority_percent(unit);
    use underbrush_classifier::evaluate::TableOneUnit::{Component, Taxel};
    assert!((of(Component) - 100.0 * 324.0 / 612.0).abs() < 1e-9);
    assert!((of(Taxel) - 100.0 * 582.0 / 1078.0).abs() < 1e-9);
}

/// Pins that the page says when the chosen thresholds leave nearly all taxel frames uncertain, and only then. The share is
/// weighted by frames: 3 · 100 % and 1 · 80 % are 95 %.
#[test]
fn the_page_says_when_its_rule_fails() {
    let row = |rule: &str, taxel_frames, uncertain_percent| Detection {
        rule: rule.into(),
        truth: "leaf",
        taxel_frames,
        leaf_percent: 100.0 - uncertain_percent,
        trunk_percent: 0.0,
        uncertain_percent,
        outlier_percent: 0.0,
    };
    let papers = row("the paper's: 15.0 and 80.0", 4000, 0.0);
    let failing = [
        papers.clone(),
        row("chosen: 1 and 2", 3000, 100.0),
        row("chosen: 1 and 2", 1000, 80.0),
    ];
    let text = words::chosen_rule_online(&failing).unwrap();
    assert!(text.contains("leave 95.0 % uncertain: the rule fails there."), "{text}");
    let text = words::chosen_rule_online(&[papers.clone(), row("chosen: 1 and 2", 3000, 40.0)]).unwrap();
    assert!(text.ends_with("leave 40.0 % uncertain."), "{text}");
    assert_eq!(words::chosen_rule_online(&[papers]), None);
}

/// Pins that each statement of the paper on Fig. 5 is compared with the medians, in both directions.
#[test]
fn the_page_says_where_typical_trials_contradict_the_paper() {
    let typical = |category, force_after_100_ms_n, peak_force_n, motion_m| Typical {
        category,
        trials: 7,
        force_after_100_ms_n,
        peak_force_n,
        motion_m,
    };
    let text = words::figure_5(&[typical("leaf", 0.1, 0.9, 0.01), typical("trunk", 0.2, 0.5, 0.03)]);
    for part in [
        "after contact is larger on trunks, as in the paper (0.20 N, leaves 0.10 N)",
        "the peak force is not larger on trunks, unlike in the paper (0.50 N, leaves 0.90 N)",
        "the motion is larger on trunks, unlike in the paper (3.0 cm, leaves 1.0 cm)",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let text = words::figure_5(&[typical("leaf", 0.1, 0.9, 0.04), typical("trunk", 0.2, 0.5, 0.03)]);
    assert!(
        text.contains("the motion is not larger on trunks, as in the paper"),
        "{text}"
    );
}

/// Pins that the longer trials of all contacts are those that are cut with a minimum length, in the same order, and
/// numbered alike.
#[test]
fn longer_trials_are_those_cut_with_a_minimum() {
    let reaches = reaches("trunks.toml", scenes::TRUNKS_AT_FOREARM);
    let (mut all, mut cut) = (Trials::default(), Trials::default());
    for (place, recording) in reaches.iter().take(3).enumerate() {
        all.append(place, Trials::cut(recording, &data::any_length_options()).unwrap());
        cut.append(place, Trials::cut(recording, &data::trial_options()).unwrap());
    }
    let lasting = all.lasting(data::trial_options().min_samples);
    assert!(!cut.taxel.is_empty() && all.taxel.len() > cut.taxel.len());
    assert_eq!(lasting.taxel, cut.taxel);
    assert_eq!(lasting.component, cut.component);
}

/// Pins that trials in which nothing touched the skin are counted by category, and that the page names the counts.
#[test]
fn trials_that_nothing_touched_are_counted() {
    let trial = |category: &str, touched: &[bool]| {
        let sample = |touched: &bool| underbrush_recording::Sample {
            time_s: 0.0,
            force_n: 0.1,
            motion_m: None,
            region: None,
            touched: Some(*touched),
        };
        Trial {
            trial: 0,
            category: Some(category.into()),
            reach: Some(0),
            patch: None,
            taxel: None,
            samples: touched.iter().map(sample).collect(),
        }
    };
    let trials = Trials {
        component: Vec::new(),
        taxel: vec![
            trial("leaf", &[false, true]),
            trial("leaf", &[false, false]),
            trial("trunk", &[false]),
        ],
    };
    let rows = trials.per_reach([1, 1]);
    let counts: Vec<(usize, usize)> = rows.iter().map(|row| (row.trials, row.untouched)).collect();
    assert_eq!(counts, [(0, 0), (0, 0), (2, 1), (1, 1)]);
    let text = words::untouched(&rows);
    let expected = "They are 1 of 2 by taxel of leaf (50 %), 1 of 1 by taxel of trunk (100 %).";
    assert!(text.contains(expected) && !text.contains("NaN"), "{text}");
}

/// A cell whose majority baseline is half its accuracy.
fn cell(states: usize, accuracy: f64) -> Cell {
    Cell {
        key: CellKey {
            by: TableOneUnit::Taxel,
            features: FeatureSet::FORCE,
            states,
            recipe: "authors".into(),
        },
        accuracy: Accuracy {
            trials: 100,
            accuracy,
            low: 0.0,
            high: 100.0,
            balanced_accuracy: accuracy - 5.0,
            majority_baseline: 0.5 * accuracy,
            touched: None,
            untouched: None,
        },
        paper: 80.24,
    }
}
