//! The benchmark: rows of its table, and its data sets, which other machines can make in parts.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::benchmark::{EnteredController, Entry, JudgedModel, TestSet, set_folder};
use underbrush_experiments::verdict_controller::VerdictControl;

use crate::controller;
use crate::failure::Failure;
use crate::generate;
use crate::interrupt::{Stop, watched};
use crate::json;
use crate::progress::Reported;

/// Judge a model or a controller on the frozen scenes of the benchmark, and write a row of its table.
#[pyfunction]
#[pyo3(signature = (track, *, out, model = None, controller = None, verdicts = None, quick = false, progress = None,
                    jobs = None))]
pub fn benchmark<'py>(
    py: Python<'py>,
    track: &str,
    out: PathBuf,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    quick: bool,
    progress: Option<Py<PyAny>>,
    jobs: Option<usize>,
) -> Result<Bound<'py, PyAny>, Failure> {
    let stop = Arc::new(Stop::default());
    let entry = entry(track, model, controller, verdicts, &stop)?;
    let reported = Reported::new(&stop, progress);
    let run = || Ok(entry.run(&out, quick, &reported)?);
    let row = watched(py, jobs, &stop, |py| reported.show(py), run)?;
    reported.show(py)?;
    json::to_python(py, &row)
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
    let of_set = |set: &TestSet| {
        let reaches = set.campaign.scenes.iter().map(|(_, reaches)| reaches).sum();
        (set_folder(&out, &set.name, quick), reaches)
    };
    Ok(sets.iter().map(of_set).collect())
}

/// Make part I of N of one of the sets that ``benchmark_sets`` lists, chosen by its index.
#[pyfunction]
#[pyo3(signature = (place, part, *, track, shard, model = None, controller = None, verdicts = None, quick = false, jobs = None))]
pub fn benchmark_part(
    py: Python<'_>,
    place: usize,
    part: PathBuf,
    track: &str,
    shard: (u64, u64),
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    quick: bool,
    jobs: Option<usize>,
) -> Result<(), Failure> {
    let stop = Arc::new(Stop::default());
    let mut sets = entry(track, model, controller, verdicts, &stop)?.sets(quick)?;
    if place >= sets.len() {
        let allowed = format!("0 to {}", sets.len().saturating_sub(1));
        return Err(Failure::argument("place", place.to_string(), allowed, "choose a set"));
    }
    let mut campaign = sets.swap_remove(place).campaign;
    campaign.shard = generate::shard(Some(shard))?;
    generate::write(py, &campaign, &part, false, &stop, None, jobs).map(drop)
}

fn entry(
    track: &str,
    model: Option<PathBuf>,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
    stop: &Arc<Stop>,
) -> Result<Entry, Failure> {
    let refused = |argument: &str, found: &str, allowed: &str| {
        let remedy = "give a model for verdicts and transfer, a controller for reaching";
        Err(Failure::argument(argument, found.to_owned(), allowed.to_owned(), remedy))
    };
    if track == "reaching" {
        if model.is_some() {
            return refused("model", "a model", "none in the track reaching");
        }
        if controller.is_none() {
            return refused("controller", "None", "a controller in the track reaching");
        }
        let (kind, own) = controller::chosen(controller, stop)?;
        let verdicts = verdicts.as_deref().map(VerdictControl::load).transpose()?;
        return Ok(Entry::Reaching(EnteredController { kind, own, verdicts }));
    }
    if !Entry::TRACKS.contains(&track) {
        return refused("track", track, &Entry::TRACKS.join(", "));
    }
    if controller.is_some() || verdicts.is_some() {
        return refused("controller", "a controller or its verdicts", "none in a track that judges models");
    }
    let Some(model) = model else {
        return refused("model", "None", "a model file in a track that judges models");
    };
    let model = Box::new(JudgedModel::load(&model)?);
    Ok(match track {
        "transfer" => Entry::Transfer(model),
        _ => Entry::Verdicts(model),
    })
}
