//! Simulating one reach.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::{VerdictControl, audit, dataset};
use underbrush_sim::reach::ReachPlan;

use crate::reach::Reach;
use crate::{Failure, Stop, argument, controller, scene, show_warning, watched};

/// Simulate one reach.
#[pyfunction(name = "reach")]
#[pyo3(signature = (scene, seed = 0, index = 0, *, controller = None, verdicts = None))]
pub fn simulate(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::seed)] seed: u64,
    #[pyo3(from_py_with = argument::index)] index: u64,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
) -> Result<Reach, Failure> {
    let stop = Arc::new(Stop::default());
    let (kind, own) = controller::chosen(controller, &stop)?;
    let mut plan = ReachPlan::new(self::scene(scene)?, kind, seed)?;
    if let Some(make) = own {
        plan = plan.with_controller(move |arm| make(arm));
        dataset::check_own_name(&plan.controller_name())?;
    }
    if let Some(verdicts) = verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten() {
        plan = verdicts.applied_to(plan)?;
    }
    let run = |_: &_| Ok(plan.run_until(index, &mut |_| {}, &|| stop.is_set())?);
    let recording = watched(py, None, &stop, None, run)?;
    audit::reach_warnings(&recording).into_iter().for_each(show_warning);
    let stated_limit_n = plan.controller.preset().map(|preset| preset.force_limit_n);
    Ok(Reach::simulated(recording, stated_limit_n))
}
