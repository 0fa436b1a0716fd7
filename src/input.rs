//! Reading the input of a command: data sets, recordings or a table of trials. Whole reaches are read one after the other, so that
//! memory stays bounded.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use underbrush_classifier::evaluate::EvaluateError;
use underbrush_classifier::evaluate::touch_folds::ReadReaches;
use underbrush_classifier::trial::Unit;
use underbrush_classifier::{DataKind, DataSource, ModelError};
use underbrush_experiments::{contact_trials, model_data};
use underbrush_recording::disk::{
    Dataset, DiskError, is_folder, is_recording, is_there, read_recording, read_trials, recording_header,
    with_recordings,
};
use underbrush_recording::{Fault, InputError, Recording, Trial};
use underbrush_sim::controller::ControllerKind;

use crate::options::TrialArguments;
use crate::{Failure, Shown, output, progress};

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

/// Trials, and the data that they were read from.
pub struct TrialInput {
    pub trials: Vec<Trial>,
    pub data: Vec<DataSource>,
    /// What trials of a data set or a recording are cut by.
    by: Unit,
}

impl TrialInput {
    /// Whether the trials were read from a table.
    pub fn is_table(&self) -> bool {
        self.data.iter().any(|own| own.kind == DataKind::Trials)
    }

    /// What a trial is made of. A table does not say it, but its samples may tell.
    pub fn unit(&self) -> Option<Unit> {
        if self.is_table() { Unit::of(&self.trials) } else { Some(self.by) }
    }
}

/// As [`trials`]; an error if there are none.
pub fn some_trials(path: &Path, arguments: &TrialArguments) -> Result<TrialInput, Failure> {
    some_of(trials(path, arguments)?, path, arguments)
}

/// As [`some_trials`], and all trials of any length beside them. The path is read once.
pub fn some_of_all_trials(
    path: &Path,
    arguments: &TrialArguments,
) -> Result<(TrialInput, Option<Vec<Trial>>), Failure> {
    let mut read = trials(path, &arguments.of_any_length())?;
    let all = Some(read.trials.clone());
    read.trials.retain(|trial| trial.samples.len() >= arguments.min_samples());
    if !read.is_table() {
        read.trials.iter_mut().zip(0..).for_each(|(trial, number)| trial.trial = number);
    }
    Ok((some_of(read, path, arguments)?, all))
}

fn some_of(read: TrialInput, path: &Path, arguments: &TrialArguments) -> Result<TrialInput, Failure> {
    match why_none(&read, arguments) {
        Some((found, remedy)) => Err(Failure::usage(format!("{}: {found}; {remedy}", path.display()))),
        None => Ok(read),
    }
}

/// As [`trials`]. Remarks why there are none, if there are none.
pub fn any_trials(path: &Path, arguments: &TrialArguments) -> Result<TrialInput, Failure> {
    let read = trials(path, arguments)?;
    if let Some((found, _)) = why_none(&read, arguments) {
        output::remark(format!("{}: no trials: {found}", path.display()));
    }
    Ok(read)
}

/// If there are no trials: what was not found, and what to do.
fn why_none(read: &TrialInput, arguments: &TrialArguments) -> Option<(String, &'static str)> {
    if !read.trials.is_empty() {
        return None;
    }
    let samples = output::counted(arguments.min_samples(), "sample", "samples");
    if read.is_table() {
        let remedy = "lower --min-samples, or give a table with longer trials";
        return Some((format!("no trial in this table has {samples} or more"), remedy));
    }
    let patch = arguments.patch.as_ref().map_or("the first patch".into(), |name| format!("patch {name}"));
    let found = format!("no contact on {patch} above {} N with {samples} or more", arguments.threshold_n());
    Some((found, "lower --threshold-n or --min-samples, name another --patch, or generate more reaches"))
}

/// An error about the trials at this path, unless an option is at fault.
pub fn about_trials(path: &Path, error: impl Into<EvaluateError>) -> Failure {
    let error = error.into();
    match error {
        EvaluateError::FoldCount { .. }
        | EvaluateError::Decision(_)
        | EvaluateError::Model(ModelError::BadOption { .. }) => error.into(),
        _ => Failure::from(error).about(path),
    }
}

/// Returns an error if there is no file or folder at `path`. Without this check, its name would be taken for the wrong
/// kind of file. `allowed` is what the command accepts.
pub fn check_exists(path: &Path, allowed: &str) -> Result<(), Failure> {
    if is_there(path)? {
        return Ok(());
    }
    Err(InputError::new(path, "input", "no such file or folder", allowed, "check the path").into())
}

