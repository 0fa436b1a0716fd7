//! What a command is given to read: a data set, a recording or a table of trials.

use std::path::Path;

use clap::{Args, ValueEnum};
use underbrush_classifier::trial::{Labels, TrialOptions, component_trials, taxel_trials};
use underbrush_recording::disk::{Dataset, is_recording, read_recording, read_trials};
use underbrush_recording::{Category, InputError, Recording, Trial};

use crate::failure::Failure;
use crate::progress;

/// What a trial is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// One taxel from contact to break (paper, section IV-D)
    Taxel,
    /// One connected component of taxels (paper, section IV-C)
    Component,
}

/// What gives a trial its category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LabelName {
    /// The object that pressed on the skin
    Contact,
    /// The one category of the clutter, as the paper's models are trained: also where nothing pressed
    Environment,
}

/// How trials are cut from a data set or a recording; a table of trials is taken as it is.
#[derive(Args, Clone, Debug)]
pub struct TrialArguments {
    /// What a trial is made of
    #[arg(long, value_enum, default_value = "taxel", value_name = "UNIT")]
    pub by: Unit,
    /// Patch of skin; the only or the first one if not given
    #[arg(long, value_name = "NAME")]
    pub patch: Option<String>,
    /// A taxel is in contact where it reports more than this, N
    #[arg(long, default_value_t = TrialOptions::default().threshold_n, value_name = "N", allow_negative_numbers = true)]
    pub threshold_n: f64,
    /// Leave out trials of fewer samples
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub min_samples: usize,
    /// What gives a trial its category
    #[arg(long, value_enum, default_value = "contact", value_name = "BY")]
    pub labels: LabelName,
    /// Do not join components across the seam of a closed patch, as in the authors' code
    #[arg(long)]
    pub no_wrap: bool,
}

impl TrialArguments {
    /// The options for cutting trials.
    pub fn options(&self) -> TrialOptions {
        TrialOptions {
            patch: self.patch.clone(),
            threshold_n: self.threshold_n,
            min_samples: self.min_samples,
            labels: match self.labels {
                LabelName::Contact => Labels::Contact,
                LabelName::Environment => Labels::Environment,
            },
            wrap: self.no_wrap.then_some(false),
            ..TrialOptions::default()
        }
    }

    /// The trials of one recording, numbered from `first`.
    pub fn cut(&self, recording: &Recording, first: u64) -> Result<Vec<Trial>, Failure> {
        cut(recording, self.by, &self.options(), first)
    }
}

/// The trials of one recording, numbered from `first`.
pub fn cut(recording: &Recording, by: Unit, options: &TrialOptions, first: u64) -> Result<Vec<Trial>, Failure> {
    let trials = match by {
        Unit::Taxel => taxel_trials(recording, options)?,
        Unit::Component => component_trials(recording, options)?,
    };
    Ok(trials
        .into_iter()
        .map(|found| Trial {
            trial: first + found.trial.trial,
            ..found.trial
        })
        .collect())
}

/// Reads the trials of a data set, a recording or a table, for a command that is nothing without any.
pub fn some_trials(path: &Path, arguments: &TrialArguments) -> Result<Vec<Trial>, Failure> {
    let trials = trials(path, arguments)?;
    if trials.is_empty() {
        let patch = arguments.patch.as_deref();
        let patch = patch.map_or("the first patch".into(), |name| format!("patch {name}"));
        return Err(Failure::usage(format!(
            "{}: no contact on {patch} above {} N of {} samples or more; lower --threshold-n or --min-samples, or \
             generate more reaches",
            path.display(),
            arguments.threshold_n,
            arguments.min_samples
        )));
    }
    Ok(trials)
}

/// Refuses a path at which there is nothing, before its name is taken for the wrong kind of file; `allowed` is what a
/// command takes.
pub fn check_exists(path: &Path, allowed: &str) -> Result<(), Failure> {
    if path.exists() {
        return Ok(());
    }
    Err(InputError::new(path, "input", "no such file or folder", allowed, "check the path").into())
}

/// Reads the trials of a data set, a recording or a table.
pub fn trials(path: &Path, arguments: &TrialArguments) -> Result<Vec<Trial>, Failure> {
    check_exists(path, "a data set (folder), recording or table of trials")?;
    let cut = |recording: &Recording, first| {
        let found = arguments.cut(recording, first);
        found.map_err(|failure| failure.about(path))
    };
    if path.is_dir() {
        let dataset = Dataset::open(path)?;
        let reaches = dataset.episodes().len();
        let bar = progress::bar(reaches as u64, "reaches read");
        let mut trials = Vec::new();
        for episode in 0..reaches {
            let mut found = cut(&dataset.read_reach(episode)?, trials.len() as u64)?;
            // Reaches of different scenes may share an index; the episode's number is theirs alone.
            found.iter_mut().for_each(|trial| trial.reach = Some(episode as u64));
            trials.extend(found);
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(trials)
    } else if is_recording(path) {
        cut(&read_recording(path)?, 0)
    } else {
        Ok(read_trials(path)?)
    }
}

/// Categories of a recording's objects, by index.
pub fn object_categories(recording: &Recording) -> Vec<Category> {
    recording.objects.iter().map(|object| object.category).collect()
}
