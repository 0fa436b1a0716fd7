//! The benchmark: rows of its table, and its data sets, which other machines can make in parts.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::benchmark::{EnteredController, Entry, TestSet, set_folder};
use underbrush_experiments::verdict_controller::VerdictControl;

use crate::{Answer, Failure, Reported, Stop, controller, generate, json, watched};

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
    campaign.shard = Some(generate::part(shard)?);
    generate::write(py, &campaign, &part, false, &stop, None, jobs).map(drop)
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
