//! Making data sets.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::dataset::{Campaign, Written, require_same_reaches};
use underbrush_experiments::{VerdictControl, audit};
use underbrush_recording::disk::{Dataset, Shard, Shards, check_not_input, make_room};
use underbrush_recording::stop;

use crate::dataset::lasting;
use crate::{Failure, PyDataset, Reported, Stop, argument, controller, scene, show_warning, watched};

/// Simulate many reaches and write them as a data set; if it is ``shared``, one part of them into a folder that all parts share.
/// Then there is a set if no other part is at work and all reaches are there.
#[pyfunction]
#[pyo3(signature = (scenes, reaches, out, *, seed = 0, controller = None, verdicts = None, resume = false, force = false,
                    shard = None, shared = false, progress = None, jobs = None))]
pub fn generate(
    py: Python<'_>,
    scenes: Vec<Bound<'_, PyAny>>,
    #[pyo3(from_py_with = argument::reaches)] reaches: u64,
    out: PathBuf,
    #[pyo3(from_py_with = argument::seed)] seed: u64,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    resume: bool,
    force: bool,
    shard: Option<&Bound<'_, PyAny>>,
    shared: bool,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Result<Option<PyDataset>, Failure> {
    let stop = Arc::new(Stop::default());
    let scenes = scenes.iter().map(scene).collect::<Result<Vec<_>, _>>()?;
    let verdicts = verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten();
    let (controller, own_controller) = controller::chosen(controller, &stop)?;
    let mut campaign = Campaign { controller, own_controller, verdicts, ..Campaign::new(scenes, reaches, seed)? };
    let part = shard.map(part).transpose()?;
    if let Some(part) = part.filter(|_| shared) {
        let out = lasting(&out)?;
        let run = |reported: &Reported| Ok(campaign.write_shared(&out, part, reported)?);
        return Ok(watched(py, jobs, &stop, progress, run)?.map(audited));
    }
    campaign.shard = part;
    check_room(&out, &[], resume, force)?;
    write(py, &campaign, &out, [resume, force], &stop, progress, jobs).map(Some)
}

/// Make a data set again from what it stores.
#[pyfunction]
pub fn generate_again(
    py: Python<'_>,
    dataset: PathBuf,
    out: PathBuf,
    verdicts: Option<PathBuf>,
    resume: bool,
    force: bool,
    progress: Option<Py<PyAny>>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Result<PyDataset, Failure> {
    let verdicts = verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten();
    let source = Dataset::open(&dataset)?;
    let campaign = Campaign::of(&source, verdicts)?;
    check_room(&out, &[dataset], resume, force)?;
    let made = write(py, &campaign, &out, [resume, force], &Arc::default(), progress, jobs)?;
    require_same_reaches(&made.dataset, &source)?;
    Ok(made)
}

/// Demands that a set is not both resumed and removed, and that its folder is not one of the inputs.
fn check_room(out: &Path, inputs: &[PathBuf], resume: bool, force: bool) -> Result<(), Failure> {
    if resume && force {
        return Err(Failure::argument("force", "True with resume", "either resume or force", "leave one out"));
    }
    Ok(check_not_input(out, inputs)?)
}

/// Part I of N, counted from 1.
///
/// # Errors
/// `Fault::Input` if there is no such part.
pub fn part(shard: &Bound<'_, PyAny>) -> Result<Shard, Failure> {
    match shard.extract::<(u64, u64)>() {
        Ok((number, count)) if (1..=count).contains(&number) => Ok(Shard { index: number - 1, count }),
        _ => {
            let allowed = "(I, N) with 1 <= I <= N";
            Err(Failure::argument("shard", shard.to_string(), allowed, "count shards from 1"))
        }
    }
}

/// Runs a campaign and writes its set.
pub fn write(
    py: Python<'_>,
    campaign: &Campaign,
    out: &Path,
    [resume, force]: [bool; 2],
    stop: &Arc<Stop>,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Result<PyDataset, Failure> {
    let out = lasting(out)?;
    let run = |reported: &Reported| Ok(campaign.overwrite(&out, resume, force, reported)?);
    Ok(audited(watched(py, jobs, stop, progress, run)?))
}

/// A set that is written, after the warnings about its reaches.
fn audited(written: Written) -> PyDataset {
    let dataset = written.dataset();
    audit::warnings(dataset.episodes(), &dataset.plan().layout).into_iter().for_each(show_warning);
    PyDataset::new(dataset)
}

/// Join all parts that ``generate(..., shard=(I, N))`` has made into the set that one call without ``shard`` makes,
/// byte for byte.
///
/// Parameters
/// ----------
/// parts : list of paths
///     The folders of all parts, in any order.
/// out : path
///     The folder to write.
/// resume : bool
///     Continue an interrupted merge. If the set is finished already, open it.
/// force : bool
///     Remove the data set that is in ``out`` first.
///
/// Returns
/// -------
/// Dataset
///
/// Raises
/// ------
/// InputError
///     If a folder holds no finished part or a damaged one, if parts are missing, given twice or from different
///     campaigns, or if ``out`` holds anything (with ``resume``, anything but this merge). The message names it.
#[pyfunction]
#[pyo3(signature = (parts, out, *, resume = false, force = false))]
pub fn merge(
    py: Python<'_>,
    #[pyo3(from_py_with = argument::parts)] parts: Vec<PathBuf>,
    out: PathBuf,
    resume: bool,
    force: bool,
) -> Result<PyDataset, Failure> {
    check_room(&out, &parts, resume, force)?;
    let out = lasting(&out)?;
    let merge = |_: &_| {
        let shards = Shards::open(&parts)?;
        make_room(&out, force)?;
        Ok(shards.merge(&out, resume, stop::check)?)
    };
    Ok(PyDataset::new(watched(py, None, &Arc::default(), None, merge)?))
}
