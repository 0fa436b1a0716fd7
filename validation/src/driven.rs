//! One degree of freedom of an object alone in the engine, let go or driven along a given way.

use glam::DVec3;
use rapier3d::prelude::{MultibodyLink, RigidBodyHandle};
use underbrush_sim::object::Object;
use underbrush_sim::physics::{Physics, PhysicsOptions};
use underbrush_sim::simulation::mechanism::Mechanism;

use crate::CheckError;

/// A moment of a driven way.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Place of the coordinate, m.
    pub place: f64,
    /// Force of the drive on it, N.
    pub force: f64,
}

/// An object of which one coordinate is watched or driven.
pub struct Driven {
    physics: Physics,
    mechanism: Mechanism,
    body: RigidBodyHandle,
    axis: usize,
}

impl Driven {
    /// Length of a step, s.
    pub const STEP_S: f64 = 1e-3;
    /// Stiffness of the drive, over the coordinate's own. Only that the drive is stiff depends on the simulated object: the
    /// force is the drive's own, its stiffness times how far it is behind.
    const DRIVE: f64 = 1e3;

    /// The object at rest, with the coordinate along `axis` of the joint that carries body number `body`.
    ///
    /// # Errors
    /// When the object has no such body.
    pub fn new(object: &dyn Object, gravity_m_per_s2: f64, body: usize, axis: usize) -> Result<Self, CheckError> {
        let mut physics = Physics::new(PhysicsOptions {
            step_s: Self::STEP_S,
            substeps: 1,
            gravity_m_per_s2,
        });
        let mechanism = Mechanism::build(&object.structure(), &mut physics, DVec3::ZERO, 0.0);
        let body = mechanism.bodies().get(body).copied();
        Ok(Driven {
            physics,
            mechanism,
            body: body.ok_or_else(|| CheckError::Case("no such body in the object".into()))?,
            axis,
        })
    }

    fn link(&mut self) -> Option<&mut MultibodyLink> {
        let link = *self.physics.joints.rigid_body_link(self.body)?;
        self.physics.joints.get_multibody_mut(link.multibody)?.link_mut(link.id)
    }

    fn place(&mut self) -> f64 {
        let axis = self.axis;
        self.link().map_or(f64::NAN, |link| link.joint.coords()[axis])
    }

    /// Where the coordinate is after some time without any drive.
    pub fn let_go(&mut self, seconds: f64) -> f64 {
        for _ in 0..(seconds / Self::STEP_S).round() as usize {
            self.mechanism.relax(&mut self.physics);
            self.physics.step();
        }
        self.place()
    }

    /// Drives the coordinate along `way` (time, s, to place) by a stiff spring beside its own, step by step.
    pub fn drive(&mut self, way: impl Fn(f64) -> f64, seconds: f64) -> Vec<Point> {
        let axis = self.axis;
        (1..=(seconds / Self::STEP_S).round() as usize)
            .map(|index| {
                self.mechanism.relax(&mut self.physics);
                let goal = way(index as f64 * Self::STEP_S);
                let mut drive = 0.0;
                if let Some(link) = self.link() {
                    let (own, rest) = link.joint.spring(axis);
                    drive = own * Self::DRIVE;
                    link.joint
                        .set_spring(axis, own + drive, (own * rest + drive * goal) / (own + drive));
                }
                self.physics.step();
                let place = self.place();
                Point {
                    place,
                    force: drive * (goal - place),
                }
            })
            .collect()
    }
}
