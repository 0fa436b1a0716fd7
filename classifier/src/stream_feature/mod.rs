//! Stream features: running statistics of a contact, updated with each sample, so that a classifier can give scores
//! while the contact lasts.
//!
//! An update costs the same for every sample and never looks ahead. Forces, motions and rates span decades, from grazes
//! to full contacts, so they are compressed logarithmically. Channels are not, as their units are unknown.

use underbrush_recording::{Sample, Trial};

use crate::feature::{
    AREA, FORCE, Feature, FeatureError, FeatureSet, MOTION, REGION_FORCE_SUM, REGION_MAX_FORCE, SampleFault,
};

mod state;

pub use state::StreamFeatures;
pub(crate) use state::{Moments, features};

/// The stream features of each channel, in the channel's own unit.
pub const CHANNEL_FEATURES: [&str; 6] = ["last", "first", "largest", "smallest", "mean", "deviation"];

/// The features of a sample that stream features of taxel and contact region are computed from.
pub const TAXEL_AND_REGION: FeatureSet =
    FeatureSet::new([&FORCE, &MOTION, &AREA, &REGION_MAX_FORCE, &REGION_FORCE_SUM]);

/// Numbers of samples after which classifiers are fitted and evaluated before a contact ends, spaced by about a factor
/// of 2.
pub const SAMPLE_COUNTS: [usize; 9] = [1, 2, 3, 6, 12, 25, 50, 100, 200];

/// The stream features that can be computed from some features of each sample.
///
/// ```
/// use underbrush_classifier::feature::FeatureSet;
/// use underbrush_classifier::stream_feature::Selection;
///
/// let selection = Selection::of(FeatureSet::FORCE);
/// assert_eq!(selection.dimension(), 9);
/// // A channel adds the six of [`underbrush_classifier::stream_feature::CHANNEL_FEATURES`].
/// assert_eq!(Selection::of("force,column:shear_n".parse()?).dimension(), 15);
/// # Ok::<(), underbrush_classifier::feature::FeatureError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selection {
    inputs: FeatureSet,
    /// The name of the only one that is selected.
    only: Option<&'static str>,
}

impl Selection {
    /// The stream features that need no features of a sample other than these.
    pub fn of(inputs: FeatureSet) -> Self {
        Selection { inputs, only: None }
    }

    /// The one with this name alone, if it can be computed.
    pub fn only(self, name: &'static str) -> Self {
        Selection { only: Some(name), ..self }
    }

    /// Indices in [`StreamFeatures::NAMES`].
    fn chosen(&self) -> impl Iterator<Item = usize> {
        let is_chosen = |index: &usize| {
            self.only.is_none_or(|name| StreamFeatures::NAMES[*index] == name)
                && StreamFeatures::NEEDED[*index].iter().all(|needed| self.inputs.contains(needed))
        };
        (0..StreamFeatures::COUNT).filter(is_chosen)
    }

    fn channels(&self) -> impl Iterator<Item = &'static Feature> {
        self.inputs.channels().filter(|_| self.only.is_none())
    }

    /// Number of stream features.
    pub fn dimension(&self) -> usize {
        self.chosen().count() + self.channels().count() * CHANNEL_FEATURES.len()
    }

    /// Adds the next sample of a contact.
    ///
    /// # Errors
    /// [`SampleFault`] if the sample lacks a feature or has a number that is not finite; `state` then stays as it was.
    pub fn push(&self, state: &mut StreamFeatures, sample: &Sample) -> Result<(), SampleFault> {
        let mut values = [0.0; StreamFeatures::COUNT];
        self.inputs.read(sample, &mut values)?;
        SampleFault::finite("time_s", sample.time_s)?;
        // All channels were read above.
        let channels: Vec<f64> = self.channels().map(|channel| channel.read(sample).unwrap_or_default()).collect();
        state.push(sample, channels.into_iter());
        Ok(())
    }

    /// The values of the stream features after the samples so far.
    pub fn values(&self, state: &StreamFeatures) -> Vec<f64> {
        let all = state.values();
        let mut values: Vec<f64> = self.chosen().map(|index| all[index]).collect();
        let length = values.len() + self.channels().count() * CHANNEL_FEATURES.len();
        values.extend(state.channels().flatten());
        // Before the first sample.
        values.resize(length, 0.0);
        values
    }

    /// The values for a trial after each of these numbers of samples, which must be ascending and at least 1. A number
    /// greater than the trial's length means the whole trial.
    ///
    /// # Errors
    /// [`FeatureError`] if the trial is empty, lacks a feature, or holds NaN or infinity.
    pub fn after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, FeatureError> {
        let push = |state: &mut StreamFeatures, sample: &Sample| self.push(state, sample);
        after(trial, counts, StreamFeatures::default(), push, |state| Ok(self.values(state)))
    }
}

/// The values for a trial after each of some numbers of samples, as of [`Selection::after`]: those of a state that
/// takes in the samples with `push`.
///
/// # Errors
/// [`FeatureError`] if the trial is empty, or `push` refuses a sample, and the errors of `values`.
pub(crate) fn after<S, E: From<FeatureError>>(
    trial: &Trial,
    counts: &[usize],
    mut state: S,
    push: impl Fn(&mut S, &Sample) -> Result<(), SampleFault>,
    values: impl Fn(&mut S) -> Result<Vec<f64>, E>,
) -> Result<Vec<Vec<f64>>, E> {
    if trial.samples.is_empty() {
        return Err(FeatureError::Empty(trial.trial).into());
    }
    let mut found = Vec::with_capacity(counts.len());
    let mut taken = 0;
    for &count in counts {
        for sample in &trial.samples[taken..count.clamp(taken, trial.samples.len())] {
            push(&mut state, sample).map_err(|fault| fault.at(trial, taken))?;
            taken += 1;
        }
        found.push(values(&mut state)?);
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
