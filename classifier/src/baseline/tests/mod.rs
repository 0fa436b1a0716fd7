use rand::{RngExt, SeedableRng};
pub(crate) mod nearest_mean;

use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use underbrush_recording::{Region, Sample, Trial};

use super::*;
use crate::feature::{AREA, Feature, FeatureError, FeatureSet, MOTION, SampleFault};
use crate::model_file::Model;
use crate::registry::CLASSIFIERS;
use crate::{ClassifierKind, Estimator, ModelError, Recipe};

/// Presses whose force rises by `newtons_per_s` with noise, on a region of `taxels`.
fn press(number: u64, category: &str, newtons_per_s: f64, taxels: u32, length: usize) -> Trial {
    let mut rng = ChaCha8Rng::seed_from_u64(number);
    let samples = (0..length).map(|k| {
        let time_s = 0.01 * k as f64;
        let force_n = 0.1 + newtons_per_s * time_s + 0.05 * rng.random::<f64>();
        Sample {
            time_s,
            force_n,
            motion_m: Some(0.1 * time_s),
            region: Some(Region { taxels, largest_force_n: 1.5 * force_n, force_sum_n: f64::from(taxels) * force_n }),
            ..Sample::default()
        }
    });
    Trial {
        trial: number,
        category: Some(category.into()),
        reach: Some(number),
        patch: None,
        taxel: None,
        samples: samples.collect(),
    }
}

/// Leaves press softly, trunks hard; 30 of each, 5 to 34 samples long.
fn trials() -> Vec<Trial> {
    let leaves = (0..30).map(|n| press(n, "leaf", 1.0, 2, 5 + n as usize));
    let trunks = (30..60).map(|n| press(n, "trunk", 6.0, 4, n as usize - 25));
    leaves.chain(trunks).collect()
}

/// Every classifier of the list with its default options, except that hidden Markov models have fewer states than the
/// shortest trial has samples, and that `MiniRocket` has fewer thresholds, which is faster.
fn estimators() -> Vec<(&'static str, Box<dyn Estimator>)> {
    let estimator = |kind: &ClassifierKind| -> Box<dyn Estimator> {
        match kind.name {
            "hmm" => Box::new(Recipe { states: 3, ..Recipe::authors() }),
            "mini-rocket" => Box::new(MiniRocket { thresholds: 84, ..MiniRocket::default() }),
            _ => (kind.estimator)(None),
        }
    };
    CLASSIFIERS.map(|kind| (kind.name, estimator(kind))).into()
}

#[test]
fn every_estimator_tells_different_things_apart_and_never_looks_ahead() {
    // Tests, for every classifier in the list, that new presses are told apart, that the scores after k samples are
    // those of a trial that ended there, and that larger counts mean the whole trial.
    let trials = trials();
    let known: Vec<&Trial> = trials.iter().collect();
    for (name, estimator) in estimators() {
        let classifier = estimator.fit(&known).unwrap();
        assert_eq!(classifier.categories(), ["leaf", "trunk"], "{name}");
        for (category, speed, taxels) in [("leaf", 1.0, 2), ("trunk", 6.0, 4)] {
            let new = press(1000, category, speed, taxels, 20);
            let scores = classifier.scores_after(&new, &[1, 7, 20, 99]).unwrap();
            let own = usize::from(category == "trunk");
            assert!(scores[2][own] > scores[2][1 - own], "{name}: {category} scores {:?}", scores[2]);
            assert_eq!(scores[3], scores[2], "{name}");
            let mut ended = new.clone();
            ended.samples.truncate(7);
            assert_eq!(classifier.scores_of_all(&[&ended]).unwrap().remove(0), scores[1], "{name} looks ahead");
        }
    }
}

#[test]
fn frequent_categories_have_no_advantage() {
    // Tests, for every classifier in the list, that priors are equal: if both categories press alike, a category with
    // five times as many trials gets half of the verdicts. There are sixty training sets with 40 new presses each. The
    // verdicts of one set come from one classifier and depend on each other, so the standard error is computed over the
    // sets. A deviation of 4 standard errors is allowed.
    //
    // Nearest neighbours cannot halve their 5 votes: a vote for the rare category weighs as much as five for the other,
    // so it wins with a single vote, which it has with probability 1 − (5/6)⁵ = 0.598. Trees have small leaves, and where
    // nothing tells the categories apart, more of them hold none of the rare category than twice its share.
    // MiniRocket's many weights follow the chance of 40 trials farther from the mean than that of 200.
    // docs/classifiers.md says so. The rare category must still get a quarter of the verdicts.
    let draw = |number: u64, category: &str| {
        let mut rng = ChaCha8Rng::seed_from_u64(9000 + number);
        press(number, category, 1.0 + 5.0 * rng.random::<f64>(), 3, 12)
    };
    const SETS: u64 = 60;
    for (name, estimator) in estimators() {
        let shares: Vec<f64> = (0..SETS)
            .into_par_iter()
            .map(|set| {
                let trials: Vec<Trial> =
                    (0..240).map(|n| draw(1000 * set + n, if n % 6 == 0 { "leaf" } else { "trunk" })).collect();
                let classifier = estimator.fit(&trials.iter().collect::<Vec<_>>()).unwrap();
                let new = (0..40).map(|n| draw(100_000 + 1000 * set + n, "leaf"));
                let leaves = new.filter(|press| {
                    let scores = classifier.scores_of_all(&[press]).unwrap().remove(0);
                    scores[0] > scores[1]
                });
                leaves.count() as f64 / 40.0
            })
            .collect();
        let mean = shares.iter().sum::<f64>() / SETS as f64;
        let variance = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / (SETS - 1) as f64;
        let standard_error = (variance / SETS as f64).sqrt();
        let expected = match name {
            "nearest-neighbours" => 1.0 - (5.0f64 / 6.0).powi(5),
            _ => 0.5,
        };
        assert!(standard_error < 0.05, "{name}: ± {standard_error} is no test");
        if ["trees", "mini-rocket"].contains(&name) {
            assert!((0.25..0.5).contains(&mean), "{name}: {mean} ± {standard_error}");
            continue;
        }
        assert!(
            (mean - expected).abs() < 4.0 * standard_error,
            "{name}: {mean} ± {standard_error}, expected {expected}"
        );
    }
}

