use std::collections::BTreeMap;

use underbrush_recording::{Recording, Trial};

use super::*;
use crate::hmm::{ScoreKind, TrainingOptions};
use crate::hmm_classifier::HmmClassifier;
use crate::model_file::Model;
use crate::recipe::{Recipe, ScalingKind};
use crate::registry::CLASSIFIERS;
use crate::trial::taxel_trials;
use crate::trial::tests::{any_force, recording};
use crate::{Estimator, FeatureSet, Rule};

/// A reach of 60 frames in which three taxels touch a leaf and a trunk with breaks between.
fn reach() -> Recording {
    let wave = |index: usize, taxel: usize| 0.6 + 0.5 * (0.37 * index as f64 + taxel as f64).sin();
    let readings: Vec<Vec<(u16, f64, Option<u16>)>> = (0..60)
        .map(|index| {
            let mut readings = Vec::new();
            for (taxel, scale, object, gap) in [(2, 0.4, 0, 17), (7, 3.0, 1, 23), (11, 0.5, 0, 29)] {
                if index % gap >= 4 {
                    readings.push((taxel, scale * wave(index, usize::from(taxel)), Some(object)));
                }
            }
            readings
        })
        .collect();
    let frames: Vec<_> = readings.iter().enumerate().map(|(k, r)| (0.002 * k as f64, r.as_slice())).collect();
    recording(&frames)
}

fn trials_of(recording: &Recording) -> Vec<Trial> {
    let trials = taxel_trials(recording, &any_force()).unwrap();
    trials.into_iter().map(|contact| contact.trial).collect()
}

fn models(recording: &Recording, recipe: &Recipe) -> HmmClassifier {
    HmmClassifier::train(&trials_of(recording), recipe).unwrap()
}

fn options() -> OnlineOptions {
    let decision = Decision::new(Rule::UncertainBelow { margin: 1.0 });
    OnlineOptions { patch: None, threshold_n: 0.0, decision }
}

/// Asserts that, at every sample of every contact, the online scores equal those of the trial so far, bit for bit.
#[track_caller]
fn online_equals_offline(classifier: &dyn Classifier, recording: &Recording, options: &OnlineOptions) {
    let trials = taxel_trials(recording, &any_force()).unwrap();
    let judge = options.decision.prepare(&classifier.categories()).unwrap();
    let mut online = OnlineClassifier::new(classifier, &recording.layout, options).unwrap();
    let mut compared = 0;
    for frame in &recording.frames {
        let verdicts: Vec<TaxelVerdict> = online.update(frame).unwrap().cloned().collect();
        let mut open: BTreeMap<usize, Trial> = BTreeMap::new();
        for contact in &trials {
            let mut trial = contact.trial.clone();
            if trial.samples.iter().any(|sample| sample.time_s == frame.time_s) {
                trial.samples.retain(|sample| sample.time_s <= frame.time_s);
                open.insert(trial.taxel.unwrap() as usize, trial);
            }
        }
        assert!(verdicts.iter().map(|verdict| verdict.taxel).eq(open.keys().copied()));
        for (verdict, trial) in verdicts.iter().zip(open.values()) {
            let offline = classifier.scores_of_all(&[trial]).unwrap().remove(0);
            assert_eq!(verdict.scores, offline, "{}", classifier.name());
            assert_eq!(verdict.samples, trial.samples.len());
            assert_eq!(verdict.verdict, judge.choose(&offline));
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared} comparisons");
}

/// Tests that online and offline scores of hidden Markov models are the same bits, for scaled, truncated and plain
/// features, both kinds of score, and features of the contact region.
#[test]
fn running_scores_are_those_of_the_trial_so_far() {
    let recording = reach();
    let recipe = Recipe { states: 3, features: FeatureSet::FORCE_AND_MOTION, ..Recipe::authors() };
    let scaled = Recipe { scaling: ScalingKind::ZScore, max_samples: Some(6), ..recipe.clone() };
    let with_region = Recipe {
        features: "force,area,region-force-sum".parse().unwrap(),
        training: TrainingOptions { variance_floor: 0.01, ..TrainingOptions::default() },
        ..recipe.clone()
    };
    for recipe in [recipe, scaled, with_region] {
        let mut models = models(&recording, &recipe);
        for kind in [ScoreKind::Forward, ScoreKind::Viterbi] {
            models.score = Some(kind);
            online_equals_offline(&models, &recording, &options());
        }
    }
}

/// Tests that online and offline scores of every classifier of the list are the same bits, before and after it is saved
/// and loaded.
#[test]
fn every_classifier_runs_online_as_offline() {
    let recording = reach();
    let trials = trials_of(&recording);
    for kind in CLASSIFIERS {
        let estimator: Box<dyn Estimator> = match kind.name {
            // The default has more states than the shortest contact has samples.
            "hmm" => Box::new(Recipe { states: 3, ..Recipe::authors() }),
            _ => (kind.estimator)(None),
        };
        let fitted = estimator.fit(&trials.iter().collect::<Vec<_>>()).unwrap();
        online_equals_offline(fitted.as_ref(), &recording, &options());
        let text = Model::new(fitted).save_string().unwrap();
        let loaded = Model::from_json("model.json", &text).unwrap();
        online_equals_offline(loaded.classifier.as_ref(), &recording, &options());
    }
}

/// Tests that a feature of the contact region is refused, by name, if the taxels form no grid.
#[test]
fn regions_need_a_grid() {
    let mut recording = reach();
    let recipe = Recipe {
        states: 3,
        features: "force,area".parse().unwrap(),
        training: TrainingOptions { variance_floor: 0.01, ..TrainingOptions::default() },
        ..Recipe::authors()
    };
    let models = models(&recording, &recipe);
    recording.layout.patches[0].grid = None;
    let error = OnlineClassifier::new(&models, &recording.layout, &options()).unwrap_err();
    assert!(matches!(error, OnlineError::NoRegion { feature: "area", .. }), "{error}");
}

#[test]
fn a_frame_allocates_nothing() {
    // Tests that nothing is allocated when contacts begin, continue and end and verdicts change, from the first frame on.
    let recording = reach();
    let mut models =
        models(&recording, &Recipe { states: 3, features: FeatureSet::FORCE_AND_MOTION, ..Recipe::authors() });
    for kind in [ScoreKind::Forward, ScoreKind::Viterbi] {
        models.score = Some(kind);
        let options = OnlineOptions { decision: Decision::argmax(), ..options() };
        let mut classifier = OnlineClassifier::new(&models, &recording.layout, &options).unwrap();
        let mut verdicts = 0;
        let allocations = allocation_counter::measure(|| {
            for frame in &recording.frames {
                verdicts += classifier.update(frame).unwrap().count();
            }
        });
        assert!(verdicts > 100);
        assert_eq!(allocations.count_total, 0);
    }
}

#[test]
fn wrong_streams_are_refused() {
    // Tests the errors for an unknown patch and for a frame with NaN.
    let mut recording = reach();
    let models = models(&recording, &Recipe { states: 2, ..Recipe::authors() });
    let elbow = OnlineOptions { patch: Some("elbow".into()), ..options() };
    assert!(OnlineClassifier::new(&models, &recording.layout, &elbow).is_err());
    let mut classifier = OnlineClassifier::new(&models, &recording.layout, &options()).unwrap();
    recording.frames[5].taxels[0].sensed_force_n = f64::NAN;
    assert!(classifier.update(&recording.frames[4]).is_ok());
    assert!(matches!(
        classifier.update(&recording.frames[5]).err(),
        Some(OnlineError::Trial(TrialError::BadFrame { frame: 1, .. }))
    ));
}
