//! Hidden Markov models over force with ten states, as in the paper's online experiment, and with twenty: scoring
//! trials, training, and verdicts on a hundred taxels in one frame. Frames arrive at 100 Hz, so an update may take
//! 10 ms.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use glam::{DQuat, DVec3};
use underbrush_classifier::HmmClassifier;
use underbrush_classifier::decision::Decision;
use underbrush_classifier::feature::{FeatureSet, Observations};
use underbrush_classifier::hmm::{InitialDistribution, ScoreKind, Topology, TrainingOptions, equal_slice_start, train};
use underbrush_classifier::online::{OnlineClassifier, OnlineOptions};
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::{Frame, Patch, Pose, Sample, SkinLayout, Taxel, TaxelReading, Trial};

/// Samples of a trial: one second of contact.
const SAMPLES: u32 = 100;
/// Numbers of states measured.
const STATES: [usize; 2] = [10, 20];
/// Iterations of one measured training.
const ITERATIONS: usize = 10;

/// A press of one second that increases, holds and decreases; no two are the same.
fn press(category: &str, force_n: f64, number: u64) -> Trial {
    let samples = (0..SAMPLES)
        .map(|index| {
            let phase = f64::from(index) / f64::from(SAMPLES);
            let ripple = 1.0 + 0.2 * (number as f64 * 1.7 + 9.0 * phase).sin();
            Sample {
                time_s: f64::from(index) * 0.01,
                force_n: force_n * (3.0 * phase).min(1.0) * (4.0 * (1.0 - phase)).min(1.0) * ripple,
                ..Sample::default()
            }
        })
        .collect();
    Trial { trial: number, category: Some(category.into()), reach: None, patch: None, taxel: None, samples }
}

fn trials() -> Vec<Trial> {
    let leaf = (0..50).map(|number| press("leaf", 0.5, number));
    leaf.chain((50..100).map(|number| press("trunk", 3.0, number))).collect()
}

/// Models with this number of states, trained on the presses by the authors' recipe.
fn models(states: usize) -> HmmClassifier {
    let recipe = Recipe { states, ..Recipe::authors() };
    HmmClassifier::train(&trials(), &recipe).expect("the trials can be trained on")
}

/// The presses of a category as the models see them.
fn sequences(category: &str) -> Vec<Observations> {
    let own = trials().into_iter().filter(|trial| trial.category.as_deref() == Some(category));
    let forces = own.map(|trial| FeatureSet::FORCE.observations(&trial, None));
    forces.collect::<Result<_, _>>().expect("the trials have forces")
}

/// Both scores, both numbers of states, and trials of the model's own category (leaf) or the other one, whose trials fit no
/// path through the states.
fn score_cases() -> Vec<(ScoreKind, usize, &'static str)> {
    let kinds = [ScoreKind::Forward, ScoreKind::Viterbi].into_iter();
    kinds
        .flat_map(|kind| STATES.iter().flat_map(move |states| ["leaf", "trunk"].map(|own| (kind, *states, own))))
        .collect()
}

#[divan::bench(args = score_cases())]
fn score_all(bencher: Bencher, (kind, states, category): (ScoreKind, usize, &str)) {
    let (models, sequences) = (models(states), sequences(category));
    let all: Vec<&Observations> = sequences.iter().collect();
    let bencher = bencher.counter(ItemsCount::new(u64::from(SAMPLES) * all.len() as u64));
    bencher.bench_local(|| models.models()["leaf"].log_probabilities(kind, black_box(&all)));
}

#[divan::bench(args = score_cases())]
fn score_one(bencher: Bencher, (kind, states, category): (ScoreKind, usize, &str)) {
    let (models, sequences) = (models(states), sequences(category));
    let bencher = bencher.counter(ItemsCount::new(SAMPLES));
    bencher.bench_local(|| models.models()["leaf"].log_probability(kind, black_box(&sequences[0])));
}

#[divan::bench(args = STATES, sample_count = 20)]
fn baum_welch(bencher: Bencher, states: usize) {
    let sequences = [sequences("leaf"), sequences("trunk")].concat();
    let options = TrainingOptions { iterations: ITERATIONS, tolerance: 0.0, ..TrainingOptions::default() };
    // The likelihood of the final model takes one pass more than there are iterations.
    let passes = ITERATIONS as u64 + 1;
    let start = equal_slice_start(&sequences, states, Topology::LeftToRight, InitialDistribution::Uniform, 1e-4)
        .expect("the trials have spread");
    let bencher = bencher.counter(ItemsCount::new(passes * u64::from(SAMPLES) * sequences.len() as u64));
    bencher.bench_local(|| train(&start, black_box(&sequences), &options).expect("training runs through"));
}

/// A patch of a hundred taxels, and a frame in which all of them are in contact.
fn hundred_taxels() -> (SkinLayout, Frame) {
    let taxels = (0..100)
        .map(|number| Taxel {
            position_link: DVec3::new(f64::from(number % 10) * 0.01, f64::from(number / 10) * 0.01, 0.0),
            normal_link: DVec3::Z,
            tangent_link: DVec3::X,
            area_m2: 1e-4,
        })
        .collect();
    let patch = Patch { name: "forearm".into(), link: "forearm".into(), grid: None, taxels };
    let pose = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let readings = (0..100).map(|taxel| TaxelReading {
        patch: 0,
        taxel,
        true_normal_force_n: 0.5,
        true_shear_force_n: [0.0, 0.0],
        sensed_force_n: 0.3 + 0.02 * f64::from(taxel),
        object: None,
    });
    let frame = Frame {
        end_effector_pose_world: pose,
        patch_pose_world: vec![pose],
        taxels: readings.collect(),
        ..Frame::blank(1)
    };
    (SkinLayout { patches: vec![patch] }, frame)
}

#[divan::bench(args = [(ScoreKind::Forward, 10), (ScoreKind::Viterbi, 10), (ScoreKind::Forward, 20), (ScoreKind::Viterbi, 20)])]
fn online_update(bencher: Bencher, (score, states): (ScoreKind, usize)) {
    let (layout, frame) = hundred_taxels();
    let mut models = models(states);
    models.score = Some(score);
    let options = OnlineOptions { patch: None, threshold_n: 0.0, decision: Decision::argmax() };
    let mut classifier = OnlineClassifier::new(&models, &layout, &options).expect("models fit the skin");
    let bencher = bencher.counter(ItemsCount::new(frame.taxels.len() as u64));
    bencher.bench_local(|| classifier.update(black_box(&frame)).expect("the frame fits the skin").count());
}

fn main() {
    divan::main();
}