#[test]
fn logistic_regression_is_at_its_minimum() {
    // Tests that the solver finds the minimum of the convex objective: all its derivatives are zero, computed by
    // central differences from its definition in the documentation. Also tests that posteriors sum to one.
    let trials: Vec<Trial> = trials();
    let known: Vec<&Trial> = trials.iter().collect();
    let estimator = Logistic::default();
    let classifier = estimator.fit(&known).unwrap();
    for trial in &trials {
        let total: f64 = classifier.scores_of_all(&[trial]).unwrap().remove(0).iter().map(|score| score.exp()).sum();
        assert!((total - 1.0).abs() < 1e-12);
    }
    assert!(logistic::largest_slope(&known, &estimator) < 1e-5);
}

#[test]
fn windows_are_padded_with_their_last_sample() {
    // Tests the fixed window: a press that ended after 10 samples and one that went on unchanged have the same scores,
    // and samples after the window are ignored.
    let trials = trials();
    let classifier = NearestNeighbours::default().fit(&trials.iter().collect::<Vec<_>>()).unwrap();
    let short = press(1000, "leaf", 3.0, 3, 10);
    let mut held = short.clone();
    for k in 10..90 {
        let mut sample = short.samples[9].clone();
        sample.time_s = 0.01 * f64::from(k);
        held.samples.push(sample);
    }
    let scores = classifier.scores_of_all(&[&short]).unwrap().remove(0);
    assert_eq!(classifier.scores_of_all(&[&held]).unwrap().remove(0), scores);
    held.samples[60].force_n = 50.0;
    assert_eq!(classifier.scores_of_all(&[&held]).unwrap().remove(0), scores);
    held.samples[40].force_n = 50.0;
    assert_ne!(classifier.scores_of_all(&[&held]).unwrap().remove(0), scores);
}

/// Tests that nearest neighbours of a category that is twenty times as frequent as another one win if all five are its own.
#[test]
fn neighbours_of_a_frequent_category_count() {
    let leaves = (0..40).map(|number| press(number, "leaf", 1.0, 2, 20));
    let trials: Vec<Trial> = leaves.chain((40..42).map(|number| press(number, "trunk", 6.0, 4, 20))).collect();
    let classifier = NearestNeighbours::default().fit(&trials.iter().collect::<Vec<_>>()).unwrap();
    let scores = classifier.scores_of_all(&[&press(1000, "leaf", 1.0, 2, 20)]).unwrap().remove(0);
    assert!(scores[0] > scores[1], "{scores:?}");
}

/// Tests that a feature that never varies has no influence on nearest neighbours, although the rounding of its mean
/// leaves a variance, and that the model can be saved.
#[test]
fn a_constant_feature_is_left_out_of_the_neighbours() {
    let mut trials = trials();
    for sample in trials.iter_mut().flat_map(|trial| &mut trial.samples) {
        sample.motion_m = Some(0.1);
    }
    let estimator = NearestNeighbours { features: FeatureSet::FORCE_AND_MOTION, ..NearestNeighbours::default() };
    let classifier = estimator.fit(&trials.iter().collect::<Vec<_>>()).unwrap();
    let new = press(1000, "leaf", 3.0, 2, 20);
    let mut moved = new.clone();
    moved.samples.iter_mut().for_each(|sample| sample.motion_m = Some(0.7));
    assert_eq!(
        classifier.scores_of_all(&[&moved]).unwrap().remove(0),
        classifier.scores_of_all(&[&new]).unwrap().remove(0)
    );
    Model::new(classifier).save_string().unwrap();
}

