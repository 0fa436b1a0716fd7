use std::collections::BTreeMap;

use underbrush_recording::{Recording, Trial};

use super::*;
use crate::decision::Rule;
use crate::feature::FeatureSet;
use crate::hmm::TrainingOptions;
use crate::recipe::{Recipe, ScalingKind};
use crate::trial::taxel_trials;
use crate::trial::tests::{any_force, recording};

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
    let frames: Vec<_> = readings
        .iter()
        .enumerate()
        .map(|(k, r)| (0.002 * k as f64, r.as_slice()))
        .collect();
    recording(&frames)
}

fn models(recording: &Recording, recipe: &Recipe) -> ModelSet {
    let trials: Vec<Trial> = taxel_trials(recording, &any_force())
        .unwrap()
        .into_iter()
        .map(|contact| contact.trial)
        .collect();
    ModelSet::train(&trials, recipe).unwrap().0
}

fn options(score: ScoreKind) -> OnlineOptions {
    let decision = Decision::new(Rule::UncertainBelow { margin: 1.0 });
    OnlineOptions {
        patch: None,
        threshold_n: 0.0,
        score,
        decision,
    }
}

#[test]
fn running_scores_are_those_of_the_trial_so_far() {
    // Pins bit-equality of online and batch scores at every sample of every contact, scaled, truncated or plain,
    // and with features of the contact region.
    let recording = reach();
    let recipe = Recipe {
        states: 3,
        features: FeatureSet::FORCE_AND_MOTION,
        ..Recipe::authors()
    };
    let scaled = Recipe {
        scaling: ScalingKind::ZScore,
        max_samples: Some(6),
        ..recipe.clone()
    };
    let with_region = Recipe {
        features: "force,area,region-force-sum".parse().unwrap(),
        training: TrainingOptions {
            variance_floor: 0.01,
            ..TrainingOptions::default()
        },
        ..recipe.clone()
    };
    for recipe in [recipe, scaled, with_region] {
        let models = models(&recording, &recipe);
        for kind in [ScoreKind::Forward, ScoreKind::Viterbi] {
            let mut open: BTreeMap<usize, Trial> = BTreeMap::new();
            let trials = taxel_trials(&recording, &any_force()).unwrap();
            let mut classifier = OnlineClassifier::new(models.clone(), &recording.layout, &options(kind)).unwrap();
            let mut compared = 0;
            for frame in &recording.frames {
                let verdicts: Vec<TaxelVerdict> = classifier.update(frame).unwrap().cloned().collect();
                open.clear();
                for contact in &trials {
                    let so_far = contact
                        .trial
                        .samples
                        .iter()
                        .filter(|sample| sample.time_s <= frame.time_s)
                        .count();
                    if contact.trial.samples.iter().any(|sample| sample.time_s == frame.time_s) {
                        let mut trial = contact.trial.clone();
                        trial.samples.truncate(so_far);
                        open.insert(trial.taxel.unwrap() as usize, trial);
                    }
                }
                assert!(verdicts.iter().map(|verdict| verdict.taxel).eq(open.keys().copied()));
                for (verdict, trial) in verdicts.iter().zip(open.values()) {
                    let batch: Vec<f64> = models
                        .score(trial, kind)
                        .unwrap()
                        .into_iter()
                        .map(|(_, score)| score)
                        .collect();
                    assert_eq!(verdict.log_likelihood, batch);
                    assert_eq!(verdict.samples, trial.samples.len());
                    let judge = options(kind).decision.prepare(&models.categories()).unwrap();
                    assert_eq!(verdict.verdict, judge.verdict(judge.choose(&batch)));
                    compared += 1;
                }
            }
            assert!(compared > 100, "{compared} comparisons");
        }
    }
}

#[test]
fn a_frame_allocates_nothing() {
    // Pins that contacts beginning, going on and ending cost no allocation, from the first frame on. A change of verdict
    // copies the category's name, so here all verdicts stay uncertain.
    let recording = reach();
    let models = models(
        &recording,
        &Recipe {
            states: 3,
            features: FeatureSet::FORCE_AND_MOTION,
            ..Recipe::authors()
        },
    );
    for kind in [ScoreKind::Forward, ScoreKind::Viterbi] {
        let options = OnlineOptions {
            decision: Decision::new(Rule::UncertainBelow { margin: 1e9 }),
            ..options(kind)
        };
        let mut classifier = OnlineClassifier::new(models.clone(), &recording.layout, &options).unwrap();
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
    // Pins the errors for an unknown patch and for a frame with NaN.
    let mut recording = reach();
    let models = models(
        &recording,
        &Recipe {
            states: 2,
            ..Recipe::authors()
        },
    );
    let elbow = OnlineOptions {
        patch: Some("elbow".into()),
        ..options(ScoreKind::Forward)
    };
    assert!(OnlineClassifier::new(models.clone(), &recording.layout, &elbow).is_err());
    let mut classifier = OnlineClassifier::new(models, &recording.layout, &options(ScoreKind::Forward)).unwrap();
    recording.frames[5].taxels[0].sensed_force_n = f64::NAN;
    assert!(classifier.update(&recording.frames[4]).is_ok());
    assert!(matches!(
        classifier.update(&recording.frames[5]).err(),
        Some(OnlineError::Trial(TrialError::BadFrame { frame: 1, .. }))
    ));
}
