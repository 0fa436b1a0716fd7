//! One clamped leaf alone in the engine, without gravity, to be pushed, bent and plucked.

use glam::DVec3;
use rapier3d::prelude::RigidBodyHandle;
use underbrush_oracles::beam;
use underbrush_sim::object::Object;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::physics::{Physics, PhysicsOptions};
use underbrush_sim::simulation::mechanism::Mechanism;

use crate::{Breaks, CheckError, Falsification};

/// A blade of middling size; the closed forms are given these figures.
pub const LENGTH_M: f64 = 0.3;
pub const RIGIDITY_N_M2: f64 = 0.02;
pub const MASS_PER_LENGTH_KG_PER_M: f64 = 0.024;

/// The blade is stiffer than its scene says.
pub const STIFF_BLADE: Falsification = Falsification {
    wrong: "flexural rigidity of the simulated leaf",
    by: "5 % too high",
    breaks: Breaks::Every,
};

/// Such a blade, clamped at its root.
pub fn blade(segments: u32, flexural_rigidity_n_m2: f64, loss_factor: f64) -> Leaf {
    let width_m = 0.03;
    Leaf {
        height_m: LENGTH_M,
        width_m,
        flexural_rigidity_n_m2,
        mass_per_area_kg_per_m2: MASS_PER_LENGTH_KG_PER_M / width_m,
        loss_factor,
        root_stiffness_nm_per_rad: None,
        segments,
    }
}

/// A clamped leaf in an engine of its own; x is across the blade, z up along it.
pub struct ClampedLeaf {
    physics: Physics,
    mechanism: Mechanism,
    tip_local: DVec3,
}

impl ClampedLeaf {
    /// The leaf at rest, upright, in an engine that takes steps of `step_s`.
    ///
    /// # Errors
    /// When the leaf has no shape at its tip.
    pub fn new(leaf: &Leaf, step_s: f64) -> Result<Self, CheckError> {
        let mut physics = Physics::new(PhysicsOptions {
            step_s,
            substeps: 1,
            gravity_m_per_s2: 0.0,
        });
        let mechanism = Mechanism::build(&leaf.structure(), &mut physics, DVec3::ZERO, 0.0);
        let last = mechanism.bodies().last().copied();
        let shape = mechanism.colliders().last().map(|handle| &physics.colliders[*handle]);
        let (Some(last), Some(shape)) = (last, shape) else {
            return Err(CheckError::Case("a leaf without bodies".into()));
        };
        // The top of the last piece, wherever the leaf's own frames stand.
        let top = shape.shape().compute_aabb(shape.position()).maxs.z;
        let tip_local = physics.bodies[last].position().inverse_transform_point(DVec3::Z * top);
        Ok(ClampedLeaf {
            physics,
            mechanism,
            tip_local,
        })
    }

    /// The tip, m, foot frame.
    pub fn tip(&self) -> DVec3 {
        let last = self.mechanism.bodies()[self.mechanism.bodies().len() - 1];
        self.physics.bodies[last].position().transform_point(self.tip_local)
    }

    /// One step with a force, N, and a moment, Nm, on the tip.
    pub fn step(&mut self, force_world: DVec3, moment_world: DVec3) {
        let tip = self.tip();
        let last = self.mechanism.bodies()[self.mechanism.bodies().len() - 1];
        let body = &mut self.physics.bodies[last];
        body.reset_forces(true);
        body.reset_torques(true);
        body.add_force_at_point(force_world, tip, true);
        body.add_torque(moment_world, true);
        self.physics.step();
    }

