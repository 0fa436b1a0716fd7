//! Looking into files, physics checks, regression suites, the benchmark, and whole studies; and the command `underbrush` of the package.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::benchmark::{EnteredController, Entry, TestSet, set_folder};
use underbrush_experiments::suite::{Checked, Suite};
use underbrush_experiments::{Experiment, VerdictControl, inspection};
use underbrush_recording::disk::check_free;
use underbrush_recording::stop;
use underbrush_report::reproduction::Reproduction;
use underbrush_report::suite_text;
use underbrush_validation::{CHECKS, Check};

use crate::{Answer, Failure, Reported, Stop, argument, controller, generate, json, watched};

/// Check a scene, data set, recording, folder of recordings, model or table of trials, and say what it holds.
#[pyfunction]
#[pyo3(signature = (path, seed = 0))]
pub fn inspect(py: Python<'_>, path: PathBuf, #[pyo3(from_py_with = argument::seed)] seed: u64) -> Answer<'_> {
    json::to_python(py, &watched(py, None, &Arc::default(), None, |_| Ok(inspection::inspect(&path, seed)?))?)
}

/// Run regression suites and hold what they find against their bounds.
#[pyfunction]
pub fn check<'py>(
    py: Python<'py>,
    suites: Vec<PathBuf>,
    #[pyo3(from_py_with = argument::seed)] seed: Option<u64>,
    bless: bool,
    out: Option<PathBuf>,
    force: bool,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Answer<'py> {
    for file in out.iter().flat_map(|folder| suite_text::FILES.map(|name| folder.join(name))) {
        check_free(&file, force)?;
    }
    let run = |reported: &Reported| {
        let checked = Checked::of(Suite::load_all(&suites)?, seed, bless, reported)?;
        if let Some(folder) = &out {
            suite_text::write(folder, &checked)?;
        }
        Ok(checked)
    };
    json::to_python(py, &watched(py, jobs, &Arc::default(), progress, run)?)
}

/// Run an experiment, the paper's if no other is given, and write its report.
#[pyfunction]
pub fn reproduce<'py>(
    py: Python<'py>,
    out: PathBuf,
    experiment: Option<PathBuf>,
    quick: bool,
    #[pyo3(from_py_with = argument::seed)] seed: Option<u64>,
    #[pyo3(from_py_with = argument::campaigns)] campaigns: u64,
    force: bool,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Answer<'py> {
    let experiment = Experiment::load_or_paper(experiment.as_deref())?;
    let reproduction =
        Reproduction { seed: seed.unwrap_or(experiment.file.seed), experiment: &experiment, quick, campaigns, force };
    // The results have parts that cannot leave their thread, so they are converted there.
    let run = |reported: &Reported| json::value(&reproduction.run(&out, reported)?.0);
    json::to_python(py, &watched(py, jobs, &Arc::default(), progress, run)?)
}

/// Run a single campaign of an experiment, not the first one, and cache its result in the folder.
#[pyfunction]
#[pyo3(signature = (out, campaign, *, seed = None, experiment = None, quick = false, jobs = None))]
pub fn run_campaign(
    py: Python<'_>,
    out: PathBuf,
    campaign: u64,
    #[pyo3(from_py_with = argument::seed)] seed: Option<u64>,
    experiment: Option<PathBuf>,
    quick: bool,
    jobs: Option<usize>,
) -> Result<(), Failure> {
    let experiment = Experiment::load_or_paper(experiment.as_deref())?;
    let seed = seed.unwrap_or(experiment.file.seed);
    let reproduction = Reproduction { seed, experiment: &experiment, quick, campaigns: 1, force: false };
    let run = |reported: &Reported| Ok(reproduction.run_campaign(seed.wrapping_add(campaign), &out, reported)?);
    watched(py, jobs, &Arc::default(), None, run)
}

