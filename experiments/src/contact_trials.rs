//! Contact trials of recordings and data sets, by taxel or by component.

use underbrush_classifier::trial::{
    Labels, TrialError, TrialOptions, Unit, component_trials, environment, taxel_trials,
};
use underbrush_recording::{Category, Dataset, Fault, Recording, Trial};
use underbrush_sim::reach::ReachError;

use crate::progress::Progress;

/// The trials of one recording, numbered from `first`.
///
/// # Errors
/// As [`taxel_trials`] and [`component_trials`].
pub fn of_recording(recording: &Recording, options: &TrialOptions, first: u64) -> Result<Vec<Trial>, TrialError> {
    warn_of_mixed(usize::from(is_mixed(recording, options)), 1);
    cut(recording, options, first)
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

fn cut(recording: &Recording, options: &TrialOptions, first: u64) -> Result<Vec<Trial>, TrialError> {
    let found = match options.by {
        Unit::Taxel => taxel_trials(recording, options)?,
        Unit::Component => component_trials(recording, options)?,
    };
    let trials = found.into_iter().map(|contact| contact.trial).zip(first..);
    Ok(trials.map(|(trial, number)| Trial { trial: number, ..trial }).collect())
}

/// The trials of all reaches of a data set. The reach of a trial is the index of its episode, because reaches of
/// different scenes may share an index.
///
/// # Errors
/// If the set cannot be read or a reach cannot be cut; [`ReachError::Stopped`] if the user ends the run.
pub fn of_dataset(dataset: &Dataset, options: &TrialOptions, progress: &dyn Progress) -> Result<Vec<Trial>, Fault> {
    let (mut trials, mut mixed) = (Vec::new(), 0);
    each_episode(dataset, progress, |episode, recording| {
        mixed += usize::from(is_mixed(recording, options));
        let mut found = cut(recording, options, trials.len() as u64)?;
        found.iter_mut().for_each(|trial| trial.reach = Some(episode as u64));
        trials.extend(found);
        Ok(())
    })?;
    warn_of_mixed(mixed, dataset.episodes().len());
    Ok(trials)
}

/// Reads the reaches of a data set one after the other, and returns what `each` makes of them.
///
/// # Errors
/// If the set cannot be read, and the errors of `each`; [`ReachError::Stopped`] if the user ends the run.
pub fn each_episode<T>(
    dataset: &Dataset,
    progress: &dyn Progress,
    mut each: impl FnMut(usize, &Recording) -> Result<T, TrialError>,
) -> Result<Vec<T>, Fault> {
    let episodes = 0..dataset.episodes().len();
    let count = progress.count("reaches read", episodes.len() as u64, 0);
    let read = |episode| {
        if progress.is_stopped() {
            return Err(ReachError::Stopped.into());
        }
        let made = each(episode, &dataset.read_reach(episode)?)?;
        count.advance();
        Ok(made)
    };
    episodes.map(read).collect()
}
