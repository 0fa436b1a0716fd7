//! When the trials of a reach begin and end, and whether frames can show them as they are.

use std::path::Path;

use underbrush_recording::math::sorted;
use underbrush_recording::{InputError, Trial, short};

/// The name of a patch that has none.
const UNNAMED: &str = "skin";

/// The patch of a trial.
pub fn patch_name(trial: &Trial) -> &str {
    trial.patch.as_deref().unwrap_or(UNNAMED)
}

/// The first and the last time of each trial, s, each sorted.
pub struct Spans {
    firsts_s: Vec<f64>,
    lasts_s: Vec<f64>,
}

impl Spans {
    /// The spans of the trials of a reach.
    pub fn of(trials: &[&Trial]) -> Self {
        let samples = || trials.iter().map(|trial| &trial.samples);
        Spans {
            firsts_s: sorted(samples().filter_map(|samples| Some(samples.first()?.time_s)).collect()),
            lasts_s: sorted(samples().filter_map(|samples| Some(samples.last()?.time_s)).collect()),
        }
    }

    /// Time from the first sample to the last, s.
    pub fn duration_s(&self) -> f64 {
        let ends = self.firsts_s.first().zip(self.lasts_s.last());
        ends.map_or(0.0, |(first_s, last_s)| last_s - first_s)
    }

    /// Whether a trial has samples both up to this time and after it.
    pub fn go_on_after(&self, time_s: f64) -> bool {
        let until = |times: &[f64]| times.partition_point(|other_s| *other_s <= time_s);
        until(&self.firsts_s) > until(&self.lasts_s)
    }
}

/// A trial, its patch and taxel, and the places of its first and last time among the times of its reach.
struct Placed<'a> {
    trial: &'a Trial,
    taxel: (&'a str, Option<u32>),
    first: usize,
    last: usize,
}

/// An error if frames would change the trials of a reach. In a frame each taxel has one reading or none, and its trial
/// lasts as long as it has one in each frame.
pub fn check(path: &Path, reach: u64, trials: &[&Trial], spans: &Spans) -> Result<(), InputError> {
    let samples = trials.iter().flat_map(|trial| &trial.samples);
    let mut times_s = sorted(samples.map(|sample| sample.time_s).collect());
    times_s.dedup();
    let place = |time_s: f64| times_s.partition_point(|other_s| *other_s < time_s);
    let placed = trials.iter().filter_map(|&trial| {
        let [first, last] = [trial.samples.first()?, trial.samples.last()?].map(|sample| place(sample.time_s));
        Some(Placed { trial, taxel: (patch_name(trial), trial.taxel), first, last })
    });
    let mut placed: Vec<Placed> = placed.collect();
    placed.sort_by_key(|placed| (placed.taxel, placed.first));
    for [before, after] in placed.array_windows().filter(|[before, after]| before.taxel == after.taxel) {
        let (number, other) = (after.trial.trial, before.trial.trial);
        if after.first <= before.last {
            let found = format!("trial {number} in reach {reach} before trial {other} of the same taxel has ended");
            let allowed = "one trial of a taxel at a time";
            let remedy =
                "number the reaches in the column reach; trials of contact regions that overlap cannot be replayed";
            return Err(InputError::new(path, "reach", found, allowed, remedy));
        }
        // If no other trial went on, there would be a frame without forces between the two.
        if after.first == before.last + 1 && spans.go_on_after(times_s[before.last]) {
            let found = format!("trial {number} in reach {reach} right after trial {other} of the same taxel");
            let allowed = "a time without a sample of the taxel between its trials, while another trial goes on";
            let remedy = "join the two trials, or leave one of them out";
            return Err(InputError::new(path, "time_s", found, allowed, remedy));
        }
    }
    for Placed { trial, first, last, .. } in placed {
        let own_s = trial.samples.iter().map(|sample| sample.time_s);
        let mut pairs = times_s[first..=last].iter().zip(own_s);
        if let Some((time_s, _)) = pairs.find(|(time_s, own_s)| *time_s != own_s) {
            let (time, number) = (short(*time_s), trial.trial);
            let found = format!("{time} s in reach {reach}, at which trial {number} has no sample although it goes on");
            let allowed = "all taxels sampled at the same times";
            let remedy = "bring the samples to common times, or number the reaches in the column reach";
            return Err(InputError::new(path, "time_s", found, allowed, remedy));
        }
    }
    Ok(())
}
