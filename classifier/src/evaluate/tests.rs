use underbrush_recording::{Sample, Trial};

use super::*;
use crate::decision::{Decision, Verdict};
use crate::estimator::{Classifier, ContactScorer, Independent, OnlineScorer};
use crate::hmm_classifier::HmmClassifier;
use crate::{FeatureSet, ModelError, Recipe, SampleFault};

/// Tells leaves from trunks by one number of each contact: a classifier whose scores can be worked out by hand.
#[derive(Clone, Debug)]
pub(super) struct OneNumber {
    number: f64,
    push: fn(f64, f64) -> f64,
    scores: fn(f64) -> [f64; 2],
}

impl OneNumber {
    /// `push` computes the number from the previous one (0 at first) and the force of a sample, and `scores` computes
    /// the scores of leaf and trunk from the number.
    pub(super) fn new(push: fn(f64, f64) -> f64, scores: fn(f64) -> [f64; 2]) -> Self {
        let number = 0.0;
        OneNumber { number, push, scores }
    }
}

impl Classifier for OneNumber {
    fn name(&self) -> &'static str {
        "test"
    }

    fn features(&self) -> FeatureSet {
        FeatureSet::FORCE
    }

    fn categories(&self) -> Vec<String> {
        vec!["leaf".into(), "trunk".into()]
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        Box::new(Independent::new(self.clone(), contacts))
    }

    fn file_entries(&self) -> Vec<(&'static str, serde_json::Value)> {
        Vec::new()
    }
}

impl ContactScorer for OneNumber {
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault> {
        self.number = (self.push)(self.number, sample.force_n);
        Ok(true)
    }

    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError> {
        scores.copy_from_slice(&(self.scores)(self.number));
        Ok(())
    }
}

/// Trials of 12 samples. Leaves reach about 0.4 N and move far; trunks reach about 2 N and move little.
fn trials(leaves: u64, trunks: u64) -> Vec<Trial> {
    let trial = |number: u64, category: &str, reach: u64, top_n: f64, speed: f64| {
        let wobble = |k: f64| 1.0 + 0.2 * (1.7 * k + number as f64).sin();
        let samples = (0..12)
            .map(|k| {
                let k = f64::from(k);
                let force_n = top_n * (1.0 - (-k / 3.0).exp()) * wobble(k) + 0.05;
                Sample {
                    time_s: 0.01 * k,
                    force_n,
                    motion_m: Some(speed * 0.01 * k * wobble(k + 0.5)),
                    ..Sample::default()
                }
            })
            .collect();
        Trial { trial: number, category: Some(category.into()), reach: Some(reach), patch: None, taxel: None, samples }
    };
    let leaves = (0..leaves).map(|n| trial(n, "leaf", n / 3, 0.4, 0.2));
    let trunks = (0..trunks).map(|n| trial(100 + n, "trunk", 50 + n / 3, 2.0, 0.02));
    leaves.chain(trunks).collect()
}

fn recipe() -> Recipe {
    Recipe { states: 3, ..Recipe::authors() }
}

/// Tests that folds by position are the first and second half of each category, even if the categories alternate in the
/// table or have an odd number of trials.
#[test]
fn positions_split_each_category_in_order() {
    let mut table = trials(3, 5);
    table.swap(1, 6);
    let table: Vec<&Trial> = table.iter().collect();
    let names: Vec<&str> = table.iter().map(|trial| trial.category.as_deref().unwrap()).collect();
    assert_eq!(names, ["leaf", "trunk", "leaf", "trunk", "trunk", "trunk", "leaf", "trunk"]);
    assert_eq!(Folds::paper().assign(&table), Ok(vec![0, 0, 0, 0, 0, 1, 1, 1]));
}

/// Tests that folds by reach keep each reach in one fold and divide the reaches of each category.
#[test]
fn reaches_stay_together() {
    let table = trials(12, 9);
    let table: Vec<&Trial> = table.iter().collect();
    let folds = Folds { count: 3, by: FoldBy::Reach }.assign(&table).unwrap();
    let mut fold_of = std::collections::BTreeMap::new();
    for (trial, fold) in table.iter().zip(&folds) {
        assert_eq!(*fold_of.entry(trial.reach).or_insert(*fold), *fold);
    }
    // Leaves are in reaches 0 to 3, and trunks in the others.
    assert_eq!(fold_of.into_values().collect::<Vec<_>>(), [0, 1, 2, 0, 0, 1, 2]);
}

