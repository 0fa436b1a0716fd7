//! Hidden Markov models over force with ten states, as in the paper's online experiment, and with twenty: scoring
//! trials, training, and verdicts on a hundred taxels in one frame. Frames arrive at 100 Hz, so an update may take
//! 10 ms.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
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
                motion_m: None,
                region: None,
                touched: None,
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
    HmmClassifier::train(&trials(), &recipe).expect("the trials can be trained on").0
}

/// The presses of a category as the models see them.
fn sequences(category: &str) -> Vec<Observations> {
    let own = trials().into_iter().filter(|trial| trial.category.as_deref() == Some(category));
    let forces = own.map(|trial| FeatureSet::FORCE.observations(&trial, None));
    forces.collect::<Result<_, _>>().expect("the trials have forces")
}

fn score(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("hmm/score");
    for states in STATES {
        let models = models(states);
        let model = &models.models()["leaf"];
        // The model's own category, and the other one, whose trials fit no path through the states.
        for (name, category) in [("own", "leaf"), ("foreign", "trunk")] {
            let sequences = sequences(category);
            let all: Vec<&Observations> = sequences.iter().collect();
            for (kind, kind_name) in [(ScoreKind::Forward, "forward"), (ScoreKind::Viterbi, "viterbi")] {
                group.throughput(Throughput::Elements(u64::from(SAMPLES) * all.len() as u64));
                group.bench_function(format!("{kind_name}/{states} states/{name}"), |bencher| {
                    bencher.iter(|| model.log_probabilities(kind, black_box(&all)));
                });
                group.throughput(Throughput::Elements(u64::from(SAMPLES)));
                group.bench_function(format!("{kind_name}/{states} states/{name}, one trial"), |bencher| {
                    bencher.iter(|| model.log_probability(kind, black_box(all[0])));
                });
            }
        }
    }
}

fn training(criterion: &mut Criterion) {
    let sequences = [sequences("leaf"), sequences("trunk")].concat();
    let options = TrainingOptions { iterations: ITERATIONS, tolerance: 0.0, ..TrainingOptions::default() };
    let mut group = criterion.benchmark_group("hmm/baum_welch");
    // The likelihood of the final model takes one pass more than there are iterations.
    let passes = ITERATIONS as u64 + 1;
    group.sample_size(20).throughput(Throughput::Elements(passes * u64::from(SAMPLES) * sequences.len() as u64));
    for states in STATES {
        let start = equal_slice_start(&sequences, states, Topology::LeftToRight, InitialDistribution::Uniform, 1e-4)
            .expect("the trials have spread");
        group.bench_function(format!("{states} states"), |bencher| {
            bencher.iter(|| train(&start, black_box(&sequences), &options).expect("training runs through"));
        });
    }
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

fn online(criterion: &mut Criterion) {
    let (layout, frame) = hundred_taxels();
    let mut group = criterion.benchmark_group("hmm/online_update");
    group.throughput(Throughput::Elements(frame.taxels.len() as u64));
    for states in STATES {
        let mut models = models(states);
        for (score, name) in [(ScoreKind::Forward, "forward"), (ScoreKind::Viterbi, "viterbi")] {
            let options = OnlineOptions { patch: None, threshold_n: 0.0, decision: Decision::argmax() };
            models.score_by(score);
            let mut classifier = OnlineClassifier::new(&models, &layout, &options).expect("models fit the skin");
            group.bench_function(format!("{name}/{states} states, 100 taxels, 2 models"), |bencher| {
                bencher.iter(|| classifier.update(black_box(&frame)).expect("the frame fits the skin").count());
            });
        }
    }
}

criterion_group!(benches, score, training, online);
criterion_main!(benches);
