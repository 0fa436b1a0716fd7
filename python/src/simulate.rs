//! Simulating one reach.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_sim::reach::ReachPlan;

use crate::controller;
use crate::failure::Failure;
use crate::interrupt::{Stop, watched};
use crate::reach::Reach;
use crate::scene::scene;

/// Simulate one reach.
#[pyfunction(name = "reach")]
#[pyo3(signature = (scene, seed = 0, index = 0, *, controller = None, verdicts = None))]
pub fn simulate(
    py: Python<'_>,
    scene: &Bound<'_, PyAny>,
    seed: u64,
    index: u64,
    controller: Option<&Bound<'_, PyAny>>,
    verdicts: Option<PathBuf>,
) -> Result<Reach, Failure> {
    let stop = Arc::new(Stop::default());
    let (kind, own) = controller::chosen(controller, &stop)?;
    let mut plan = ReachPlan::new(self::scene(scene)?, kind, seed)?;
    if let Some(make) = own {
        plan = plan.with_controller(move |arm| make(arm));
    }
    if let Some(model) = verdicts {
        plan = VerdictControl::load(&model)?.applied_to(plan)?;
    }
    let run = |_: &_| Ok(plan.run_until(index, &mut |_, _| {}, &|| stop.is_set())?);
    Ok(Reach::of_recording(watched(py, None, &stop, None, run)?))
}
