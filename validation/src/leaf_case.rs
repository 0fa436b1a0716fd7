//! One clamped leaf that is alone in the engine, without gravity, and can be pushed, bent and plucked.

use glam::DVec3;
use underbrush_oracles::beam;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::simulation::test_rig::{BodyId, Rig};

use crate::pressed_arm::LEAF;
use crate::{Falsification, Fault};

/// A blade of medium size. The closed forms use these numbers.
pub const LENGTH_M: f64 = 0.3;
pub const RIGIDITY_N_M2: f64 = 0.02;
pub const MASS_PER_LENGTH_KG_PER_M: f64 = 0.024;
pub const WIDTH_M: f64 = 0.03;

/// The blade is stiffer than its scene says.
pub const STIFF_BLADE: Falsification = Falsification::new("flexural rigidity of the simulated leaf", "5 % too high");

/// A blade of this size, clamped at its root.
pub fn blade(segments: u32, flexural_rigidity_n_m2: f64, loss_factor: f64) -> Leaf {
    Leaf {
        height_m: LENGTH_M,
        width_m: WIDTH_M,
        flexural_rigidity_n_m2,
        mass_per_area_kg_per_m2: MASS_PER_LENGTH_KG_PER_M / WIDTH_M,
        loss_factor,
        root_stiffness_nm_per_rad: None,
        segments,
        ..LEAF
    }
}

/// A clamped leaf on a rig; x is across the blade, z up along it.
pub struct ClampedLeaf {
    rig: Rig,
    bodies: Vec<BodyId>,
    /// The highest body, and the tip in its frame.
    last: BodyId,
    tip_body: DVec3,
}

impl ClampedLeaf {
    /// The leaf at rest, upright, in an engine that takes steps of `step_s`.
    pub fn new(leaf: &Leaf, step_s: f64) -> Self {
        let mut rig = Rig::new(PhysicsOptions { step_s, gravity_m_per_s2: 0.0 });
        let bodies = rig.add_object(leaf);
        let last = bodies[bodies.len() - 1];
        let tip_body = rig.pose_world(last).inverse_transform_point(DVec3::Z * leaf.height_m);
        ClampedLeaf { rig, bodies, last, tip_body }
    }

    /// The tip, m, foot frame.
    pub fn tip(&self) -> DVec3 {
        self.rig.pose_world(self.last).transform_point(self.tip_body)
    }

    /// One step with a force, N, and a moment, N m, on the tip.
    pub fn step(&mut self, force_world: DVec3, moment_world: DVec3) {
        let tip = self.tip();
        self.rig.push(self.last, force_world, tip, moment_world);
        self.rig.step();
    }

    /// The tip at rest under a load that increases over the first second and is then constant.
    ///
    /// # Errors
    /// When it does not come to rest.
    pub fn settle(&mut self, force_world: DVec3, moment_world: DVec3) -> Result<DVec3, Fault> {
        let step_s = self.rig.physics().step_s;
        at_rest(|index| {
            let share = (f64::from(index) * step_s).min(1.0);
            self.step(force_world * share, moment_world * share);
            (self.tip(), share == 1.0)
        })
    }

    /// Deflection at rest, m, of the point at `height_m` of the upright leaf under a small constant force there.
    ///
    /// # Errors
    /// When it does not come to rest.
    pub fn settle_at(&mut self, force_world: DVec3, height_m: f64) -> Result<f64, Fault> {
        let below = |body: &&BodyId| self.rig.pose_world(**body).position.z <= height_m;
        let body = self.bodies.iter().rfind(below).copied();
        let body = body.ok_or_else(|| Fault::Run("a height below the leaf".into()))?;
        let point_body = self.rig.pose_world(body).inverse_transform_point(DVec3::Z * height_m);
        let place = |rig: &Rig| rig.pose_world(body).transform_point(point_body);
        let rest = at_rest(|_| {
            let point = place(&self.rig);
            self.rig.push(body, force_world, point, DVec3::ZERO);
            self.rig.step();
            (DVec3::X * place(&self.rig).x, true)
        });
        Ok(rest?.x)
    }

    /// Plucks the leaf in the shape of a clamped beam's first mode, with a force in proportion to mass and mode during
    /// one step that gives the tip a speed, and returns the tip's displacement across the blade after each later step.
    pub fn pluck(&mut self, push_m_per_s: f64, seconds: f64) -> Vec<f64> {
        let step_s = self.rig.physics().step_s;
        // The engine knows masses and centres of mass only after its first step.
        self.rig.step();
        for body in &self.bodies {
            let center = self.rig.center_of_mass_world(*body);
            let mode = beam::first_mode(center.z / LENGTH_M);
            let force = DVec3::X * (self.rig.mass_kg(*body) * mode * push_m_per_s / step_s);
            self.rig.push(*body, force, center, DVec3::ZERO);
        }
        self.rig.step();
        (0..(seconds / step_s).round() as usize)
            .map(|_| {
                self.rig.step();
                self.tip().x
            })
            .collect()
    }
}

/// Where a point is at rest: after ten steps in which it moves less than a rounding error of the closed forms. `step`, which is
/// given the number of the step, returns its place and whether the load is constant.
fn at_rest(mut step: impl FnMut(u32) -> (DVec3, bool)) -> Result<DVec3, Fault> {
    let (mut last, mut still) = (DVec3::ZERO, 0);
    for index in 1..=20_000 {
        let (place, is_constant) = step(index);
        still = if is_constant && place.distance(last) < 1e-13 { still + 1 } else { 0 };
        if still == 10 {
            return Ok(place);
        }
        last = place;
    }
    Err(Fault::Run("the leaf does not come to rest".into()))
}

/// Frequency, rad/s, and logarithmic decrement of a vibration about 0, from its rising zeros and its peaks.
///
/// # Errors
/// When it does not vibrate for two periods.
pub fn measure_vibration(displacement: &[f64], step_s: f64) -> Result<(f64, f64), Fault> {
    let rising: Vec<f64> = displacement
        .array_windows()
        .enumerate()
        .filter(|(_, [before, after])| *before < 0.0 && *after >= 0.0)
        .map(|(index, [before, after])| (index as f64 - before / (after - before)) * step_s)
        .collect();
    if rising.len() < 3 {
        return Err(Fault::Run(format!("{} zeros in the vibration", rising.len())));
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
