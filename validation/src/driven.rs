//! One degree of freedom of an object that is alone in the engine. It is released, or driven along a given path.

use underbrush_sim::object::Object;
use underbrush_sim::object::structure::Axis;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::simulation::test_rig::{BodyId, Rig};

/// One step of a driven path.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Displacement of the coordinate, m.
    pub place: f64,
    /// Force of the drive on it, N.
    pub force: f64,
}

/// An object with one coordinate that is observed or driven.
pub struct Driven {
    rig: Rig,
    body: BodyId,
    axis: Axis,
}

impl Driven {
    /// Length of a step, s.
    pub const STEP_S: f64 = 1e-3;
    /// Stiffness of the drive relative to the coordinate's own. The exact value does not matter, because the force is
    /// computed from the drive itself: its stiffness times its lag.
    const DRIVE: f64 = 1e3;

    /// The object at rest, with the coordinate along `axis` of the joint that carries body number `body`.
    pub fn new(object: &dyn Object, gravity_m_per_s2: f64, body: usize, axis: Axis) -> Self {
        let mut rig = Rig::new(PhysicsOptions { step_s: Self::STEP_S, gravity_m_per_s2 });
        let body = rig.add_object(object)[body];
        Driven { rig, body, axis }
    }

    fn place(&self) -> f64 {
        self.rig.coordinate(self.body, self.axis).unwrap_or(f64::NAN)
    }

    /// Displacement of the coordinate after some time without a drive.
    pub fn let_go(&mut self, seconds: f64) -> f64 {
        self.rig.step_times((seconds / Self::STEP_S).round() as u32);
        self.place()
    }

    /// Drives the coordinate along `path` (from time, s, to displacement), step by step.
    pub fn drive(&mut self, path: impl Fn(f64) -> f64, seconds: f64) -> Vec<Point> {
        (1..=(seconds / Self::STEP_S).round() as usize)
            .map(|index| {
                let goal = path(index as f64 * Self::STEP_S);
                let force = self.rig.step_driven(self.body, self.axis, Self::DRIVE, goal);
                Point { place: self.place(), force: force.unwrap_or(f64::NAN) }
            })
            .collect()
    }
}
