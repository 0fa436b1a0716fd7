use underbrush_recording::Sample;

use super::*;
use crate::evaluate::tests::OneNumber;
use crate::{Classifier, FoldBy, ModelError};

/// A trial of `length` samples whose force reveals its category only from the third sample on.
fn trial(number: u64, category: &str, length: usize, touched: bool) -> Trial {
    let samples = (0..length).map(|k| Sample {
        time_s: 0.01 * k as f64,
        force_n: match (category, k) {
            ("trunk", 2..) => 2.0,
            _ => 1.0,
        },
        touched: Some(touched),
        ..Sample::default()
    });
    Trial {
        trial: number,
        category: Some(category.into()),
        reach: None,
        patch: None,
        taxel: None,
        samples: samples.collect(),
    }
}

/// Checks that all trials it is fitted on have at least `min` samples. A contact that has exceeded 1.5 N is called
/// trunk.
struct Threshold {
    min: usize,
}

impl Estimator for Threshold {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        assert!(trials.iter().all(|trial| trial.samples.len() >= self.min));
        let classifier = OneNumber::new(f64::max, |largest_n| match largest_n > 1.5 {
            true => [0.0, 1.0],
            false => [1.0, 0.0],
        });
        Ok(Box::new(classifier))
    }
}

/// Four leaves and twelve trunks. Two of each category have a single sample and were never touched.
fn trials() -> Vec<Trial> {
    let of = |category: &'static str, first: u64, count: u64| {
        (first..first + count).map(move |n| match n % 2 == 0 && n < first + 4 {
            true => trial(n, category, 1, false),
            false => trial(n, category, 5, true),
        })
    };
    of("leaf", 0, 4).chain(of("trunk", 100, 12)).collect()
}

const FOLDS: Folds = Folds { count: 2, by: FoldBy::Position };

/// Tests the series over all contacts on trials that can be counted by hand: short contacts count at every point with
/// their last verdict, although none was used for fitting. Leaving them out overestimates the accuracy.
#[test]
fn short_contacts_count_although_none_is_fitted_on() {
    let all = trials();
    let series = accuracy_by_samples(&all, &Threshold { min: 5 }, FOLDS, 5).unwrap();
    let points: Vec<_> = [0, 2, 9].map(|index| &series[index]).into();
    // After 1 sample everything is classified as leaf; after 3 the ten long trunks are right.
    assert_eq!(points[0].accuracy, 4.0 / 16.0);
    assert_eq!((points[1].samples, points[1].accuracy), (Some(3), 14.0 / 16.0));
    assert_eq!((points[1].lasting, points[1].accuracy_of_lasting), (12, Some(1.0)));
    assert_eq!(points[1].majority_baseline, 12.0 / 16.0);
    assert_eq!(points[1].balanced_accuracy, Some((1.0 + 10.0 / 12.0) / 2.0));
    assert_eq!(points[1].majority_baseline_of_lasting, Some(10.0 / 12.0));
    assert_eq!(points[2].accuracy, 14.0 / 16.0);

    let long: Vec<Trial> = all.into_iter().filter(|trial| trial.samples.len() >= 5).collect();
    let series = accuracy_by_samples(&long, &Threshold { min: 5 }, FOLDS, 1).unwrap();
    assert_eq!(series[2].accuracy, 1.0);
}

/// Tests the accuracy by touch at each point: of the four untouched trials the two leaves are right, because leaf
/// happens to be the verdict without evidence.
#[test]
fn the_series_is_split_by_touch() {
    let series = accuracy_by_samples(&trials(), &Threshold { min: 1 }, FOLDS, 1).unwrap();
    let split = series[9].by_touch.unwrap();
    let (touched, untouched) = (split.touched.unwrap(), split.untouched.unwrap());
    assert_eq!((touched.trials, touched.accuracy), (12, 1.0));
    assert_eq!((untouched.trials, untouched.accuracy), (4, 0.5));
    assert_eq!(split.unknown, None);
    assert_eq!(series[0].by_touch.unwrap().touched.unwrap().accuracy, 2.0 / 12.0);
}

/// Tests that the error names a category whose trials are all too short for fitting.
#[test]
fn nothing_long_enough_to_fit_on_is_refused() {
    let mut all = trials();
    all.retain(|trial| trial.category.as_deref() == Some("trunk") || trial.samples.len() == 1);
    let error = accuracy_by_samples(&all, &Threshold { min: 5 }, FOLDS, 5).unwrap_err();
    let expected = EvaluateError::TooShort { category: "leaf".into(), fold: 1, samples: 5 };
    assert_eq!(error, expected);
}

/// Tests the baseline on the same folds: the two trunks of a single sample were pressed no harder than leaves.
#[test]
fn the_baseline_sees_the_largest_force() {
    let found = Compared::of_peak_force(&trials(), FOLDS).unwrap();
    assert_eq!((found.classifier, found.accuracy.trials, found.accuracy.accuracy), ("peak-force", 16, 14.0 / 16.0));
    assert_eq!(found.accuracy.balanced_accuracy, Some((1.0 + 10.0 / 12.0) / 2.0));
}