    /// The tip at rest under a constant load, which is laid on over the first second.
    ///
    /// # Errors
    /// When it does not come to rest.
    pub fn settle(&mut self, force_world: DVec3, moment_world: DVec3) -> Result<DVec3, CheckError> {
        let step_s = self.physics.options.step_s;
        let (mut last, mut still) = (self.tip(), 0);
        for index in 1..=20_000 {
            let share = (f64::from(index) * step_s).min(1.0);
            self.step(force_world * share, moment_world * share);
            let tip = self.tip();
            // Ten steps in which the tip moves less than a rounding error of the closed forms.
            still = if share == 1.0 && tip.distance(last) < 1e-13 {
                still + 1
            } else {
                0
            };
            if still == 10 {
                return Ok(tip);
            }
            last = tip;
        }
        Err(CheckError::Case("the leaf does not come to rest".into()))
    }

    /// Deflection at rest, m, of the point at `height_m` of the upright leaf under a small constant force there.
    ///
    /// # Errors
    /// When it does not come to rest.
    pub fn settle_at(&mut self, force_world: DVec3, height_m: f64) -> Result<f64, CheckError> {
        let below = |handle: &&RigidBodyHandle| self.physics.bodies[**handle].position().translation.z <= height_m;
        let body = self.mechanism.bodies().iter().rfind(below).copied();
        let body = body.ok_or_else(|| CheckError::Case("a height below the leaf".into()))?;
        let point_local = self.physics.bodies[body]
            .position()
            .inverse_transform_point(DVec3::Z * height_m);
        let (mut last, mut still) = (0.0, 0);
        for _ in 0..20_000 {
            let point = self.physics.bodies[body].position().transform_point(point_local);
            let bodies = &mut self.physics.bodies;
            bodies[body].reset_forces(true);
            bodies[body].reset_torques(true);
            bodies[body].add_force_at_point(force_world, point, true);
            self.physics.step();
            let point = self.physics.bodies[body].position().transform_point(point_local).x;
            still = if (point - last).abs() < 1e-13 { still + 1 } else { 0 };
            if still == 10 {
                return Ok(point);
            }
            last = point;
        }
        Err(CheckError::Case("the leaf does not come to rest".into()))
    }

    /// Plucks the leaf in the shape of a clamped beam's first mode, by one step's force in proportion to mass and
    /// mode, and returns the tip's displacement across the blade after each step.
    pub fn pluck(&mut self, seconds: f64) -> Vec<f64> {
        let step_s = self.physics.options.step_s;
        let push_m_per_s = 0.02;
        // The engine knows masses and centres after its first step only.
        self.physics.step();
        for handle in self.mechanism.bodies() {
            let body = &mut self.physics.bodies[*handle];
            let mode = beam::first_mode(body.center_of_mass().z / LENGTH_M);
            body.add_force(DVec3::X * (body.mass() * mode * push_m_per_s / step_s), true);
        }
        self.physics.step();
        for handle in self.mechanism.bodies() {
            self.physics.bodies[*handle].reset_forces(true);
        }
        (0..(seconds / step_s).round() as usize)
            .map(|_| {
                self.physics.step();
                self.tip().x
            })
            .collect()
    }
}

/// Frequency, rad/s, and logarithmic decrement of a vibration about 0, from its rising zeros and its peaks.
///
/// # Errors
/// When it does not vibrate for two periods.
pub fn measure_vibration(displacement: &[f64], step_s: f64) -> Result<(f64, f64), CheckError> {
    let rising: Vec<f64> = displacement
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(index, pair)| (index as f64 - pair[0] / (pair[1] - pair[0])) * step_s)
        .collect();
    if rising.len() < 3 {
        return Err(CheckError::Case(format!("{} zeros in the vibration", rising.len())));
    }
    let periods = (rising.len() - 1) as f64;
    let period_s = (rising[rising.len() - 1] - rising[0]) / periods;
    let peak = |from_s: f64| {
        let start = (from_s / step_s) as usize;
        let end = (((from_s + period_s) / step_s) as usize).min(displacement.len());
        displacement[start..end].iter().copied().fold(0.0, f64::max)
    };
    let decrement = (peak(rising[0]) / peak(rising[rising.len() - 2])).ln() / (periods - 1.0);
    Ok((std::f64::consts::TAU / period_s, decrement))
}
