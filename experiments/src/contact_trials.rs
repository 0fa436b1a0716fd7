//! Contact trials of recordings and data sets, by taxel or by component.

use rayon::prelude::*;
use underbrush_classifier::TrialError;
use underbrush_classifier::trial::{Labels, TrialOptions, Unit, component_trials, environment, taxel_trials};
use underbrush_recording::{Category, Dataset, Fault, Recording, Trial};

use crate::progress::Progress;

/// The trials of one recording, numbered from 0.
///
/// # Errors
/// As [`taxel_trials`] and [`component_trials`].
pub fn of_recording(recording: &Recording, options: &TrialOptions) -> Result<Vec<Trial>, TrialError> {
    warn_of_mixed(usize::from(is_mixed(recording, options)), 1);
    cut(recording, options)
}

/// Whether labels by environment were asked for, and this clutter has several categories.
fn is_mixed(recording: &Recording, options: &TrialOptions) -> bool {
    let is_object = recording.objects.iter().any(|object| object.category != Category::BLOCK);
    options.labels == Labels::Environment && is_object && environment(recording).is_none()
}

fn warn_of_mixed(mixed: usize, all: usize) {
    if mixed > 0 {
        log::warn!(
            "{mixed} of {all} reaches have objects of several categories, so their trials are labelled by the object that pressed, \
             not by environment"
        );
    }
}

/// As [`of_recording`], without a warning.
pub(crate) fn cut(recording: &Recording, options: &TrialOptions) -> Result<Vec<Trial>, TrialError> {
    let found = match options.by {
        Unit::Taxel => taxel_trials(recording, options)?,
        Unit::Component => component_trials(recording, options)?,
    };
    Ok(found.into_iter().map(|contact| contact.trial).collect())
}

/// The trials of all reaches of a data set. The reach of a trial is the index of its episode, because reaches of
/// different scenes may share an index.
///
/// # Errors
/// If the set cannot be read or a reach cannot be cut; that of [`Progress::check_stopped`] if the user ends the run.
pub fn of_dataset(dataset: &Dataset, options: &TrialOptions, progress: &dyn Progress) -> Result<Vec<Trial>, Fault> {
    of_reaches(dataset.episodes().len(), options, progress, |episode| Ok(dataset.read_reach(episode)?))
}

/// The trials of as many reaches as `read` is to return. The reach of a trial is its place among these.
///
/// # Errors
/// As [`of_dataset`].
pub fn of_reaches(
    count: usize,
    options: &TrialOptions,
    progress: &dyn Progress,
    read: impl Fn(usize) -> Result<Recording, Fault> + Sync,
) -> Result<Vec<Trial>, Fault> {
    let parts = each_reach(count, progress, |reach| {
        let recording = read(reach)?;
        let trials = cut(&recording, options)?.into_iter();
        let trials: Vec<Trial> = trials.map(|trial| Trial { reach: Some(reach as u64), ..trial }).collect();
        Ok((is_mixed(&recording, options), trials))
    })?;
    warn_of_mixed(parts.iter().filter(|(is_mixed, _)| *is_mixed).count(), parts.len());
    let trials = parts.into_iter().flat_map(|(_, own)| own).zip(0..);
    Ok(trials.map(|(trial, number)| Trial { trial: number, ..trial }).collect())
}

/// Reads the reaches of a data set, several at a time, and returns what `each` makes of them, in their order.
///
/// # Errors
/// If the set cannot be read, and the errors of `each`; that of [`Progress::check_stopped`] if the user ends the run.
pub fn each_episode<T: Send>(
    dataset: &Dataset,
    progress: &dyn Progress,
    each: impl Fn(usize, &Recording) -> Result<T, Fault> + Sync,
) -> Result<Vec<T>, Fault> {
    each_reach(dataset.episodes().len(), progress, |episode| each(episode, &dataset.read_reach(episode)?))
}

/// Calls `read` for as many reaches, several at a time, and returns what it makes of them, in their order.
fn each_reach<T: Send>(
    reaches: usize,
    progress: &dyn Progress,
    read: impl Fn(usize) -> Result<T, Fault> + Sync,
) -> Result<Vec<T>, Fault> {
    let count = progress.count("reaches read", reaches as u64, 0);
    let read = |reach| {
        progress.check_stopped()?;
        let made = read(reach)?;
        count.advance();
        Ok(made)
    };
    (0..reaches).into_par_iter().with_max_len(1).map(read).collect()
}