/// Tests the errors for one fold, categories smaller than the folds, missing reaches and missing truth.
#[test]
fn impossible_splits_are_named() {
    let error = |trials: &[Trial], count, by| {
        cross_validate(trials, &recipe(), Folds { count, by }, &Decision::argmax()).unwrap_err()
    };
    assert_eq!(error(&trials(4, 4), 1, FoldBy::Position), EvaluateError::FoldCount { found: 1 });
    let few = EvaluateError::TooFew { category: "leaf".into(), found: 1, unit: "trials", folds: 2 };
    assert_eq!(error(&trials(1, 4), 2, FoldBy::Position), few);
    let few = EvaluateError::TooFew { category: "leaf".into(), found: 2, unit: "reaches", folds: 3 };
    assert_eq!(error(&trials(6, 9), 3, FoldBy::Reach), few);
    let mut homeless = trials(4, 4);
    homeless[2].reach = None;
    assert_eq!(error(&homeless, 2, FoldBy::Reach), EvaluateError::NoReach { trial: 2 });
    let mut blind = trials(2, 2);
    blind.iter_mut().for_each(|trial| trial.category = None);
    assert_eq!(error(&blind, 2, FoldBy::Position), EvaluateError::NoTruth);
    assert_eq!(error(&[], 2, FoldBy::Position), EvaluateError::NoTruth);
}

/// Tests that a category that is a minority in all of its reaches, which are in one fold, is not silently left out of the fit
/// of that fold, in any kind of cross-validation, and that it is no obstacle if it is in reaches of both folds.
#[test]
fn a_category_in_one_fold_only_is_refused() {
    let mut table = trials(0, 12);
    let folds = Folds { count: 2, by: FoldBy::Reach };
    // Four reaches with three trunks each. The leaves are in every second one, so the second fold holds them.
    table[4].category = Some("leaf".into());
    table[10].category = Some("leaf".into());
    let error = cross_validate(&table, &recipe(), folds, &Decision::argmax()).unwrap_err();
    let expected = EvaluateError::FewCategories {
        fold: 2,
        folds: 2,
        left: vec!["trunk".into()],
        all: vec!["leaf".into(), "trunk".into()],
        remedy: "use more reaches; an evaluation can also use fewer folds or group by position",
    };
    assert_eq!(error, expected);
    assert!(error.to_string().starts_with(
        "without fold 2 of 2, only trunk of the categories leaf, trunk are left to fit to; use more reaches"
    ));
    assert_eq!(HeldOut::of(&table, &recipe(), folds).unwrap_err(), expected);
    assert_eq!(accuracy_by_samples(&table, &recipe(), folds, 1).unwrap_err(), expected);
    table[1].category = Some("leaf".into());
    let result = cross_validate(&table, &recipe(), folds, &Decision::argmax()).unwrap();
    assert!(result.predictions.iter().all(|prediction| prediction.scores.len() == 2));
}

/// Tests that a category that is in several reaches may be the most frequent one in a single reach.
#[test]
fn a_category_may_be_the_majority_of_one_reach() {
    let mut table = trials(12, 0);
    for trunk in [0, 3, 4, 9] {
        table[trunk].category = Some("trunk".into());
    }
    let used: Vec<&Trial> = table.iter().collect();
    let folds = Folds { count: 2, by: FoldBy::Reach }.assign(&used).unwrap();
    assert_eq!(folds, [0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0]);
    assert_eq!(Folds::for_thresholds(&table).count, 3);
}

/// Tests that the remedy for a category that is too small is possible wherever the error occurs: there are never fewer
/// than two folds, and those for thresholds cannot be chosen.
#[test]
fn the_remedy_for_a_small_category_is_possible() {
    let text = |found: usize, unit: &'static str, folds: usize| {
        let category = "leaf".into();
        let error = EvaluateError::TooFew { category, found, unit, folds };
        error.to_string()
    };
    assert_eq!(
        text(1, "reaches", 2),
        "category leaf is in 1 reach, fewer than the 2 folds; use more data; an evaluation can also group by position"
    );
    assert_eq!(text(1, "trials", 2), "category leaf has 1 trial, fewer than the 2 folds; use more data");
    assert_eq!(
        text(3, "trials", 5),
        "category leaf has 3 trials, fewer than the 5 folds; use fewer folds or more data"
    );
    let few = trials(3, 9);
    let error = HeldOut::of(&few, &recipe(), Folds::for_thresholds(&few)).unwrap_err();
    assert!(error.to_string().starts_with("category leaf is in 1 reach, fewer than the 2 folds"));
}

