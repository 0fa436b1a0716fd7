//! Making data sets.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyList;
use underbrush_experiments::dataset::{Campaign, Written};
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_recording::disk::{Dataset, Shard};

use crate::controller;
use crate::dataset::PyDataset;
use crate::failure::Failure;
use crate::interrupt::{Stop, watched};
use crate::progress::Reported;
use crate::scene::scene;

/// Simulate many reaches and write them as a data set.
#[pyfunction]
#[pyo3(signature = (scenes, reaches, out, *, seed = 0, controller = None, verdicts = None, resume = false, shard = None,
                    progress = None, jobs = None))]
#[allow(clippy::too_many_arguments, reason = "options by name")]
fn generate(
    py: Python<'_>,
    scenes: &Bound<'_, PyAny>,
    reaches: u64,
    out: PathBuf,
    seed: u64,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    resume: bool,
    shard: Option<(u64, u64)>,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Result<PyDataset, Failure> {
    let listed = match scenes.cast::<PyList>() {
        Ok(list) => list.iter().map(|own| scene(&own)).collect::<Result<Vec<_>, _>>()?,
        Err(_) => vec![scene(scenes)?],
    };
    let mut names: Vec<&str> = listed.iter().map(|scene| scene.name.as_str()).collect();
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let found = format!("two scenes called {}", pair[0]);
        return Err(Failure::argument(
            "scenes",
            found,
            "scenes with names of their own",
            "rename one of them",
        ));
    }
    let stop = Arc::new(Stop::default());
    let (kind, own) = controller::chosen(controller, &stop)?;
    let campaign = Campaign {
        scenes: listed.into_iter().map(|scene| (scene, reaches)).collect(),
        arms: BTreeMap::new(),
        seed,
        controller: kind,
        own_controller: own,
        verdicts: verdicts.as_deref().map(VerdictControl::load).transpose()?,
        shard: self::shard(shard)?,
    };
    write(py, &campaign, &out, resume, &stop, progress, jobs)
}

/// Make a data set again from what it stores.
#[pyfunction]
#[pyo3(signature = (dataset, out, *, verdicts = None, resume = false, progress = None, jobs = None))]
#[allow(clippy::too_many_arguments, reason = "options by name")]
fn generate_again(
    py: Python<'_>,
    dataset: PathBuf,
    out: PathBuf,
    verdicts: Option<PathBuf>,
    resume: bool,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Result<PyDataset, Failure> {
    let verdicts = verdicts.as_deref().map(VerdictControl::load).transpose()?;
    let campaign = Campaign::of(&Dataset::open(dataset)?, verdicts)?;
    write(py, &campaign, &out, resume, &Arc::new(Stop::default()), progress, jobs)
}

/// Part I of N, counted from 1.
pub fn shard(shard: Option<(u64, u64)>) -> Result<Option<Shard>, Failure> {
    match shard {
        None => Ok(None),
        Some((number, count)) if (1..=count).contains(&number) => Ok(Some(Shard {
            index: number - 1,
            count,
        })),
        Some((number, count)) => {
            let found = format!("({number}, {count})");
            let allowed = "(I, N) with 1 <= I <= N";
            Err(Failure::argument("shard", found, allowed, "count shards from 1"))
        }
    }
}

/// Runs a campaign and writes its set.
pub fn write(
    py: Python<'_>,
    campaign: &Campaign,
    out: &std::path::Path,
    resume: bool,
    stop: &Arc<Stop>,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Result<PyDataset, Failure> {
    let reported = Reported::new(stop, progress);
    let run = || Ok(campaign.write(out, resume, &reported)?);
    let written = watched(py, jobs, stop, |py| reported.show(py), run)?;
    reported.show(py)?;
    match written {
        Written::New(dataset) | Written::Before(dataset) => Ok(PyDataset::new(dataset)),
    }
}

/// Adds the functions of this file.
pub fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(generate, module)?)?;
    module.add_function(wrap_pyfunction!(generate_again, module)?)
}
