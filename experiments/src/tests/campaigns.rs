use super::table_one_paper::TABLE_ONE_PAPER;
use underbrush_classifier::feature::FeatureSet;

use crate::accuracy::{Accuracy, Part};
use crate::definition::{Experiment, OrderingName, Unit};
use crate::experiment::ablation::Ablated;
use crate::experiment::campaigns::{Campaigns, OneOfMany};
use crate::experiment::classifiers::Compared;
use crate::table_cell::{Cell, CellKey, orderings};

const ORDERINGS: [OrderingName; 3] =
    [OrderingName::TaxelsOverComponents, OrderingName::ForceOverForceAndMotion, OrderingName::MoreStates];

fn of(campaigns: &[(u64, OneOfMany)]) -> Result<Option<Campaigns>, underbrush_recording::fault::Fault> {
    Campaigns::of(&Experiment::paper().unwrap(), campaigns)
}

/// The paper's experiment with these published statements.
fn with_orderings(orderings: &[OrderingName]) -> Experiment {
    let mut experiment = Experiment::paper().unwrap();
    experiment.file.published.as_mut().unwrap().orderings = orderings.to_vec();
    experiment
}

/// Figures around an accuracy, per cent.
fn around(accuracy: f64) -> Accuracy {
    Accuracy {
        trials: 100,
        accuracy,
        low: 0.0,
        high: 100.0,
        balanced_accuracy: accuracy - 5.0,
        majority_baseline: 0.5 * accuracy,
        touched: Some(Part {
            trials: 60,
            accuracy: accuracy + 10.0,
            balanced_accuracy: accuracy + 8.0,
            majority_baseline: 55.0,
        }),
        untouched: None,
    }
}

fn cell(states: usize, accuracy: f64) -> Cell {
    Cell {
        key: CellKey { by: Unit::Taxel, features: FeatureSet::FORCE, states, recipe: "authors".into() },
        figures: around(accuracy),
        paper: Some(80.24),
    }
}

fn campaign(table_1: Vec<Cell>, classifiers: &[(&str, f64)]) -> OneOfMany {
    let classifiers =
        classifiers.iter().map(|(name, accuracy)| Compared { classifier: (*name).into(), figures: around(*accuracy) });
    OneOfMany { trials_per_reach: Vec::new(), table_1, classifiers: classifiers.collect() }
}

/// Tests the three statements on the paper's own Table I, where all pairs hold, and on the table with the sign
/// reversed, where none does; and that pairs without one of their cells do not count.
#[test]
fn orderings_are_found_as_they_are() {
    let counts = |sign: f64, without_states: usize| -> Vec<(bool, usize, usize)> {
        let cells = TABLE_ONE_PAPER.into_iter().filter(|own| own.2 != without_states);
        let cells: Vec<Cell<f64>> = cells
            .map(|(by, features, states, paper)| {
                let key = CellKey { by, features, states, recipe: "authors".into() };
                Cell { key, figures: sign * paper, paper: None }
            })
            .collect();
        let found = orderings(&with_orderings(&ORDERINGS), &cells, |accuracy| *accuracy);
        found.iter().map(|own| (own.holds, own.pairs_holding, own.pairs)).collect()
    };
    assert_eq!(counts(1.0, 0), [(true, 6, 6), (true, 6, 6), (true, 8, 8)]);
    assert_eq!(counts(-1.0, 0), [(false, 0, 6), (false, 0, 6), (false, 0, 8)]);
    assert_eq!(counts(1.0, 20), [(true, 4, 4), (true, 4, 4), (true, 4, 4)]);
}

/// Tests that a statement without any pair of cells is left out: one cell contradicts none and supports none.
#[test]
fn statements_without_pairs_are_left_out() {
    let found = orderings(&with_orderings(&ORDERINGS), &[cell(10, 80.0)], |own| own.accuracy);
    assert!(found.is_empty(), "{found:?}");
}

/// Tests that the statement on the number of states names the numbers that the experiment has.
#[test]
fn the_statement_on_states_names_them() {
    let statement = |states: &[usize]| {
        let key = |states: &usize| CellKey {
            by: Unit::Taxel,
            features: FeatureSet::FORCE,
            states: *states,
            recipe: "authors".into(),
        };
        let cells: Vec<Cell<f64>> =
            states.iter().map(|states| Cell { key: key(states), figures: 50.0, paper: None }).collect();
        let found = orderings(&with_orderings(&[OrderingName::MoreStates]), &cells, |accuracy| *accuracy);
        found[0].statement.clone()
    };
    assert_eq!(statement(&[5, 10, 20]), "10 and 20 states are better than 5");
    assert_eq!(statement(&[6, 3]), "6 states are better than 3");
    assert_eq!(statement(&[2, 4, 8, 16]), "4, 8 and 16 states are better than 2");
}