#[test]
fn trials_that_cannot_be_fitted_are_refused() {
    // Tests the errors for trials without categories, for trials that lack the region, and for one without samples.
    let mut trials = trials();
    for (name, estimator) in estimators().into_iter().skip(1) {
        let blind: Vec<Trial> = trials.iter().cloned().map(|trial| Trial { category: None, ..trial }).collect();
        let error = estimator.fit(&blind.iter().collect::<Vec<_>>()).err();
        assert_eq!(error, Some(ModelError::NoCategories(60)), "{name}");
        let mut hollow = trials.clone();
        hollow[7].samples.clear();
        let error = estimator.fit(&hollow.iter().collect::<Vec<_>>()).err();
        let empty = FeatureError::Empty(hollow[7].trial);
        assert_eq!(error, Some(ModelError::Feature(empty)), "{name}");
    }
    trials[0].samples[2].region = None;
    let lacks = |feature: &'static Feature| {
        let fault = SampleFault::Missing(feature);
        ModelError::Feature(FeatureError::BadSample { trial: 0, sample: 2, fault })
    };
    let missing = lacks(&AREA);
    let known: Vec<&Trial> = trials.iter().collect();
    assert_eq!(Logistic::default().fit(&known).err(), Some(missing.clone()));
    assert_eq!(NearestNeighbours::default().fit(&known).err(), Some(missing));
    assert!(NaiveBayes::default().fit(&known).is_ok());
    trials[0].samples[2].motion_m = None;
    let missing = lacks(&MOTION);
    let known: Vec<&Trial> = trials.iter().collect();
    assert_eq!(NaiveBayes::default().fit(&known).err(), Some(missing.clone()));
    assert_eq!(EchoStateNetwork::default().fit(&known).err(), Some(missing));
}

/// Tests that every option of the baselines has a range, and that the error names the option.
#[test]
fn options_outside_their_range_are_refused() {
    let trials = trials();
    let known: Vec<&Trial> = trials.iter().collect();
    let neighbours = NearestNeighbours::default();
    let (network, logistic) = (EchoStateNetwork::default(), Logistic::default());
    let estimators: [(&str, Box<dyn Estimator>); 11] = [
        ("window", Box::new(NearestNeighbours { window: 0, ..neighbours })),
        ("neighbours", Box::new(NearestNeighbours { neighbours: 0, ..neighbours })),
        ("explained", Box::new(NearestNeighbours { explained: f64::NAN, ..neighbours })),
        ("units", Box::new(EchoStateNetwork { units: 0, ..network })),
        ("leak", Box::new(EchoStateNetwork { leak: 0.0, ..network })),
        ("penalty", Box::new(EchoStateNetwork { penalty: -1.0, ..network })),
        ("penalty", Box::new(Logistic { penalty: 0.0, ..logistic })),
        ("thresholds", Box::new(MiniRocket { thresholds: 0, ..MiniRocket::default() })),
        ("penalty", Box::new(MiniRocket { penalty: 0.0, ..MiniRocket::default() })),
        ("states", Box::new(Recipe { states: 0, ..Recipe::authors() })),
        ("max_samples", Box::new(Recipe { max_samples: Some(0), ..Recipe::authors() })),
    ];
    for (name, estimator) in estimators {
        match estimator.fit(&known).unwrap_err() {
            ModelError::BadOption(fault) => assert_eq!(fault.field, name),
            other => panic!("{name}: {other}"),
        }
    }
}

/// Tests peak-force against two Gaussians on the logarithm of the largest force, fitted by hand: the category that is nearer in
/// standard deviations has the higher score, and what follows the peak changes nothing.
#[test]
fn peak_force_sees_the_peak_alone() {
    let of = |number: u64, category: &str, peak_n: f64| {
        let mut trial = press(number, category, 0.0, 2, 1);
        trial.samples[0].force_n = peak_n;
        trial
    };
    let peaks = |center: f64| (0..20).map(move |n| center * 1.1f64.powf(f64::from(n) - 9.5));
    let trials: Vec<Trial> = (0..)
        .zip(peaks(0.2))
        .map(|(n, peak_n)| of(n, "leaf", peak_n))
        .chain((20..).zip(peaks(3.0)).map(|(n, peak_n)| of(n, "trunk", peak_n)))
        .collect();
    let kind = crate::registry::find("peak-force").unwrap();
    let classifier = (kind.estimator)(None).fit(&trials.iter().collect::<Vec<_>>()).unwrap();
    // Both have the same spread on a logarithmic scale, so the border is at the geometric mean, 0.77 N.
    for (peak_n, is_leaf) in [(0.05, true), (0.6, true), (1.0, false), (30.0, false)] {
        let mut trial = of(99, "leaf", peak_n);
        let scores = classifier.scores_of_all(&[&trial]).unwrap().remove(0);
        assert_eq!(scores[0] > scores[1], is_leaf, "{peak_n} N: {scores:?}");
        trial.samples.push(Sample { time_s: 0.5, force_n: 0.5 * peak_n, ..trial.samples[0].clone() });
        assert_eq!(classifier.scores_of_all(&[&trial]).unwrap().remove(0), scores);
    }
    assert!((kind.estimator)(Some(FeatureSet::new([&MOTION]))).fit(&trials.iter().collect::<Vec<_>>()).is_err());
}
