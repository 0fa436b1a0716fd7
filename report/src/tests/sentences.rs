use underbrush_classifier::feature::FeatureSet;
use underbrush_experiments::experiment::example_trials::Typical;
use underbrush_experiments::experiment::outliers::Detection;
use underbrush_experiments::experiment::training_data::TrialsPerReach;
use underbrush_experiments::{CellKey, Unit};

use crate::agreement::{self, Compared};
use crate::section::{example_trials, outliers, training_data};
use crate::tests::elements;

fn key(states: usize) -> CellKey {
    CellKey { by: Unit::Taxel, features: FeatureSet::FORCE, states, recipe: "authors".into() }
}

fn compared(key: &CellKey, accuracy: f64, published: Option<f64>) -> Compared<'_> {
    Compared {
        key,
        accuracy,
        interval: Some((0.0, 100.0)),
        covers: true,
        balanced_accuracy: accuracy - 5.0,
        majority_baseline: 0.5 * accuracy,
        published,
    }
}

/// Tests the agreement with published cells against differences worked out by hand, and that cells below the majority
/// baseline are named with their baseline.
#[test]
fn the_page_says_how_cells_agree() {
    let keys = [key(5), key(10), key(20)];
    let mut cells =
        [compared(&keys[0], 60.2, Some(70.2)), compared(&keys[1], 70.0, Some(68.0)), compared(&keys[2], 70.0, None)];
    let text = |cells: &[Compared]| agreement::sentences("Here", &cells.iter().collect::<Vec<_>>());
    let all = text(&cells);
    for part in [
        "Here, the 2 cells differ from the paper's by 6.0 points on average. 1 is within 3 points",
        "1 is higher than the paper's and 1 lower or equal",
        "The largest difference is in taxel, force, 5 states: 60.2 % here, 70.2 % in the paper.",
    ] {
        assert!(all.contains(part), "{all}");
    }
    assert!(all.ends_with("No cell is below the majority baseline."), "{all}");
    cells[0].majority_baseline = 64.2;
    let below = text(&cells);
    let expected = "1 of 3 cells is below the majority baseline, so always naming the most frequent category would do \
                    better: taxel, force, 5 states, 60.2 % (majority 64.2 %, balanced accuracy 55.2 %).";
    assert!(below.ends_with(expected), "{below}");
    // Without a published figure nothing is compared.
    let without = text(&cells[2..]);
    assert_eq!(without, "Here, no cell is below the majority baseline.");
    cells[2].majority_baseline = 80.0;
    let all = text(&[cells[2], cells[2]]);
    assert!(all.starts_with("Here, 2 of 2 cells are below the majority baseline"), "{all}");
}

/// Tests that the marks of two recipes in one row of the first chart do not cover each other.
#[test]
fn two_recipes_are_drawn_beside_each_other() {
    let keys = ["authors", "modern"].map(|recipe| CellKey { recipe: recipe.into(), ..key(5) });
    let cells = keys.each_ref().map(|key| compared(key, 70.0, None));
    let svg = agreement::dot_plot("cells", "Cells", &cells);
    // The only paths with an absolute H are the whiskers. Marks are 10 px high.
    let whiskers = elements(&svg).into_iter().flat_map(|own| own.1).filter_map(|(_, value)| {
        let (start, _) = value.split_once('H')?;
        start.split_once(' ')?.1.parse().ok()
    });
    let heights: Vec<f64> = whiskers.collect();
    assert!(heights.len() == 2 && (heights[0] - heights[1]).abs() > 9.8, "{heights:?}");
}

/// Tests that the cells of a recipe are named as in English: "1 state", and "authors' recipe".
#[test]
fn cells_have_their_names_in_words() {
    assert_eq!(key(1).with_recipe(), "taxel, force, 1 state, authors' recipe");
    assert_eq!(key(5).name(), "taxel, force, 5 states");
}

/// Tests that the page says when the chosen thresholds leave nearly all taxel frames uncertain, and only then. The
/// share is weighted by frames: 3 · 100 % and 1 · 80 % are 95 %.
#[test]
fn the_page_says_when_its_rule_fails() {
    let row = |rule: &str, taxel_frames, uncertain: f64| Detection {
        rule: rule.into(),
        truth: "leaf",
        taxel_frames,
        percent: [("uncertain_percent".to_owned(), uncertain)].into(),
    };
    let papers = row("the paper's: 15.0 and 80.0", 4000, 0.0);
    let failing = [papers.clone(), row("chosen: 1 and 2", 3000, 100.0), row("chosen: 1 and 2", 1000, 80.0)];
    let text = outliers::chosen_rule_online(&failing).unwrap();
    assert!(text.contains("leave 95.0 % uncertain: the rule fails there."), "{text}");
    let text = outliers::chosen_rule_online(&[papers.clone(), row("chosen: 1 and 2", 3000, 40.0)]).unwrap();
    assert!(text.ends_with("leave 40.0 % uncertain."), "{text}");
    assert_eq!(outliers::chosen_rule_online(&[papers]), None);
}

/// Tests that each statement of the paper on Fig. 5 is compared with the medians, in both directions.
#[test]
fn the_page_says_where_typical_trials_contradict_the_paper() {
    let typical = |category: &str, force_after_100_ms_n, peak_force_n, motion_m| Typical {
        category: category.into(),
        trials: 7,
        force_after_100_ms_n,
        peak_force_n,
        motion_m,
    };
    let trunk = || typical("trunk", 0.2, 0.5, 0.03);
    let text = example_trials::against_paper(&[typical("leaf", 0.1, 0.9, 0.01), trunk()]).unwrap();
    for part in [
        "after contact is larger on trunks, as in the paper (0.20 N, leaves 0.10 N)",
        "the peak force is not larger on trunks, unlike in the paper (0.50 N, leaves 0.90 N)",
        "the motion is larger on trunks, unlike in the paper (3.0 cm, leaves 1.0 cm)",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let text = example_trials::against_paper(&[typical("leaf", 0.1, 0.9, 0.04), trunk()]).unwrap();
    assert!(text.contains("the motion is not larger on trunks, as in the paper"), "{text}");
    assert_eq!(example_trials::against_paper(&[trunk()]), None);
    // All trials on leaves are shorter than 0.1 s.
    let text = example_trials::against_paper(&[typical("leaf", f64::NAN, 0.9, 0.04), trunk()]).unwrap();
    assert!(text.contains("too few of them last 0.1 s") && !text.contains("NaN"), "{text}");
}

/// Tests that the counts of untouched trials are named, and that a category without trials is left out.
#[test]
fn the_page_counts_trials_that_nothing_touched() {
    let row = |category: &str, trials, untouched| TrialsPerReach {
        by: Unit::Taxel,
        category: category.into(),
        trials,
        untouched,
        per_reach: trials as f64,
        paper: None,
    };
    let text = training_data::untouched(&[row("leaf", 2, 1), row("trunk", 1, 1), row("roll", 0, 0)]);
    let expected = "1 of 2 taxel trials of leaf (50 %), 1 of 1 taxel trials of trunk (100 %).";
    assert!(text.contains(expected) && !text.contains("NaN"), "{text}");
}
