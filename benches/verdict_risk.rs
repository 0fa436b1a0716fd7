//! Whether touch models keep within the risk limits that they are fitted with, in reaches that they have not seen.
//!
//!     cargo run --release --example verdict_risk -- 20 40 DATA…
//!
//! Of all reaches of the data sets, 40 are drawn, a model is fitted to them within a limit, and the other reaches are
//! judged. This is repeated 20 times for each limit. Prints one row for each limit: the mean shares of the taxel frames
//! of a new reach that are called another category and that are called unknown, with the standard deviation over the
//! draws; and the shares of all taxel frames of known categories that are right and uncertain.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]
#![allow(clippy::print_stdout, reason = "the table is what it is run for")]

use std::collections::BTreeSet;
use std::sync::Arc;

use rand::{SeedableRng, seq::SliceRandom};
use rayon::prelude::*;
use underbrush_classifier::evaluate::TouchFigures;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::touch::{TouchExamples, TouchOptions};
use underbrush_recording::Recording;
use underbrush_recording::disk::Dataset;

/// The allowed shares that are tried.
const LIMITS: [f64; 3] = [0.03, 0.05, 0.1];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [draws, training, sets @ ..] = arguments.as_slice() else {
        println!("usage: verdict_risk DRAWS TRAINING-REACHES DATA…");
        return;
    };
    let (draws, training): (u64, usize) = (draws.parse().unwrap(), training.parse().unwrap());
    let mut examples = TouchExamples::new(TouchOptions::default());
    let mut reaches = Vec::new();
    for set in sets {
        let set = Dataset::open(set).unwrap();
        for index in 0..set.episodes().len() {
            let recording = set.read_reach(index).unwrap();
            examples.add(&recording).unwrap();
            reaches.push(recording);
        }
    }
    println!("{} reaches, of which {training} are drawn to fit to", reaches.len());
    println!("{:>5}  {:>14}  {:>14}  {:>7}  {:>9}", "limit", "wrong", "false alarms", "right", "uncertain");
    for limit in LIMITS {
        let draw = |seed: u64| judged(&examples, &reaches, training, limit, seed);
        let found: Vec<[f64; 4]> = (0..draws).into_par_iter().map(draw).collect();
        let [wrong, alarms, right, uncertain] = std::array::from_fn(|index| mean_and_deviation(&found, index));
        println!(
            "{limit:>5.2}  {:>6.4} ± {:.4}  {:>6.4} ± {:.4}  {:>7.3}  {:>9.3}",
            wrong.0, wrong.1, alarms.0, alarms.1, right.0, uncertain.0
        );
    }
}

/// Mean shares of the taxel frames of a new reach that are wrong and that are false alarms, and shares of all taxel
/// frames that are right and that are uncertain.
fn judged(examples: &TouchExamples, reaches: &[Recording], training: usize, limit: f64, seed: u64) -> [f64; 4] {
    let mut order: Vec<usize> = (0..reaches.len()).collect();
    order.shuffle(&mut rand_chacha::ChaCha8Rng::seed_from_u64(seed));
    let fitted: BTreeSet<usize> = order.drain(..training).collect();
    let model = examples.some(|index| fitted.contains(&index)).fit(Some(limit)).unwrap();
    let model = Arc::new(model);
    let mut evaluation = TouchEvaluation::default();
    for index in order {
        evaluation.add(TouchEvaluation::of(&model, &reaches[index]).unwrap());
    }
    let known = evaluation.known();
    let share = |part: usize| part as f64 / known.total() as f64;
    let by_reach = TouchFigures::of(&evaluation, model.categories()).by_reach;
    [by_reach.wrong_category.unwrap(), by_reach.called_unknown.unwrap(), share(known.right), share(known.uncertain)]
}

fn mean_and_deviation(found: &[[f64; 4]], index: usize) -> (f64, f64) {
    let count = found.len() as f64;
    let mean = found.iter().map(|own| own[index]).sum::<f64>() / count;
    let squares: f64 = found.iter().map(|own| (own[index] - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0)).sqrt())
}
