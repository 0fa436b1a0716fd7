//! Force and motion of ordinary trials (paper, Fig. 5).

use serde::Serialize;
use underbrush_recording::{Category, Trial};

/// A trial that Fig. 5 shows.
#[derive(Serialize)]
pub struct Example {
    pub category: &'static str,
    pub trial: u64,
    pub taxel: Option<u32>,
    pub samples: usize,
    pub peak_force_n: f64,
    pub farthest_motion_m: f64,
    #[serde(skip)]
    pub data: Trial,
}

/// Medians over the taxel trials of a category in which something touched the taxel.
#[derive(Serialize)]
pub struct Typical {
    pub category: &'static str,
    pub trials: usize,
    /// 0.1 s after contact: how fast the force rises.
    pub force_after_100_ms_n: f64,
    pub peak_force_n: f64,
    /// Length of the taxel's path during contact.
    pub motion_m: f64,
}

const CATEGORIES: [Category; 2] = [Category::LEAF, Category::TRUNK];

fn peak_force_n(trial: &Trial) -> f64 {
    trial.samples.iter().map(|sample| sample.force_n).fold(0.0, f64::max)
}

fn motion_m(trial: &Trial) -> f64 {
    let motions = trial.samples.iter().filter_map(|sample| sample.motion_m);
    motions.fold(0.0, f64::max)
}

/// The trials of a category in which something touched the taxel.
fn touched_trials(category: Category, taxel_trials: &[Trial]) -> Vec<&Trial> {
    let own = |trial: &&Trial| trial.touched() == Some(true) && trial.category.as_deref() == Some(category.name());
    taxel_trials.iter().filter(own).collect()
}

/// The trials that Fig. 5 shows: of each category, among those of a touched taxel that last a second or more (or all, if
/// none lasts so long) the one whose peak force is the median. An ordinary trial, and long enough to be looked at.
pub fn examples(taxel_trials: &[Trial]) -> Vec<Example> {
    let example = |category: Category| {
        let mut trials = touched_trials(category, taxel_trials);
        if trials.iter().any(|trial| trial.samples.len() >= 100) {
            trials.retain(|trial| trial.samples.len() >= 100);
        }
        trials.sort_by(|a, b| peak_force_n(a).total_cmp(&peak_force_n(b)));
        let trial = trials.get(trials.len() / 2)?;
        Some(Example {
            category: category.name(),
            trial: trial.trial,
            taxel: trial.taxel,
            samples: trial.samples.len(),
            peak_force_n: peak_force_n(trial),
            farthest_motion_m: motion_m(trial),
            data: (*trial).clone(),
        })
    };
    CATEGORIES.into_iter().filter_map(example).collect()
}

/// Medians over all touched trials of each category.
pub fn medians(taxel_trials: &[Trial]) -> Vec<Typical> {
    let typical = |category: Category| {
        let trials = touched_trials(category, taxel_trials);
        let over = |value: fn(&Trial) -> f64| median(trials.iter().map(|trial| value(trial)).collect());
        // Trials have 20 samples at least, at 100 Hz; the first is contact itself.
        let early = |trial: &Trial| trial.samples.get(10).map_or(f64::NAN, |sample| sample.force_n);
        (!trials.is_empty()).then(|| Typical {
            category: category.name(),
            trials: trials.len(),
            force_after_100_ms_n: over(early),
            peak_force_n: over(peak_force_n),
            motion_m: over(motion_m),
        })
    };
    CATEGORIES.into_iter().filter_map(typical).collect()
}

/// The mean of the two in the middle, where the count is even.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() % 2 {
        _ if values.is_empty() => f64::NAN,
        0 => f64::midpoint(values[middle - 1], values[middle]),
        _ => values[middle],
    }
}