/// Reads the trials of a data set, of a recording or a folder of them, or of a table.
pub fn trials(path: &Path, arguments: &TrialArguments) -> Result<TrialInput, Failure> {
    check_exists(path, WITH_TRIALS)?;
    let about = |fault: Fault| Failure::from(fault).about(path);
    let (trials, data) = if is_folder(path)? {
        let reaches = Reaches::open(&[path.to_owned()])?;
        let places: Vec<Place> = reaches.places().collect();
        let read = |place: usize| -> Result<_, Fault> { Ok(read_one(places[place])?) };
        let trials = contact_trials::of_reaches(places.len(), &arguments.options()?, &Shown, read).map_err(about)?;
        (trials, reaches.data())
    } else if is_recording(path)? {
        let recording = read_recording(path)?;
        let cut = contact_trials::of_recording(&recording, &arguments.options()?);
        (cut.map_err(|error| about(error.into()))?, vec![model_data::of_file(path, &recording)?])
    } else {
        let table = format!("a table of trials such as {}, which are extracted and labelled already", path.display());
        arguments.refuse_but(&["--preset", "--min-samples"], &table)?;
        let mut trials = read_trials(path)?;
        let data = vec![model_data::of_table(path, &trials)?];
        trials.retain(|trial| trial.samples.len() >= arguments.min_samples());
        (trials, data)
    };
    Ok(TrialInput { trials, data, by: arguments.options()?.by })
}

/// Reads the name of a controller.
pub fn controller() -> impl TypedValueParser<Value = ControllerKind> {
    PossibleValuesParser::new(ControllerKind::names()).try_map(|name| ControllerKind::from_name(&name))
}

/// The reaches of some data sets and recordings, in the order in which they are given.
pub struct Reaches {
    sources: Vec<Source>,
}

/// A data set or a recording.
struct Source {
    path: PathBuf,
    /// A recording has none.
    dataset: Option<Dataset>,
    data: DataSource,
}

impl Source {
    /// Number of its reaches.
    fn count(&self) -> usize {
        self.dataset.as_ref().map_or(1, |dataset| dataset.episodes().len())
    }
}

/// What commands that need trials accept.
const WITH_TRIALS: &str = "a data set (folder), recording, folder of recordings or table of trials";

/// What commands that need whole frames accept.
const WITH_FRAMES: &str = "data sets or folders of recordings, or recordings (.parquet), which hold whole frames";

impl Reaches {
    /// Finds the reaches of these files and folders.
    ///
    /// # Errors
    /// If a path is neither a data set nor a recording, or if the same reaches are given twice, also as a copy. A reach could
    /// then be in training and test at once.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Failure> {
        let paths = with_recordings(paths)?;
        let source = |path: &PathBuf| {
            check_exists(path, WITH_FRAMES)?;
            let (dataset, data) = if is_folder(path)? {
                let dataset = Dataset::open(path)?;
                let data = model_data::of_reaches(&dataset, dataset.episodes().iter());
                (Some(dataset), data)
            } else if is_recording(path)? {
                (None, model_data::of_file(path, &recording_header(path)?)?)
            } else {
                let remedy = "give the data set or recording that the trials were taken from";
                let found = "a table of trials or another file";
                return Err(InputError::new(path, "input", found, WITH_FRAMES, remedy).into());
            };
            Ok(Source { path: path.clone(), dataset, data })
        };
        let sources = paths.iter().map(source).collect::<Result<Vec<_>, Failure>>()?;
        // Two names and two copies of one file are one file.
        model_data::require_once("input", sources.iter().map(|own| (&own.data.blake3, &own.path)))?;
        Ok(Reaches { sources })
    }

    /// Takes away those after the first `count` files and folders.
    pub fn split_off(&mut self, count: usize) -> Self {
        Reaches { sources: self.sources.split_off(count) }
    }

    /// Number of reaches in the first `count` files and folders.
    pub fn count_in(&self, count: usize) -> usize {
        self.sources.iter().take(count).map(Source::count).sum()
    }

    /// What the data sets and recordings are.
    pub fn data(&self) -> Vec<DataSource> {
        self.sources.iter().map(|own| own.data.clone()).collect()
    }

    /// Reads one reach after the other.
    pub fn recordings(&self) -> impl Iterator<Item = Result<Recording, Failure>> {
        self.places().map(|place| read_one(place).map_err(Failure::from))
    }

    fn places(&self) -> impl Iterator<Item = Place<'_>> {
        self.sources.iter().flat_map(|source| (0..source.count()).map(move |index| (source, index)))
    }
}

/// A reach as what it is in, and its index there.
type Place<'a> = (&'a Source, usize);

fn read_one((source, index): Place) -> Result<Recording, DiskError> {
    source.dataset.as_ref().map_or_else(|| read_recording(&source.path), |dataset| dataset.read_reach(index))
}

impl ReadReaches for Reaches {
    type Error = Failure;

    fn count(&self) -> usize {
        self.places().count()
    }

    /// Reads the reaches with a progress bar. It fails if a file is damaged; errors of `each` name the file.
    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let kept: Vec<_> = self.places().enumerate().filter(|(position, _)| keeps(*position)).collect();
        let bar = progress::bar(kept.len() as u64, "reaches read");
        for (_, place) in kept {
            each(&read_one(place)?).map_err(|failure| failure.about(&place.0.path))?;
            bar.inc(1);
        }
        Ok(())
    }
}