/// Tests order, folds and figures against a cross-validation assembled by hand from two fits.
#[test]
fn cross_validation_tests_each_trial_once_on_the_other_fold() {
    let mut table = trials(9, 8);
    table[3].category = Some("block".into());
    table[4].category = None;
    let result = cross_validate(&table, &recipe(), Folds::paper(), &Decision::argmax()).unwrap();
    table.drain(3..5);
    let numbers: Vec<u64> = table.iter().map(|trial| trial.trial).collect();
    assert_eq!(result.predictions.iter().map(|prediction| prediction.trial).collect::<Vec<_>>(), numbers);
    let folds: Vec<usize> = result.predictions.iter().map(|prediction| prediction.fold).collect();
    assert_eq!(folds, [0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1]);
    for tested in 0..2 {
        let part = |inside: bool| -> Vec<Trial> {
            let pairs = table.iter().zip(&folds).filter(|(_, fold)| (**fold == tested) == inside);
            pairs.map(|(trial, _)| trial.clone()).collect()
        };
        let models = HmmClassifier::train(&part(false), &recipe()).unwrap();
        assert_eq!(result.training[tested], models.training);
        let direct = evaluate(&models, &part(true), &Decision::argmax()).unwrap();
        let of_fold = result.predictions.iter().filter(|prediction| prediction.fold == tested);
        assert!(
            direct.predictions.iter().map(|p| (&p.verdict, &p.scores)).eq(of_fold.map(|p| (&p.verdict, &p.scores)))
        );
    }
    let categories = result.known_categories();
    let records = result.predictions.iter().map(|prediction| prediction.record(categories));
    let correct = records.filter(|record| record.is_right(categories)).count();
    assert_eq!(result.accuracy, correct as f64 / 15.0);
    assert!(result.accuracy > 0.9, "such different objects must be told apart: {}", result.accuracy);
}

pub(super) fn predictions(rows: &[(&str, &str, u64, usize)]) -> Vec<Prediction> {
    let verdict = |name: &str| match name {
        "uncertain" => Verdict::Uncertain,
        "outlier" => Verdict::Outlier,
        name => Verdict::Category(name.into()),
    };
    rows.iter()
        .flat_map(|&(category, name, reach, count)| {
            let prediction = Prediction {
                trial: 0,
                reach: Some(reach),
                category: category.into(),
                fold: 0,
                samples: 1,
                touched: None,
                scores: vec![],
                verdict: verdict(name),
            };
            std::iter::repeat_n(prediction, count)
        })
        .collect()
}

/// An evaluation of leaf and trunk scores, by argmax.
pub(super) fn scored(rows: &[(&str, [f64; 2])]) -> Evaluation {
    let names = ["leaf".to_owned(), "trunk".to_owned()];
    let judge = Decision::argmax().prepare(&names).unwrap();
    let predictions = rows.iter().map(|(category, scores)| Prediction {
        trial: 0,
        reach: Some(0),
        category: (*category).into(),
        fold: 0,
        samples: 1,
        touched: None,
        scores: scores.to_vec(),
        verdict: judge.choose(scores),
    });
    Evaluation::of(predictions.collect(), &names, vec![]).unwrap()
}

/// Tests rows, columns, recall, precision and F1 on hand-made counts that include an outlier.
#[test]
fn figures_follow_from_the_counts() {
    let rows = [
        ("leaf", "leaf", 1, 6),
        ("leaf", "trunk", 1, 2),
        ("leaf", "uncertain", 1, 2),
        ("trunk", "trunk", 2, 7),
        ("trunk", "leaf", 2, 2),
        ("trunk", "outlier", 2, 1),
        ("outlier", "outlier", 3, 3),
        ("outlier", "trunk", 3, 1),
        ("block", "trunk", 3, 1),
    ];
    let result = Evaluation::of(predictions(&rows), &["leaf".into(), "trunk".into()], vec![]).unwrap();
    assert_eq!(result.confusion.truth, ["block", "leaf", "outlier", "trunk"]);
    assert_eq!(result.confusion.verdict, ["leaf", "trunk", "uncertain", "outlier"]);
    assert_eq!(result.confusion.count, [[0, 1, 0, 0], [6, 2, 2, 0], [0, 1, 0, 3], [2, 7, 0, 1]]);
    assert_eq!(result.accuracy, 16.0 / 25.0);
    let [block, leaf, outlier, trunk] = result.categories.as_slice() else { panic!("four rows") };
    assert_eq!((leaf.recall, leaf.precision, leaf.uncertain), (0.6, Some(0.75), 2));
    assert!((leaf.f1 - 2.0 * 0.6 * 0.75 / (0.6 + 0.75)).abs() < 1e-15);
    assert_eq!((trunk.recall, trunk.precision, trunk.outlier), (0.7, Some(7.0 / 11.0), 1));
    assert_eq!((outlier.recall, outlier.precision), (0.75, Some(0.75)));
    assert_eq!((block.recall, block.precision, block.f1), (0.0, None, 0.0));
}

