use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use underbrush_recording::{Sample, Trial};

use super::*;
use crate::evaluate::tests::{OneNumber, scored};
use crate::evaluate::{Folds, HeldOut};
use crate::{Classifier, Estimator, ModelError};

const TARGETS: ThresholdTargets = ThresholdTargets { false_positive_rate: 0.1, outlier_prior: 0.05 };

/// Scores of `count` trials per category. The margin in favour of the true category is normal with mean 3 nats and
/// standard deviation 3 nats.
fn drawn(count: usize, seed: u64) -> Evaluation {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let margin = Normal::new(3.0, 3.0).unwrap();
    let rows: Vec<(&str, [f64; 2])> = (0..2 * count)
        .map(|index| {
            let margin = margin.sample(&mut rng);
            match index % 2 {
                0 => ("leaf", [margin, 0.0]),
                _ => ("trunk", [0.0, margin]),
            }
        })
        .collect();
    scored(&rows)
}

fn band(chosen: &ChosenThresholds) -> (f64, f64) {
    match chosen.decision.rule {
        Rule::OutlierBand { uncertain_below, category_above } => (uncertain_below, category_above),
        rule => panic!("{rule:?} is no band"),
    }
}

/// Tests both thresholds against the normal distribution they are drawn from: a mistake of more than t nats has
/// probability Φ(−(t + 3)/3) = α, so t = 3·z(1 − α) − 3; the band holds β = π/(1 − π) of the known trials.
#[test]
fn thresholds_are_the_quantiles_of_the_distribution() {
    let z_at_2_percent = 2.053_749;
    let targets = ThresholdTargets { false_positive_rate: 0.02, outlier_prior: 0.05 };
    let chosen = choose_thresholds(&drawn(50_000, 1), targets).unwrap();
    let (uncertain_below, category_above) = band(&chosen);
    let expected = 3.0 * z_at_2_percent - 3.0;
    // Standard error of the quantile: sqrt(α(1 − α)/n) over the density, here 0.039. The tolerance is four of these.
    assert!((category_above - expected).abs() < 0.16, "{category_above} for {expected}");
    assert!((chosen.outlier - 0.05 / 0.95).abs() < 1e-3, "{}", chosen.outlier);
    assert!(0.0 < uncertain_below && uncertain_below < category_above);
    assert!(chosen.false_positive_rate.values().all(|rate| *rate <= 0.02), "{chosen:?}");
}

/// Tests the rate where its conditions hold, with independent trials and a single scoring rule: over many small
/// training sets, a new trial of another category is classified as a category with at most this probability. With 40
/// trials per category, counting k/n instead of (k+1)/(n+1) would fail.
#[test]
fn new_trials_keep_the_rate_on_average() {
    let (mut mistakes, mut trials) = (0, 0);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for _ in 0..400 {
        let chosen = choose_thresholds(&drawn(40, rng.random()), TARGETS).unwrap();
        let (_, category_above) = band(&chosen);
        let new = drawn(100, rng.random());
        for prediction in &new.predictions {
            let wrong = prediction.scores[usize::from(prediction.category == "leaf")];
            let own = prediction.scores[usize::from(prediction.category == "trunk")];
            mistakes += usize::from(wrong - own > category_above);
            trials += 1;
        }
    }
    let rate = mistakes as f64 / trials as f64;
    // Both categories use the larger threshold, so the mean is below the bound, but it must not be far below.
    assert!(rate <= 0.1 && rate > 0.06, "{rate}");
}

/// Tests the counting on eleven hand-made trials per category: at a rate of 0.25, (k + 1) / 12 ≤ 0.25 allows two
/// mistakes above the threshold.
#[test]
fn counts_stand_at_the_border() {
    let mut rows: Vec<(&str, [f64; 2])> = Vec::new();
    for margin in [-9.0, -7.0, -5.0, -3.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0] {
        rows.push(("leaf", [margin, 0.0]));
        rows.push(("trunk", [0.0, 20.0]));
    }
    let targets = ThresholdTargets { false_positive_rate: 0.25, outlier_prior: 0.2 };
    let chosen = choose_thresholds(&scored(&rows), targets).unwrap();
    // The third largest mistake is 5. The band may hold π/(1 − π) = 1/4 of the known: (k_leaf + 1 + 0 + 1)/12/2 ≤ 1/4
    // for k_leaf ≤ 4, and margins of 5, 4, 3, 2 are in it.
    assert_eq!(band(&chosen), (2.0, 5.0));
    assert_eq!(chosen.false_positive_rate["trunk"], 2.0 / 11.0);
    assert_eq!(chosen.true_positive_rate["leaf"], 4.0 / 11.0);
    assert_eq!((chosen.outlier, chosen.uncertain), (4.0 / 22.0, 1.0 / 22.0));
}

