//! Environments for agents that learn, in the form that Gymnasium expects.

use std::sync::{Mutex, MutexGuard};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use underbrush_sim::environment::{EnvironmentOptions, Environments, Part, Stepped};
use underbrush_sim::{ControllerKind, ReachPlan};

use crate::pool::{self, Helpers};
use crate::{Failure, PyCamera, argument, array, given, locked, picture, scene};

/// Several environments that are stepped together.
#[pyclass(frozen, name = "Environments", module = "underbrush._core")]
pub struct PyEnvironments {
    state: Mutex<State>,
    parts: Vec<Part>,
    count: usize,
    /// How many numbers an action has.
    #[pyo3(get)]
    action_size: usize,
    jobs: Option<usize>,
    helpers: Helpers,
}

struct State {
    environments: Environments,
    /// A row for each environment.
    observations: Vec<f32>,
}

/// What a call of an environment returns: the observations, and what each step gave by name.
type Answer<'py> = (Bound<'py, PyAny>, Bound<'py, PyDict>);

impl PyEnvironments {
    fn lock(&self) -> Result<MutexGuard<'_, State>, Failure> {
        let busy =
            "another thread is using these environments; wait for it, or give each thread environments of its own";
        locked(&self.state, busy, "these environments failed before; make new ones")
    }

    fn answer<'py>(&self, py: Python<'py>, state: &State, stepped: &[Option<Stepped>]) -> Result<Answer<'py>, Failure> {
        let size = state.observations.len() / self.count.max(1);
        let observations = array::copy(py, &state.observations, &[self.count, size])?;
        let info = PyDict::new(py);
        let set = |name: &str, dtype: &str, number: fn(&Stepped) -> f64| {
            let column = stepped.iter().map(|own| own.as_ref().map_or(0.0, number));
            info.set_item(name, array::row(py, column)?.call_method1("astype", (dtype,))?)
        };
        set("reward", "float64", |own| own.reward)?;
        set("distance_m", "float64", |own| own.distance_m)?;
        set("sensed_force_n", "float64", |own| own.sensed_force_n)?;
        set("contact_force_n", "float64", |own| own.contact_force_n)?;
        set("terminated", "bool", |own| f64::from(u8::from(own.terminated)))?;
        set("truncated", "bool", |own| f64::from(u8::from(own.truncated)))?;
        set("reach_index", "int64", |own| own.reach_index as f64)?;
        let outcomes = stepped.iter().map(|own| own.and_then(|own| own.outcome).map_or("", |outcome| outcome.name()));
        info.set_item("outcome", outcomes.collect::<Vec<_>>())?;
        Ok((observations, info))
    }
}

#[pymethods]
impl PyEnvironments {
    #[new]
    #[pyo3(signature = (scene, count = 1, seed = 0, *, controller = None, jobs = None, **options),
           text_signature = "(scene, count=1, seed=0, *, controller=None, action='equilibrium', frames_per_step=None, \
                             largest_change_rad=None, largest_waypoint_m=None, goals=None, time_limit_s=None, reward=None, \
                             jobs=None)")]
    fn new(
        scene: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::num_envs)] count: usize,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        controller: Option<&str>,
        #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> Result<Self, Failure> {
        let options: EnvironmentOptions = given::options(options)?;
        let kind = controller.map(ControllerKind::from_name).transpose()?;
        let plan = ReachPlan::new(self::scene(scene)?, kind, seed)?;
        if !(1..=4096).contains(&count) {
            return Err(Failure::argument("num_envs", count.to_string(), "1 to 4096", "change it"));
        }
        let environments = Environments::new(&plan, &options, count)?;
        Ok(PyEnvironments {
            parts: environments.all[0].parts.clone(),
            count,
            action_size: environments.action_size(),
            jobs,
            helpers: Helpers::new(jobs)?,
            state: Mutex::new(State { observations: vec![0.0; count * environments.observation_size()], environments }),
        })
    }

    /// The parts of an observation: name, shape, first number, smallest and largest value.
    #[getter]
    fn parts(&self) -> Vec<(String, Vec<usize>, usize, f32, f32)> {
        let part = |part: &Part| (part.name.clone(), part.shape.clone(), part.first, part.range[0], part.range[1]);
        self.parts.iter().map(part).collect()
    }

    /// A picture of one of the environments: (height, width, 3), uint8; None before its first episode.
    fn render<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        #[pyo3(from_py_with = argument::width)] width: usize,
        #[pyo3(from_py_with = argument::height)] height: usize,
        camera: Option<&PyCamera>,
    ) -> Result<Option<Bound<'py, PyAny>>, Failure> {
        let state = self.lock()?;
        let shown = state.environments.all.get(index).and_then(|own| own.simulation().zip(own.frame()));
        let Some((simulation, frame)) = shown else { return Ok(None) };
        picture::draw(py, (simulation, &frame), (width, height), camera, "rgb").map(Some)
    }

    /// Begin an episode in all environments, or in those that the mask selects.
    #[pyo3(signature = (seeds = None, mask = None))]
    fn reset<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = argument::seeds)] seeds: Option<Vec<Option<u64>>>,
        mask: Option<Vec<bool>>,
    ) -> Result<Answer<'py>, Failure> {
        let seeds = seeds.unwrap_or_else(|| vec![None; self.count]);
        Failure::unless_one_each("seeds", seeds.len(), self.count, "environment")?;
        Failure::unless_one_each("mask", mask.as_ref().map_or(self.count, Vec::len), self.count, "environment")?;
        let mut state = self.lock()?;
        let own = &mut *state;
        let stepped = pool::detached(py, self.jobs, || {
            let which = |index: usize| mask.as_ref().is_none_or(|mask| mask[index]);
            Ok(own.environments.reset(&seeds, which, &mut own.observations)?)
        })?;
        self.answer(py, &state, &stepped)
    }

    /// Take a step with each environment: one row of `actions` for each.
    fn step<'py>(&self, py: Python<'py>, actions: &Bound<'py, PyAny>) -> Result<Answer<'py>, Failure> {
        let actions = array::finite(actions, "action", &[Some(self.count), Some(self.action_size)])?;
        let mut state = self.lock()?;
        let own = &mut *state;
        let stepped = py.detach(|| {
            // One environment needs no other thread.
            let helpers = if self.count > 1 { self.helpers.get()? } else { None };
            pool::guarded(|| Ok(own.environments.step(helpers.as_deref(), &actions, &mut own.observations)?))
        })?;
        let stepped: Vec<Option<Stepped>> = stepped.into_iter().map(Some).collect();
        self.answer(py, &state, &stepped)
    }

    /// Time in seconds of steps without Python between them, for `actions` of (steps, environments, numbers). The
    /// comparison shows what stepping from Python costs.
    fn seconds_of_steps(&self, py: Python<'_>, actions: &Bound<'_, PyAny>) -> Result<f64, Failure> {
        let actions = array::finite(actions, "actions", &[None, Some(self.count), Some(self.action_size)])?;
        let mut state = self.lock()?;
        let own = &mut *state;
        py.detach(|| {
            let helpers = self.helpers.get()?;
            let start = std::time::Instant::now();
            for row in actions.chunks(self.count * self.action_size) {
                pool::guarded(|| Ok(own.environments.step(helpers.as_deref(), row, &mut own.observations)?))?;
            }
            Ok(start.elapsed().as_secs_f64())
        })
    }
}