/// Tests mean, sample standard deviation and range of accuracy, balanced accuracy and majority baseline of three
/// campaigns against numbers worked out by hand.
#[test]
fn campaigns_have_mean_and_spread() {
    let one = |accuracy: f64| campaign(vec![cell(10, accuracy)], &[("some", accuracy + 1.0)]);
    let campaigns = [(3, one(70.0)), (4, one(74.0)), (5, one(84.0))];
    let found = of(&campaigns).unwrap().unwrap();
    assert_eq!(found.seeds, [3, 4, 5]);
    let own = &found.table_1[0].figures;
    assert_eq!((own.all.accuracy.mean, own.all.accuracy.min, own.all.accuracy.max), (76.0, 70.0, 84.0));
    // Deviations −6, −2, 8: (36 + 4 + 64) / 2 = 52.
    let deviation = 52.0_f64.sqrt();
    assert!((own.all.accuracy.standard_deviation.unwrap() - deviation).abs() < 1e-12);
    assert_eq!(own.all.balanced_accuracy.mean, 71.0);
    assert!((own.all.balanced_accuracy.standard_deviation.unwrap() - deviation).abs() < 1e-12);
    assert_eq!(own.all.majority_baseline.mean, 38.0);
    assert!((own.all.majority_baseline.standard_deviation.unwrap() - deviation / 2.0).abs() < 1e-12);
    let touched = own.touched.as_ref().unwrap();
    assert_eq!((touched.accuracy.mean, touched.balanced_accuracy.mean), (86.0, 84.0));
    assert!((touched.accuracy.standard_deviation.unwrap() - deviation).abs() < 1e-12);
    assert!(own.untouched.is_none());
    assert!((found.mean_absolute_difference_points["authors"] - 4.24).abs() < 1e-9);
    let some = &found.classifiers[0].figures.all.accuracy;
    assert_eq!((some.mean, some.min, some.max), (77.0, 71.0, 85.0));
    let one = of(&campaigns[..1]).unwrap().unwrap();
    assert!(one.table_1[0].figures.all.accuracy.standard_deviation.is_none());
    assert!(of(&[]).unwrap().is_none());
}

/// Tests that cells and classifiers of campaigns are matched by name, whatever their order, and that a missing or
/// doubled name is an error that names it.
#[test]
fn campaigns_are_matched_by_name() {
    let first = campaign(vec![cell(5, 60.0), cell(10, 80.0)], &[("one", 50.0), ("other", 90.0)]);
    let reversed = campaign(vec![cell(10, 82.0), cell(5, 62.0)], &[("other", 92.0), ("one", 52.0)]);
    let found = of(&[(0, first.clone()), (1, reversed)]).unwrap().unwrap();
    let cells: Vec<(usize, f64)> =
        found.table_1.iter().map(|cell| (cell.key.states, cell.figures.all.accuracy.mean)).collect();
    assert_eq!(cells, [(5, 61.0), (10, 81.0)]);
    let classifiers: Vec<(&str, f64)> =
        found.classifiers.iter().map(|own| (own.classifier.as_str(), own.figures.all.accuracy.mean)).collect();
    assert_eq!(classifiers, [("one", 51.0), ("other", 91.0)]);

    let refused = |other: OneOfMany| of(&[(0, first.clone()), (7, other)]).err().unwrap().to_string();
    let without = refused(campaign(vec![cell(5, 60.0), cell(10, 80.0)], &[("one", 50.0)]));
    assert!(without.contains("seed 7") && without.contains("\"other\""), "{without}");
    let lacking = refused(campaign(vec![cell(5, 60.0)], &[("one", 50.0), ("other", 90.0)]));
    assert!(lacking.contains("taxel, force, 10 states"), "{lacking}");
    let double =
        refused(campaign(vec![cell(5, 60.0), cell(10, 80.0), cell(10, 81.0)], &[("one", 50.0), ("other", 90.0)]));
    assert!(double.contains("several results"), "{double}");
}

/// Tests the row of an ablation on the paper's own Table I, and on the same table with cells alternately 2 points
/// higher and lower.
#[test]
fn the_papers_own_table_is_no_distance_from_itself() {
    let table = |shift: f64| {
        let cells = TABLE_ONE_PAPER.into_iter().zip([1.0, -1.0].into_iter().cycle());
        let cell = move |((by, features, states, paper), sign): ((Unit, FeatureSet, usize, f64), f64)| Cell {
            key: CellKey { by, features, states, recipe: "authors".into() },
            figures: around(paper + sign * shift),
            paper: Some(paper),
        };
        Ablated::new(&Experiment::paper().unwrap(), "any", cells.map(cell), Vec::new())
    };
    let own = table(0.0);
    assert_eq!(own.mean_absolute_difference_points, Some(0.0));
    assert_eq!((own.orderings_holding, own.orderings, own.pairs_holding, own.pairs), (3, 3, 20, 20));
    // (61.76 + 72.22 + 70.75 + 54.41 + 55.55 + 58.50) / 6, and the same for the taxels.
    let (component, taxel) = (own.component.unwrap(), own.taxel.unwrap());
    assert!((component.accuracy - 62.198_333).abs() < 1e-5 && (taxel.accuracy - 75.036_667).abs() < 1e-5);
    assert!((component.balanced_accuracy - 57.198_333).abs() < 1e-5);
    assert!((taxel.majority_baseline - 37.518_333).abs() < 1e-5);
    assert!((table(2.0).mean_absolute_difference_points.unwrap() - 2.0).abs() < 1e-9);
}
