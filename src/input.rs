//! Reading the input of a command: a data set, a recording or a table of trials.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use underbrush_experiments::contact_trials;
use underbrush_recording::disk::{Dataset, is_folder, is_recording, is_there, read_recording, read_trials};
use underbrush_recording::{InputError, Trial};
use underbrush_sim::controller::ControllerKind;

pub use crate::trial_arguments::TrialArguments;
use crate::{Failure, Shown, output};

/// The only path in `paths`.
///
/// # Errors
/// If there are several, which only the classifier `touch` takes.
pub fn only(paths: &[PathBuf]) -> Result<&Path, Failure> {
    match paths {
        [path] => Ok(path),
        _ => {
            let allowed = "one, because only the classifier touch takes several";
            let remedy = "give one data set, recording or table of trials";
            Err(Failure::usage(format!("{} inputs; allowed: {allowed}; {remedy}", paths.len())))
        }
    }
}

/// Reads the trials of a data set, a recording or a table; an error if there are none. Remarks that the preset does not
/// change the labels of a table.
pub fn some_trials(path: &Path, arguments: &TrialArguments) -> Result<Vec<Trial>, Failure> {
    let trials = trials(path, arguments)?;
    let is_table = !is_folder(path)? && !is_recording(path)?;
    let path = path.display();
    if is_table && arguments.is_paper() {
        let kept = "the trials of a table keep their labels, which --preset paper does not change";
        output::remark(format!("{path}: {kept}"));
    }
    if trials.is_empty() {
        let (threshold_n, samples) = (arguments.threshold_n(), arguments.min_samples());
        if is_table {
            let remedy = "lower --min-samples, or give a table with longer trials";
            let text = format!("{path}: no trial in this table has {samples} samples or more; {remedy}");
            return Err(Failure::usage(text));
        }
        let patch = arguments.patch();
        let patch = patch.map_or("the first patch".into(), |name| format!("patch {name}"));
        let found = format!("no contact on {patch} above {threshold_n} N with {samples} samples or more");
        let remedy = "lower --threshold-n or --min-samples, or generate more reaches";
        return Err(Failure::usage(format!("{path}: {found}; {remedy}")));
    }
    Ok(trials)
}

/// Returns an error if there is no file or folder at `path`. Without this check, its name would be taken for the wrong
/// kind of file. `allowed` is what the command accepts.
pub fn check_exists(path: &Path, allowed: &str) -> Result<(), Failure> {
    if is_there(path)? {
        return Ok(());
    }
    Err(InputError::new(path, "input", "no such file or folder", allowed, "check the path").into())
}

/// Reads the trials of a data set, a recording or a table.
pub fn trials(path: &Path, arguments: &TrialArguments) -> Result<Vec<Trial>, Failure> {
    check_exists(path, "a data set (folder), recording or table of trials")?;
    let cut = if is_folder(path)? {
        contact_trials::of_dataset(&Dataset::open(path)?, &arguments.options()?, &Shown).map_err(Failure::from)
    } else if is_recording(path)? {
        contact_trials::of_recording(&read_recording(path)?, &arguments.options()?, 0).map_err(Failure::from)
    } else {
        arguments.refuse_for_table(path)?;
        let mut trials = read_trials(path)?;
        trials.retain(|trial| trial.samples.len() >= arguments.min_samples());
        return Ok(trials);
    };
    cut.map_err(|failure| failure.about(path))
}

/// Reads the name of a controller.
pub fn controller() -> impl TypedValueParser<Value = ControllerKind> {
    PossibleValuesParser::new(ControllerKind::names()).try_map(|name| ControllerKind::from_name(&name))
}
