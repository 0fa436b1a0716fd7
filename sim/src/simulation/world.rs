//! The engine's side of a simulation: arm and objects as bodies, the steps of one frame, and their contacts.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Pose};

use super::{
    ArmBodies, Assembly, Engine, FrameReport, Mechanism, Model, PlacedLink, StepContact, StepObserver, StepReport,
    read_poses,
};
use crate::object::COLLIDING_KINDS;
use crate::physics::PhysicsOptions;

/// A collision shape that may touch a dormant object.
#[derive(Clone)]
pub(super) struct Mover {
    pub(super) collider: ColliderHandle,
    /// The box within which it wakes objects.
    pub(super) bounds: Aabb,
}

/// Buffers for putting objects to rest and waking them. They are kept from frame to frame, so that a frame allocates
/// nothing.
#[derive(Clone, Default)]
pub(super) struct DormancyBuffers {
    pub(super) movers: Vec<Mover>,
    /// The objects to put into the engine.
    pub(super) near: Vec<usize>,
}

/// The engine with one arm and one clutter.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct World {
    pub(super) engine: Engine,
    pub(super) arm: ArmBodies,
    /// The collision shape of the object in each contact of the last frame.
    pub(super) contact_colliders: Vec<ColliderHandle>,
    /// The assemblies of objects; `None` for a dormant one.
    pub(super) mechanisms: Vec<Option<Mechanism>>,
    #[serde(skip)]
    pub(super) dormancy: DormancyBuffers,
}

impl World {
    /// The arm in its start posture, its equilibrium angles there, and the clutter at rest.
    pub(super) fn new(model: &Model, physics: PhysicsOptions) -> Self {
        let mut engine = Engine::new(physics);
        engine.table_friction = model.clutter.materials.table_friction.unwrap_or(engine.table_friction);
        let tables = model.clutter.objects.iter().filter(|placed| placed.object.is_ground());
        engine.tables_m.extend(tables.map(|placed| placed.foot_world.z));
        engine.scene.passing =
            model.clutter.passing.iter().map(|pair| pair.each_ref().map(|kind| kind_number(kind))).collect();
        let arm = ArmBodies::insert(&model.arm, &model.arm.start_posture_rad(), &mut engine);
        engine.scene.name_kinds(arm.slot, |_| kind_number("arm"));
        let mechanisms = vec![None; model.assemblies.len()];
        let (contact_colliders, dormancy) = Default::default();
        let mut world = World { engine, arm, contact_colliders, mechanisms, dormancy };
        for index in 0..model.assemblies.len() {
            world.insert(model, index);
        }
        if model.dormancy {
            world.rest_and_wake(model, &[]);
        }
        world
    }

    /// Advances by one frame with the arm's equilibrium angles at `equilibrium_angle_rad`, and writes its contacts into the
    /// report. An observer sees the arm there after each step.
    pub(super) fn advance_frame(
        &mut self,
        model: &Model,
        equilibrium_angle_rad: &[f64],
        report: &mut FrameReport,
        mut observer: Option<&mut StepObserver>,
    ) {
        report.contacts.clear();
        self.contact_colliders.clear();
        let steps = (FRAME_PERIOD_S / self.engine.options.step_s).round() as usize;
        for _ in 0..steps {
            self.arm.set_equilibrium(&model.arm, equilibrium_angle_rad, &mut self.engine);
            self.engine.step();
            let earlier = report.contacts.len();
            self.gather_contacts(model, &mut report.contacts);
            if let Some(observer) = observer.as_deref_mut() {
                self.arm.read_joints(&self.engine, &mut report.joints);
                read_poses(self.engine.scene.tree(self.arm.slot).links(), &mut report.link_pose_world);
                observer(&StepReport {
                    arm: &model.arm,
                    physics: self.engine.options,
                    joints: &report.joints,
                    link_pose_world: &report.link_pose_world,
                    contacts: &report.contacts[earlier..],
                    theta: self.engine.scene.tree(self.arm.slot).theta(),
                    contact_residual: self.engine.contact_step.convergence.residual,
                    missed_overlap_m: self.engine.contact_step.missed_overlap_m,
                });
            }
        }
        if model.dormancy {
            self.rest_and_wake(model, &report.contacts);
        }
    }

    /// Pose of a link in the world frame.
    pub(super) fn link_pose(&self, link: usize) -> Pose {
        *self.engine.scene.link_pose(PlacedLink { slot: self.arm.slot, link })
    }

    /// Puts an assembly into the engine, at rest.
    pub(super) fn insert(&mut self, model: &Model, index: usize) {
        let Assembly { objects, carrier } = &model.assemblies[index];
        let part = |object: &usize| (&model.structures[*object], model.rest_pose_world[*object][0]);
        let carried: Vec<_> = objects[1..].iter().map(part).collect();
        let (base, foot_world) = part(&objects[0]);
        for object in objects.iter().filter(|object| model.structures[**object].can_be_pulled_out()) {
            let placed = &model.clutter.objects[*object];
            self.engine.lay_table(placed.stands_on.map_or(placed, |base| &model.clutter.objects[base]).foot_world.z);
        }
        let mechanism = Mechanism::build_with(base, &mut self.engine, foot_world, *carrier, &carried);
        let kind = |link| model.clutter.objects[model.object_of(index, link).0].object.kind();
        self.engine.scene.name_kinds(mechanism.slot, |link| kind_number(kind(link)));
        self.mechanisms[index] = Some(mechanism);
    }

    /// Adds the contacts of the last step between arm and objects, and of the arm with itself.
    fn gather_contacts(&mut self, model: &Model, contacts: &mut Vec<StepContact>) {
        for contact in &self.engine.contact_step.contacts {
            let links = contact.colliders.map(|collider| self.arm.link_of(&self.engine, collider));
            for (side, link) in links.iter().enumerate() {
                let (Some(link), other) = (*link, contact.colliders[1 - side]) else { continue };
                let of_arm = links[1 - side].map(|other_link| (None, other_link));
                let of_object = || self.object_of(model, other).map(|(object, body)| (Some(object), body));
                let Some((object, body)) = of_arm.or_else(of_object) else { continue };
                let sign = if side == 0 { 1.0 } else { -1.0 };
                contacts.push(StepContact {
                    link,
                    object,
                    body,
                    position_link: contact.position_body[side],
                    inward_world: contact.normal_world * sign,
                    force_world: contact.impulse_world * (sign / FRAME_PERIOD_S),
                    moment_world: contact.moment_world * (sign / FRAME_PERIOD_S),
                    penetration_m: contact.overlap_m,
                    radius_m: contact.radius_m,
                    area_m2: contact.area_m2,
                    slip_world: contact.slip_world * sign,
                });
                self.contact_colliders.push(other);
            }
        }
    }

    /// The object and its body that carry a collider; `None` for a table that is no object.
    fn object_of(&self, model: &Model, collider: ColliderHandle) -> Option<(usize, usize)> {
        let PlacedLink { slot, link } = self.engine.scene.mount(collider).at;
        let is_of = |mechanism: &Option<Mechanism>| mechanism.is_some_and(|mechanism| mechanism.slot == slot);
        Some(model.object_of(self.mechanisms.iter().position(is_of)?, link))
    }
}

/// The place of a kind in [`COLLIDING_KINDS`].
fn kind_number(kind: &str) -> Option<usize> {
    COLLIDING_KINDS.iter().position(|own| *own == kind)
}

#[cfg(test)]
mod tests;
