//! This project's side of the comparison of HMM libraries. `hmm.py` runs it and describes what is measured.
//!
//!     hmm_peer TRIALS.csv MODELS.json REPEATS
//!
//! Prints one JSON object: for each model, nanoseconds (the fastest of all repeats, one thread) and log-likelihoods.
#![allow(clippy::print_stdout, reason = "prints its result")]

use std::error::Error;
use std::hint::black_box;
use std::sync::LazyLock;
use std::time::Instant;

use serde_json::json;
use underbrush_classifier::feature::Observations;
use underbrush_classifier::hmm::{ScoreKind, TrainingOptions, train};
use underbrush_classifier::{Classifier, any_model};
use underbrush_recording::{Sample, Trial};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [trials, models, repeats] = arguments.as_slice() else {
        return Err("give TRIALS.csv, MODELS.json and the number of repeats".into());
    };
    let trials = read(&std::fs::read_to_string(trials)?)?;
    let model = any_model::load_of_trials(models.as_ref())?;
    let models = model.hmm()?;
    let repeats: usize = repeats.parse()?;
    let observations = |trial: &Trial| models.features().observations(trial, None);
    let all: Vec<Observations> = trials.iter().map(observations).collect::<Result<_, _>>()?;
    let every: Vec<&Observations> = all.iter().collect();
    let samples: usize = all.iter().map(Observations::sample_count).sum();
    let mut result = serde_json::Map::new();
    for (category, scorer) in models.models() {
        let mut entry = serde_json::Map::new();
        for (kind, name) in [(ScoreKind::Forward, "forward"), (ScoreKind::Viterbi, "viterbi")] {
            let one_by_one =
                || -> Result<Vec<f64>, _> { all.iter().map(|one| scorer.log_probability(kind, one)).collect() };
            let together = || scorer.log_probabilities(kind, &every);
            if one_by_one()? != together()? {
                return Err("scores one by one and together differ".into());
            }
            entry.insert(name.into(), json!(together()?));
            for (way, seconds) in [
                ("", quickest(repeats, || black_box(together()).map(drop))?),
                ("_single", quickest(repeats, || black_box(one_by_one()).map(drop))?),
            ] {
                entry.insert(format!("{name}{way}_ns_per_sample"), json!(1e9 * seconds / samples as f64));
            }
        }
        let own = trials.iter().filter(|trial| trial.category.as_ref() == Some(category));
        let own: Vec<Observations> = own.map(observations).collect::<Result<_, _>>()?;
        let own_samples: usize = own.iter().map(Observations::sample_count).sum();
        // The difference between trainings of two lengths is the time of the iterations alone.
        let iterate = |iterations| {
            let options = TrainingOptions { iterations, tolerance: 0.0, ..TrainingOptions::default() };
            quickest(repeats, || black_box(train(&scorer.model, &own, &options)).map(drop))
        };
        let seconds = (iterate(11)? - iterate(1)?) / 10.0;
        entry.insert("iteration_ns_per_sample".into(), json!(1e9 * seconds / own_samples as f64));
        result.insert(category.clone(), entry.into());
    }
    println!("{}", serde_json::Value::from(result));
    Ok(())
}

/// Processor time of the fastest run, s.
fn quickest<E>(repeats: usize, mut work: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let mut best = f64::INFINITY;
    for _ in 0..repeats {
        // The system counts a thread's time in milliseconds, so the work is repeated for 0.2 s.
        let (wall, start, mut runs) = (Instant::now(), thread_time_s(), 0.0);
        while wall.elapsed().as_secs_f64() < 0.2 {
            work()?;
            runs += 1.0;
        }
        best = best.min((thread_time_s() - start) / runs);
    }
    Ok(best)
}

/// Processor time of this thread, s, which other programs do not lengthen as they do wall time; wall time if the system
/// does not report it.
fn thread_time_s() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let scheduled = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = scheduled.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |nanoseconds| 1e-9 * nanoseconds)
}

/// Trials from a table with the columns `trial, category, time_s, force_n`, rows of a trial together.
fn read(text: &str) -> Result<Vec<Trial>, Box<dyn Error>> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let place = header.iter().position(|found| *found == name);
        place.ok_or_else(|| format!("the table has no column {name}"))
    };
    let (trial, category, time_s, force_n) =
        (column("trial")?, column("category")?, column("time_s")?, column("force_n")?);
    let mut trials: Vec<Trial> = Vec::new();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number: u64 = cells[trial].parse()?;
        if trials.last().is_none_or(|last| last.trial != number) {
            trials.push(Trial {
                trial: number,
                category: Some(cells[category].to_owned()),
                reach: None,
                patch: None,
                taxel: None,
                samples: Vec::new(),
            });
        }
        let sample = Sample { time_s: cells[time_s].parse()?, force_n: cells[force_n].parse()?, ..Sample::default() };
        if let Some(open) = trials.last_mut() {
            open.samples.push(sample);
        }
    }
    Ok(trials)
}
