//! Force and motion of typical trials (paper, Fig. 5).

use serde::Serialize;
use underbrush_recording::math::median;
use underbrush_recording::{Fault, Trial};

use crate::{Session, training};

/// Examples and medians of each label.
#[derive(Serialize)]
pub struct ExampleTrials {
    /// One trial of each label.
    pub figure_5: Vec<Example>,
    /// Medians of the trials that the examples are taken from.
    pub figure_5_medians: Vec<Typical>,
}

/// Chooses the examples from the taxel trials, and computes the medians.
pub fn run(session: &Session) -> Result<ExampleTrials, Fault> {
    let data = session.once(training::run)?;
    let labels = session.experiment.labels();
    Ok(ExampleTrials {
        figure_5: examples(&labels, &data.trials.taxel),
        figure_5_medians: medians(&labels, &data.trials.taxel),
    })
}

/// An example.
#[derive(Serialize)]
pub struct Example {
    /// The label.
    pub category: String,
    /// Number of the trial.
    pub trial: u64,
    /// The taxel.
    pub taxel: Option<u32>,
    /// Number of samples.
    pub samples: usize,
    /// The largest sensed force, N.
    pub peak_force_n: f64,
    /// Length of the taxel's path during contact, m.
    pub motion_m: f64,
    /// The trial.
    #[serde(skip)]
    pub data: Trial,
}

/// Medians over the taxel trials of a label in which something touched the taxel.
#[derive(Serialize)]
pub struct Typical {
    /// The label.
    pub category: String,
    /// Number of trials.
    pub trials: usize,
    /// Force 0.1 s after contact, N, which shows how fast the force rises. Shorter trials do not count; NaN if there are
    /// no others.
    pub force_after_100_ms_n: f64,
    /// The largest sensed force of a trial, N.
    pub peak_force_n: f64,
    /// Length of the taxel's path during contact, m.
    pub motion_m: f64,
}

fn peak_force_n(trial: &Trial) -> f64 {
    trial.samples.iter().map(|sample| sample.force_n).fold(0.0, f64::max)
}

fn motion_m(trial: &Trial) -> f64 {
    trial.samples.iter().filter_map(|sample| sample.motion_m).fold(0.0, f64::max)
}

/// The trials of a category in which something touched the taxel.
fn touched_trials<'a>(label: &str, taxel_trials: &'a [Trial]) -> Vec<&'a Trial> {
    let own = |trial: &&Trial| trial.touched() == Some(true) && trial.category.as_deref() == Some(label);
    taxel_trials.iter().filter(own).collect()
}

/// One trial of each label: among those of a touched taxel that last a second or more (or all, if none lasts that
/// long), the one with the median peak force. It is a typical trial, and long enough to look at.
fn examples(labels: &[&str], taxel_trials: &[Trial]) -> Vec<Example> {
    let example = |label: &&str| {
        let mut trials = touched_trials(label, taxel_trials);
        if trials.iter().any(|trial| trial.samples.len() >= 100) {
            trials.retain(|trial| trial.samples.len() >= 100);
        }
        trials.sort_by(|a, b| peak_force_n(a).total_cmp(&peak_force_n(b)));
        let trial = trials.get(trials.len() / 2)?;
        Some(Example {
            category: (*label).to_owned(),
            trial: trial.trial,
            taxel: trial.taxel,
            samples: trial.samples.len(),
            peak_force_n: peak_force_n(trial),
            motion_m: motion_m(trial),
            data: (*trial).clone(),
        })
    };
    labels.iter().filter_map(example).collect()
}

/// Medians over all touched trials of each category.
fn medians(labels: &[&str], taxel_trials: &[Trial]) -> Vec<Typical> {
    let typical = |label: &&str| {
        let trials = touched_trials(label, taxel_trials);
        let over =
            |value: fn(&Trial) -> f64| median(trials.iter().map(|trial| value(trial)).collect()).unwrap_or(f64::NAN);
        // At 100 Hz; the first sample is the start of the contact.
        let early = trials.iter().filter_map(|trial| trial.samples.get(10));
        (!trials.is_empty()).then(|| Typical {
            category: (*label).to_owned(),
            trials: trials.len(),
            force_after_100_ms_n: median(early.map(|sample| sample.force_n).collect()).unwrap_or(f64::NAN),
            peak_force_n: over(peak_force_n),
            motion_m: over(motion_m),
        })
    };
    labels.iter().filter_map(typical).collect()
}

#[cfg(test)]
mod tests {
    use underbrush_recording::{Sample, Trial};

    use super::medians;

    /// Tests that trials that end before 0.1 s do not count in the force after 0.1 s, and do in the other medians.
    #[test]
    fn short_trials_have_no_force_after_100_ms() {
        let trial = |samples: usize| Trial {
            trial: 0,
            category: Some("leaf".into()),
            reach: None,
            patch: None,
            taxel: None,
            samples: (0..samples)
                .map(|index| Sample {
                    time_s: 0.01 * index as f64,
                    force_n: index as f64,
                    touched: Some(true),
                    ..Sample::default()
                })
                .collect(),
        };
        let found = medians(&["leaf"], &[trial(5), trial(3), trial(20)]);
        assert_eq!((found[0].trials, found[0].force_after_100_ms_n), (3, 10.0));
        assert_eq!(found[0].peak_force_n, 4.0);
        assert!(medians(&["leaf"], &[trial(5)])[0].force_after_100_ms_n.is_nan());
    }
}
