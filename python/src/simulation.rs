//! The simulation, step by step.

use std::collections::HashSet;
use std::sync::{Arc, Mutex, MutexGuard};

use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use underbrush_recording::SkinLayout;
use underbrush_render::Stage;
use underbrush_sim::{ReachPlan, Simulation};

use crate::{Answer, Failure, PyArm, PyCamera, PyFrame, Skin, alone, argument, array, locked, picture, pool, scene};

/// The arm in one draw of a scene, moved step by step.
#[pyclass(frozen, name = "Simulation", module = "underbrush._core")]
pub struct PySimulation {
    plan: ReachPlan,
    layout: Arc<SkinLayout>,
    index: u64,
    state: Mutex<Simulation>,
}

impl PySimulation {
    /// The state, unless another thread is using it.
    fn lock(&self) -> Result<MutexGuard<'_, Simulation>, Failure> {
        let busy =
            "another thread is using this simulation; give each thread a simulation of its own, or use step_many";
        // After a panic of the engine, the state may be one from the middle of a frame.
        locked(&self.state, busy, "the physics engine failed in this simulation; make a new one")
    }

    fn frame(&self, simulation: &Simulation) -> PyFrame {
        let goal = simulation.clutter().goals.first().copied().unwrap_or(DVec3::ZERO);
        PyFrame { frame: simulation.frame(0, goal), layout: Arc::clone(&self.layout) }
    }

    fn png(&self, py: Python<'_>) -> Result<Vec<u8>, Failure> {
        alone(py, || picture::png(&*self.lock()?))
    }
}

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(signature = (scene, seed = 0, index = 0))]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = argument::seed)] seed: u64,
        #[pyo3(from_py_with = argument::index)] index: u64,
    ) -> Result<Self, Failure> {
        let scene = scene::scene(scene)?;
        alone(py, || {
            let plan = ReachPlan::new(scene, None, seed)?;
            let (layout, state) = (Arc::new(plan.arm.skin.layout.clone()), Mutex::new(plan.simulation(index)?));
            Ok(PySimulation { plan, layout, index, state })
        })
    }

    /// Advance by one frame of 10 ms with the joints' springs at these equilibrium angles, rad.
    fn step(&self, py: Python<'_>, equilibrium_rad: &Bound<'_, PyAny>) -> Result<PyFrame, Failure> {
        let angles = array::finite(equilibrium_rad, "equilibrium_rad", &[Some(self.plan.arm.joints.len())])?;
        alone(py, || {
            // Locked in here, so that a panic of the engine marks the state as unusable.
            let mut simulation = self.lock()?;
            simulation.step(&angles);
            Ok(self.frame(&simulation))
        })
    }

    /// The present frame.
    #[getter]
    fn frame_now(&self) -> Result<PyFrame, Failure> {
        Ok(self.frame(&*self.lock()?))
    }

    /// The present state as bytes, for `restore`.
    fn save<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>, Failure> {
        Ok(PyBytes::new(py, &self.lock()?.save()?))
    }

    /// Continue, bit for bit, from a state that was saved by a simulation of the same scene, seed and index.
    fn restore(&self, state: &[u8]) -> Result<(), Failure> {
        Ok(self.lock()?.load(state)?)
    }

    /// A copy that continues exactly as this one would.
    fn copy(&self) -> Result<Self, Failure> {
        let state = Mutex::new(self.lock()?.clone());
        Ok(PySimulation { plan: self.plan.clone(), layout: Arc::clone(&self.layout), index: self.index, state })
    }

    fn __copy__(&self) -> Result<Self, Failure> {
        self.copy()
    }

    fn __deepcopy__(&self, memo: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        let _ = memo;
        self.copy()
    }

    /// The arm.
    #[getter]
    fn arm(&self) -> PyArm {
        PyArm { arm: self.plan.arm.clone() }
    }

    /// The skin.
    #[getter]
    fn skin(&self) -> Skin {
        Skin { layout: Arc::clone(&self.layout) }
    }

    /// The goals of the reach, m, world frame: (goals, 3).
    #[getter]
    fn goals_world<'py>(&self, py: Python<'py>) -> Answer<'py> {
        let simulation = self.lock()?;
        Ok(array::lend_rows(py, simulation.clutter().goals.iter().flat_map(|goal| goal.to_array()).collect(), 3)?)
    }

    /// Ground truth: the largest force between one link and one object in the last frame, N.
    #[getter]
    fn largest_contact_force_n(&self) -> Result<f64, Failure> {
        Ok(self.lock()?.report().tactile.largest_force().map_or(0.0, |force| force.force_n))
    }

    /// Draw arm and clutter as they are now, with an arrow for each contact force on the arm.
    fn draw<'py>(&self, py: Python<'py>) -> Answer<'py> {
        Ok(picture::shown(py, self.png(py)?)?)
    }

    /// A picture of arm and clutter as they are now, as an array that may be written. ``"rgb"``: (height, width, 3), uint8, with
    /// shadows and the forces on the skin. ``"depth"``: (height, width), float32, m along the line of sight of the picture's
    /// middle, infinite where nothing is. ``"segmentation"``: (height, width), uint16, places in ``labels``. Without a camera
    /// it is taken from the right of the arm; this place stays the same while the simulation runs.
    #[pyo3(signature = (width = 640, height = 360, *, camera = None, kind = "rgb"))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = argument::width)] width: usize,
        #[pyo3(from_py_with = argument::height)] height: usize,
        camera: Option<&PyCamera>,
        kind: &str,
    ) -> Result<Bound<'py, PyAny>, Failure> {
        let simulation = self.lock()?;
        picture::draw(py, (&simulation, &self.frame(&simulation).frame), (width, height), camera, kind)
    }

    /// What the numbers of a segmentation mean: 0 is the background, 1 the table; then follow links and objects.
    #[getter]
    fn labels(&self) -> Result<Vec<String>, Failure> {
        let simulation = self.lock()?;
        Ok(Stage::now(&simulation, &self.frame(&simulation).frame, None, 1.0, false)?.2)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyBytes>, Failure> {
        Ok(PyBytes::new(py, &self.png(py)?))
    }

    fn __repr__(&self) -> String {
        let name = &self.plan.scene.name;
        format!("Simulation({name:?}, seed={}, index={})", self.plan.seed, self.index)
    }
}

