//! Looking into files, regression suites, and whole studies.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::suite::Checked;
use underbrush_experiments::{Experiment, inspection};
use underbrush_recording::disk::check_free;
use underbrush_report::reproduction::Reproduction;
use underbrush_report::suite_text;

use crate::{Answer, Failure, Reported, alone, json, watched};

/// Check a scene, data set, recording, model or table of trials, and say what it holds.
#[pyfunction]
#[pyo3(signature = (path, seed = 0))]
pub fn inspect(py: Python<'_>, path: PathBuf, seed: u64) -> Answer<'_> {
    let found = alone(py, || Ok(inspection::inspect(&path, seed)?))?;
    json::to_python(py, &found)
}

/// Run regression suites and hold what they find against their bounds.
#[pyfunction]
#[pyo3(signature = (suites, *, seed = None, bless = false, out = None, force = false, progress = None, jobs = None))]
pub fn check<'py>(
    py: Python<'py>,
    suites: Vec<PathBuf>,
    seed: Option<u64>,
    bless: bool,
    out: Option<PathBuf>,
    force: bool,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Answer<'py> {
    if suites.is_empty() {
        return Err(Failure::argument("suites", "none", "one suite file or more", "name one"));
    }
    if bless && seed.is_some() {
        let allowed = "bounds from the seed of the file";
        return Err(Failure::argument("bless", "True with a seed", allowed, "leave the seed out"));
    }
    for name in suite_text::FILES {
        if let Some(folder) = &out {
            check_free(&folder.join(name), force)?;
        }
    }
    let run = |reported: &Reported| {
        let checked = Checked::of(&suites, seed, bless, reported)?;
        if let Some(folder) = &out {
            suite_text::write(folder, &checked)?;
        }
        Ok(checked)
    };
    json::to_python(py, &watched(py, jobs, &Arc::default(), progress, run)?)
}

/// Run an experiment, the paper's if no other is given, and write its report.
#[pyfunction]
#[pyo3(signature = (out, *, experiment = None, quick = false, seed = None, campaigns = 1, force = false, progress = None,
                    jobs = None))]
pub fn reproduce<'py>(
    py: Python<'py>,
    out: PathBuf,
    experiment: Option<PathBuf>,
    quick: bool,
    seed: Option<u64>,
    campaigns: u64,
    force: bool,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Answer<'py> {
    if !(1..=10_000).contains(&campaigns) {
        return Err(Failure::argument("campaigns", campaigns.to_string(), "1 to 10000", "use 1"));
    }
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
    seed: Option<u64>,
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