/// Check the simulated physics against closed-form solutions. Returns a dictionary for each check, as
/// `underbrush validate --json` prints them.
#[pyfunction]
#[pyo3(signature = (only = None, *, tolerance_scale = 1.0, jobs = None))]
pub fn validate(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::only)] only: Option<Vec<String>>,
    #[pyo3(from_py_with = argument::tolerance_scale)] tolerance_scale: f64,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Answer<'_> {
    if !(0.0..=f64::MAX).contains(&tolerance_scale) {
        let found = tolerance_scale.to_string();
        return Err(Failure::argument("tolerance_scale", found, "a number, zero or more", "use 1"));
    }
    let chosen = |check: &&Check| only.as_ref().is_none_or(|only| only.iter().any(|name| name == check.name));
    let chosen: Vec<&Check> = CHECKS.iter().filter(chosen).collect();
    let unknown = only.iter().flatten().find(|name| !checks().contains(&name.as_str()));
    let none = chosen.is_empty().then(|| "none".to_owned());
    if let Some(found) = unknown.map(|name| format!("{name:?}")).or(none) {
        return Err(Failure::argument("only", found, checks().join(", "), "choose some of them"));
    }
    let run = |_: &_| Ok(underbrush_validation::run(&chosen, tolerance_scale, stop::check));
    json::to_python(py, &watched(py, jobs, &Arc::default(), None, run)?)
}

/// Names of the physics checks.
#[pyfunction]
pub fn checks() -> Vec<&'static str> {
    CHECKS.iter().map(|check| check.name).collect()
}

/// Run the command line with these arguments, the program's name first, and return its exit status.
#[pyfunction]
pub fn run_command_line(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| ::underbrush::run_command_line(arguments))
}

/// Judge a model or a controller on the frozen scenes of the benchmark, and write a row of its table.
#[pyfunction]
pub fn benchmark<'py>(
    py: Python<'py>,
    track: &str,
    out: PathBuf,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    quick: bool,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Answer<'py> {
    let stop = Arc::new(Stop::default());
    let entry = entry(track, model, controller, verdicts, &stop)?;
    let run = |reported: &Reported| Ok(entry.run(&out, quick, reported)?);
    json::to_python(py, &watched(py, jobs, &stop, progress, run)?)
}

/// The folders of the sets on which an entry is judged, and their numbers of reaches.
#[pyfunction]
#[pyo3(signature = (track, *, out, model = None, controller = None, verdicts = None, quick = false))]
pub fn benchmark_sets(
    track: &str,
    out: PathBuf,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    quick: bool,
) -> Result<Vec<(PathBuf, u64)>, Failure> {
    let sets = entry(track, model, controller, verdicts, &Arc::default())?.sets(quick)?;
    let reaches = |set: &TestSet| set.campaign.scenes.iter().map(|(_, reaches)| reaches).sum::<u64>();
    Ok(sets.iter().map(|set| (set_folder(&out, &set.name, quick), reaches(set))).collect())
}

/// Make part I of N of one of the sets that ``benchmark_sets`` lists, chosen by its index.
#[pyfunction]
#[pyo3(signature = (place, part, *, track, shard, model = None, controller = None, verdicts = None, quick = false, jobs = None))]
pub fn benchmark_part(
    py: Python<'_>,
    place: isize,
    part: PathBuf,
    track: &str,
    shard: &Bound<'_, PyAny>,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    quick: bool,
    jobs: Option<usize>,
) -> Result<(), Failure> {
    let stop = Arc::new(Stop::default());
    let mut sets = entry(track, model, controller, verdicts, &stop)?.sets(quick)?;
    let mut campaign = sets.swap_remove(crate::place(place, sets.len())?).campaign;
    campaign.shard = Some(generate::part(shard)?);
    generate::write(py, &campaign, &part, [false; 2], &stop, None, jobs).map(drop)
}

fn entry(
    track: &str,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    stop: &Arc<Stop>,
) -> Result<Entry, Failure> {
    let (kind, own) = controller::chosen(controller, stop)?;
    let given = controller.is_some() || verdicts.is_some();
    let verdicts = verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten();
    Ok(Entry::new(track, model.as_deref(), given.then_some(EnteredController { kind, own, verdicts }))?)
}