/// Tests that with an outlier prior of zero nothing is called an outlier, not even a margin equal to the threshold.
#[test]
fn no_outliers_expected_leaves_no_band() {
    let targets = ThresholdTargets { outlier_prior: 0.0, ..TARGETS };
    let chosen = choose_thresholds(&drawn(500, 3), targets).unwrap();
    let (uncertain_below, category_above) = band(&chosen);
    assert_eq!((uncertain_below, chosen.outlier), (category_above, 0.0));
    let wide = choose_thresholds(&drawn(500, 3), TARGETS).unwrap();
    assert!(band(&wide).0 < band(&wide).1);
}

/// Tests the errors for rates out of range, too few trials, and mistakes with infinite margin.
#[test]
fn what_cannot_be_held_is_refused() {
    let data = drawn(8, 4);
    let choose = |data: &Evaluation, false_positive_rate, outlier_prior| {
        let targets = ThresholdTargets { false_positive_rate, outlier_prior };
        choose_thresholds(data, targets).unwrap_err()
    };
    for (rate, prior) in [(0.0, 0.1), (1.0, 0.1), (f64::NAN, 0.1), (0.2, 0.5), (0.2, -0.1), (0.2, f64::NAN)] {
        let error = choose(&data, rate, prior);
        assert!(matches!(error, ThresholdError::BadTarget { .. }), "{error}");
    }
    let error = choose(&data, 0.1, 0.1);
    assert!(matches!(error, ThresholdError::TooFewTrials { found: 8, needed: 9, .. }), "{error}");
    let impossible = scored(
        &[("leaf", [f64::NEG_INFINITY, 0.0]); 9].into_iter().chain([("trunk", [0.0, 1.0]); 9]).collect::<Vec<_>>(),
    );
    let error = choose(&impossible, 0.2, 0.1);
    assert!(matches!(error, ThresholdError::NoThreshold { .. }), "{error}");
}

/// The score of trunk after k samples is the sum of their forces, and the score of leaf is 0. Nothing is fitted.
struct Sum;

impl Estimator for Sum {
    fn fit(&self, _: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        Ok(Box::new(OneNumber::new(std::ops::Add::add, |sum_n| [0.0, sum_n])))
    }
}

/// Tests the effect of whole-trial thresholds sample by sample, on trials of 10 samples that can be counted by hand.
/// Trials that are judged rightly have a margin of 1 nat per sample. Three leaves are judged wrongly, by 0.5 nats per
/// sample; a rate of 0.25 allows two mistakes, (k + 1) / 13 ≤ 0.25, so the threshold is 5, and the band of outliers is
/// empty. These three are uncertain, and trials that are judged rightly are uncertain for their first 5 samples.
#[test]
fn thresholds_of_whole_trials_are_late_sample_by_sample() {
    let trial = |number: u64, category: &str, force_n: f64| Trial {
        trial: number,
        category: Some(category.into()),
        reach: None,
        patch: None,
        taxel: None,
        samples: (0..10).map(|k| Sample { time_s: 0.01 * f64::from(k), force_n, ..Sample::default() }).collect(),
    };
    let leaves = (0..12).map(|n| trial(n, "leaf", if n % 4 == 0 { 0.5 } else { -1.0 }));
    let trunks = (12..24).map(|n| trial(n, "trunk", 1.0));
    let trials: Vec<Trial> = leaves.chain(trunks).collect();
    let targets = ThresholdTargets { false_positive_rate: 0.25, outlier_prior: 0.0 };
    let held_out = HeldOut::of(&trials, &Sum, Folds::paper()).unwrap();
    let chosen = held_out.choose_thresholds(targets).unwrap();
    assert_eq!(band(&chosen), (5.0, 5.0));
    assert_eq!((chosen.trials, chosen.uncertain, chosen.outlier), (24, 3.0 / 24.0, 0.0));
    let rates = chosen.sample_by_sample.unwrap();
    assert_eq!(rates.verdicts, 240);
    assert_eq!(rates.uncertain, f64::from(21 * 5 + 3 * 10) / 240.0);
    assert_eq!(rates.outlier, 0.0);
    assert_eq!(rates.true_positive_rate["trunk"], 0.5);
    assert_eq!(rates.false_positive_rate["trunk"], 0.0);
}