/// Step many simulations at once, over all cores: one row of `equilibrium_rad` for each.
#[pyfunction]
#[pyo3(signature = (simulations, equilibrium_rad, jobs = None))]
pub fn step_many(
    py: Python<'_>,
    simulations: Vec<Py<PySimulation>>,
    equilibrium_rad: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = argument::jobs)] jobs: Option<usize>,
) -> Result<Vec<PyFrame>, Failure> {
    let Some(first) = simulations.first() else { return Ok(Vec::new()) };
    let joints = first.get().plan.arm.joints.len();
    if let Some(other) = simulations.iter().find(|other| other.get().plan.arm.joints.len() != joints) {
        let found = format!("arms with {joints} and with {} joints", other.get().plan.arm.joints.len());
        return Err(Failure::argument("simulations", found, "arms alike", "step them apart"));
    }
    let mut known = HashSet::new();
    if !simulations.iter().all(|simulation| known.insert(simulation.as_ptr() as usize)) {
        return Err(Failure::argument("simulations", "one of them twice", "each once", "copy() it"));
    }
    let angles = array::finite(equilibrium_rad, "equilibrium_rad", &[Some(simulations.len()), Some(joints)])?;
    let simulations: Vec<&PySimulation> = simulations.iter().map(Py::get).collect();
    pool::detached(py, jobs, || {
        // All are locked first: if another thread is using one of them, none has moved.
        let mut states = simulations.iter().map(|simulation| simulation.lock()).collect::<Result<Vec<_>, _>>()?;
        let mut states: Vec<&mut Simulation> = states.iter_mut().map(|state| &mut **state).collect();
        let stepped = states.par_iter_mut().zip(angles.par_chunks(joints)).zip(&simulations);
        Ok(stepped
            .map(|((state, angles), simulation)| {
                state.step(angles);
                simulation.frame(state)
            })
            .collect())
    })
}
