use super::*;
use crate::evaluate::tests::predictions;
use crate::evaluate::{EvaluateError, Evaluation};

/// The figures of a classifier of leaf and trunk, from rows of truth, verdict and count.
fn accuracy(rows: &[(&str, &str, usize)]) -> Accuracy {
    evaluation(rows).confusion.accuracy().unwrap()
}

fn evaluation(rows: &[(&str, &str, usize)]) -> Evaluation {
    let rows: Vec<_> = rows.iter().map(|&(truth, verdict, count)| (truth, verdict, 0, count)).collect();
    Evaluation::of(predictions(&rows), &["leaf".into(), "trunk".into()], vec![]).unwrap()
}

/// Tests the definitions on hand-made counts, 24 of 30 leaves and 4 of 10 trunks found, and that the evaluation has the
/// same figures.
#[test]
fn baseline_and_balance_follow_from_the_counts() {
    let rows = [("leaf", "leaf", 24), ("leaf", "trunk", 6), ("trunk", "trunk", 4), ("trunk", "leaf", 6)];
    let found = evaluation(&rows);
    let expected = Accuracy {
        trials: 40,
        accuracy: 28.0 / 40.0,
        majority_baseline: 30.0 / 40.0,
        balanced_accuracy: Some((24.0 / 30.0 + 4.0 / 10.0) / 2.0),
    };
    assert_eq!(found.confusion.accuracy(), Some(expected));
    assert_eq!(found.accuracy, expected.accuracy);
    assert_eq!(found.majority_baseline, expected.majority_baseline);
    assert_eq!(found.balanced_accuracy, expected.balanced_accuracy);
}

/// Tests that a classifier that always says trunk reaches exactly the majority baseline, and a balanced accuracy of one
/// half, whatever the fraction of trunks.
#[test]
fn one_verdict_for_all_is_the_baseline() {
    for (leaves, trunks) in [(10, 90), (40, 60), (3, 500)] {
        let found = accuracy(&[("leaf", "trunk", leaves), ("trunk", "trunk", trunks)]);
        assert_eq!(found.accuracy, found.majority_baseline, "{leaves} leaves");
        assert_eq!(found.balanced_accuracy, Some(0.5), "{leaves} leaves");
    }
}

/// Tests that uncertain counts as wrong, and that outlier is wrong for a known category.
#[test]
fn uncertain_and_outlier_are_wrong() {
    let found =
        accuracy(&[("leaf", "leaf", 6), ("leaf", "uncertain", 4), ("trunk", "trunk", 9), ("trunk", "outlier", 1)]);
    assert_eq!(found.accuracy, 15.0 / 20.0);
    assert_eq!(found.balanced_accuracy, Some((0.6 + 0.9) / 2.0));
    assert_eq!(found.majority_baseline, 0.5);
}

/// Tests that outlier is right for categories that the classifier does not know, in the accuracy as in its interval, and that
/// always saying so is the baseline if it is right most often.
#[test]
fn outlier_is_right_for_foreign_categories() {
    let rows = [("leaf", "leaf", 6), ("bottle", "outlier", 4), ("bottle", "leaf", 1), ("branch", "outlier", 3)];
    let found = evaluation(&rows);
    assert_eq!(found.accuracy, 13.0 / 14.0);
    assert_eq!(found.accuracy_interval_by_trial, wilson(13, 14));
    assert_eq!(found.majority_baseline, 8.0 / 14.0);
    assert_eq!(found.balanced_accuracy, Some(1.0));
}

/// Tests that outliers count in accuracy and baseline but not in the balanced accuracy, which covers known categories
/// only, and that no verdict is right for a block, not even outlier.
#[test]
fn a_block_is_no_outlier() {
    let found = accuracy(&[
        ("leaf", "leaf", 2),
        ("leaf", "trunk", 2),
        ("outlier", "outlier", 5),
        ("outlier", "leaf", 1),
        ("block", "outlier", 7),
        ("block", "trunk", 3),
    ]);
    assert_eq!(found.trials, 20);
    assert_eq!(found.accuracy, 7.0 / 20.0);
    assert_eq!(found.majority_baseline, 6.0 / 20.0);
    assert_eq!(found.balanced_accuracy, Some(0.5));
}

/// Tests that there is no balanced accuracy without a trial of a known category, and no accuracy without any trial.
#[test]
fn without_trials_there_are_no_figures() {
    assert_eq!(accuracy(&[("outlier", "leaf", 3)]).balanced_accuracy, None);
    assert_eq!(accuracy(&[("block", "leaf", 3)]).majority_baseline, 0.0);
    let models = ["leaf".to_owned(), "trunk".to_owned()];
    assert_eq!(ConfusionMatrix::of([], &models).accuracy(), None);
    assert_eq!(Evaluation::of(vec![], &models, vec![]), Err(EvaluateError::NoTruth));
}

/// Tests the accuracy of touched and untouched trials, each with its own baseline and balanced accuracy, and that there
/// is none by touch if it is unknown for all trials.
#[test]
fn touched_and_untouched_are_judged_apart() {
    let models = ["leaf".to_owned(), "trunk".to_owned()];
    let with = |rows: &[(&str, &str, usize)], touched| {
        let rows: Vec<_> = rows.iter().map(|&(truth, verdict, count)| (truth, verdict, 0, count)).collect();
        let mut predictions = predictions(&rows);
        predictions.iter_mut().for_each(|prediction| prediction.touched = touched);
        predictions
    };
    let mut all = with(&[("leaf", "leaf", 6), ("trunk", "trunk", 3), ("trunk", "leaf", 1)], Some(true));
    all.extend(with(&[("leaf", "leaf", 1), ("trunk", "leaf", 9)], Some(false)));
    all.extend(with(&[("leaf", "leaf", 2)], None));
    let split = Evaluation::of(all, &models, vec![]).unwrap().by_touch.unwrap();
    let figures = |trials, accuracy, majority_baseline, balanced| Accuracy {
        trials,
        accuracy,
        majority_baseline,
        balanced_accuracy: Some(balanced),
    };
    assert_eq!(split.touched, Some(figures(10, 0.9, 0.6, (1.0 + 0.75) / 2.0)));
    assert_eq!(split.untouched, Some(figures(10, 0.1, 0.9, 0.5)));
    assert_eq!(split.unknown, Some(figures(2, 1.0, 1.0, 1.0)));
    assert_eq!(evaluation(&[("leaf", "leaf", 3)]).by_touch, None);
}
