//! Trials that are still in contact, and the list of trials that have ended.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_recording::{Category, Recording, Sample, Trial};

use super::{Labels, TrialError, TrialOptions};
use crate::frequency::most_frequent;

/// A trial and the object that caused it.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactTrial {
    /// The trial. Trials are numbered from 0 within a recording, by first frame and then by taxel. The category follows
    /// [`TrialOptions::labels`].
    pub trial: Trial,
    /// Index in [`Recording::objects`] of the object that was the true contact in most samples. In a tie, it is the
    /// smallest such index. `None` if no sample has an object.
    pub object: Option<u16>,
}

/// The single category of a recording's objects other than foam blocks; `None` if there are several or none.
pub fn environment(recording: &Recording) -> Option<Category> {
    let categories = recording.objects.iter().map(|object| object.category);
    let mut categories = categories.filter(|category| *category != Category::BLOCK);
    let first = categories.next()?;
    categories.all(|category| category == first).then_some(first)
}

/// Whether a recording contains ground truth. A recording of a real robot lists neither objects nor bodies and does not; where
/// bodies are known, there may truly be no objects.
pub(super) fn knows_truth(recording: &Recording) -> bool {
    !recording.objects.is_empty() || !recording.bodies.is_empty()
}

/// A trial that is still in contact.
#[derive(Clone, Debug)]
pub(super) struct OpenTrial {
    first_frame: usize,
    taxel: usize,
    pub(super) travel: Travel,
    samples: Vec<Sample>,
    /// Samples by object.
    votes: BTreeMap<u16, usize>,
}

impl OpenTrial {
    pub(super) fn new(first_frame: usize, taxel: usize, start_world: DVec3) -> Self {
        OpenTrial { first_frame, taxel, travel: Travel::from(start_world), samples: Vec::new(), votes: BTreeMap::new() }
    }

    /// Adds a sample and its true object.
    pub(super) fn push(&mut self, sample: Sample, object: Option<u16>) {
        self.samples.push(sample);
        if let Some(object) = object {
            *self.votes.entry(object).or_default() += 1;
        }
    }
}

/// The trials that have ended.
pub(super) struct TrialList<'a> {
    recording: &'a Recording,
    options: &'a TrialOptions,
    patch: String,
    /// The category of all trials, if they are labelled by environment.
    environment: Option<Category>,
    /// Each with its sort key: first frame, taxel.
    closed: Vec<((usize, usize), ContactTrial)>,
}

impl<'a> TrialList<'a> {
    pub(super) fn new(recording: &'a Recording, options: &'a TrialOptions, patch: &str) -> Self {
        TrialList {
            recording,
            options,
            patch: patch.to_owned(),
            environment: (options.labels == Labels::Environment).then(|| environment(recording)).flatten(),
            closed: Vec::new(),
        }
    }

    pub(super) fn close(&mut self, trial: Option<OpenTrial>) -> Result<(), TrialError> {
        let Some(trial) = trial.filter(|trial| trial.samples.len() >= self.options.min_samples.max(1)) else {
            return Ok(());
        };
        let object = most_frequent(&trial.votes);
        let objects = &self.recording.objects;
        let record = |index: u16| {
            objects.get(usize::from(index)).ok_or_else(|| TrialError::BadFrame {
                frame: trial.first_frame,
                found: format!("object {index} as ground truth of a contact that starts here"),
                allowed: format!("indices of the recording's {} objects", objects.len()),
            })
        };
        let category = self.environment.or(object.map(record).transpose()?.map(|record| record.category));
        let key = (trial.first_frame, trial.taxel);
        let trial = Trial {
            trial: 0,
            category: category.map(|category| category.name().to_owned()),
            reach: Some(self.recording.reach_index),
            patch: Some(self.patch.clone()),
            taxel: u32::try_from(trial.taxel).ok(),
            samples: trial.samples,
        };
        self.closed.push((key, ContactTrial { trial, object }));
        Ok(())
    }

    /// All trials in their order, after closing those that are still open.
    pub(super) fn finish(
        mut self,
        open: impl IntoIterator<Item = Option<OpenTrial>>,
    ) -> Result<Vec<ContactTrial>, TrialError> {
        open.into_iter().try_for_each(|trial| self.close(trial))?;
        self.closed.sort_by_key(|(key, _)| *key);
        let mut trials: Vec<ContactTrial> = self.closed.into_iter().map(|(_, trial)| trial).collect();
        trials.iter_mut().zip(0..).for_each(|(contact, number)| contact.trial.trial = number);
        Ok(trials)
    }
}

/// The length of a contact's path in the world frame since the contact started.
///
/// The paper (section IV-C) describes motion as how far "the 3D position of the contact area" travels and gives no
/// formula: either the path length or the distance from the start may be meant. Choice: the path length, which is
/// closer to "travel". The two gave tables within a few percentage points of each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travel {
    pub(super) last_world: DVec3,
    length_m: f64,
}

impl Travel {
    /// A contact that starts at this position, m, world frame.
    pub(crate) fn from(start_world: DVec3) -> Self {
        Travel { last_world: start_world, length_m: 0.0 }
    }

    /// Moves the contact to its current position, m, world frame, and returns the length of its path so far, m.
    pub(crate) fn to(&mut self, position_world: DVec3) -> f64 {
        self.length_m += position_world.distance(self.last_world);
        self.last_world = position_world;
        self.length_m
    }
}