/// Tests Wilson's interval of 81 of 263 (Newcombe 1998, table I, method 3: 0.2553 to 0.3662), and the ends.
#[test]
fn wilson_intervals_match_published_figures() {
    let interval = wilson(81, 263);
    assert!((interval.low - 0.2553).abs() < 5e-5 && (interval.high - 0.3662).abs() < 5e-5, "{interval:?}");
    let none = wilson(0, 20);
    assert!(none.low == 0.0 && (none.high - 0.1611).abs() < 5e-5, "{none:?}");
    assert!((1..500).all(|trials| wilson(trials, trials).high == 1.0 && wilson(0, trials).low == 0.0));
    assert_eq!(wilson(0, 0), Interval { low: 0.0, high: 1.0 });
}

/// Tests that the bootstrap over reaches accounts for dependence within them: in each of 20 reaches, all 50 trials are
/// right or all are wrong. The accuracy has the standard error of 20 draws, sqrt(0.25/20) = 0.112, not of 1000.
#[test]
fn clusters_widen_the_interval() {
    let rows: Vec<_> =
        (0..20).map(|reach| ("leaf", if reach % 2 == 0 { "leaf" } else { "trunk" }, reach, 50)).collect();
    let clustered = predictions(&rows);
    let models = ["leaf".to_owned(), "trunk".to_owned()];
    let right = |own: &Prediction| (own.reach, own.record(&models).is_right(&models));
    let bootstrap = |own: &[Prediction]| bootstrap_by_reach(own.iter().map(right));
    let interval = bootstrap(&clustered).unwrap();
    let half = (interval.high - interval.low) / 2.0;
    assert!((half / (1.96 * 0.1118) - 1.0).abs() < 0.15, "{interval:?}");
    let naive = wilson(500, 1000);
    assert!(half > 3.0 * (naive.high - naive.low) / 2.0);
    assert_eq!(bootstrap(&clustered), Some(interval));
    // One reach says nothing about others, and twenty of which all are right do not say that all others are.
    assert_eq!(bootstrap(&predictions(&[("leaf", "leaf", 0, 50)])), None);
    let right: Vec<_> = (0..20).map(|reach| ("leaf", "leaf", reach, 50)).collect();
    assert_eq!(bootstrap(&predictions(&right)), Some(wilson(20, 20)));
    // Neither do twenty of which each is half right.
    let half: Vec<_> = (0..20).flat_map(|reach| [("leaf", "leaf", reach, 25), ("leaf", "trunk", reach, 25)]).collect();
    assert_eq!(bootstrap(&predictions(&half)), Some(wilson(10, 20)));
    let mut homeless = clustered;
    homeless[0].reach = None;
    assert_eq!(bootstrap(&homeless), None);
}

/// Tests that the interval of a balanced share is that of the mean over classes. In each of 20 reaches nine leaves are right, and in every
/// second reach the trunk is right as well. The share is 0.75, with half the standard error of 20 draws.
#[test]
fn balanced_shares_have_their_own_interval() {
    let counts = (0..20).flat_map(|reach| [(reach, 0, [9, 9]), (reach, 1, [usize::from(reach % 2 == 0), 1])]);
    let interval = bootstrap_balanced(counts).unwrap();
    let half = (interval.high - interval.low) / 2.0;
    assert!((half / (1.96 * 0.1118 / 2.0) - 1.0).abs() < 0.15, "{interval:?}");
    assert!(interval.low < 0.75 && 0.75 < interval.high, "{interval:?}");
    // A reach in which there is nothing to count is no reach.
    assert_eq!(bootstrap_balanced([(0, 0, [1, 2]), (1, 0, [0, 0])]), None);
}
