//! The arm in the scene: a tree of compliant joints, its equilibrium angles, and what its encoders read.

use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose as WorldPose;

use super::mount::arm_groups;
use super::{Engine, JointState, PlacedLink, Solid};
use crate::arm::Arm;
use crate::dynamics::Tree;
use crate::geometry::parry_pose;

/// One arm in an [`Engine`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ArmBodies {
    /// Where its tree is. The tree's links and coordinates have the order of the arm's links and joints.
    pub(super) slot: usize,
    /// Its collision shapes.
    pub(super) colliders: Vec<ColliderHandle>,
}

impl ArmBodies {
    /// Puts an arm into the engine at rest, in the posture `posture_rad` (one angle per joint), with its equilibrium
    /// angles at that posture. Its base frame is the world frame.
    pub(super) fn insert(arm: &Arm, posture_rad: &[f64], engine: &mut Engine) -> ArmBodies {
        let mut solids = Vec::new();
        for (link, own) in arm.links.iter().enumerate() {
            let surface = arm.surface(link);
            for part in &own.colliders {
                let placed = part.placed(&WorldPose::IDENTITY);
                let shape = ColliderBuilder::new(placed.shape).position(parry_pose(&placed.pose));
                solids.push(Solid { link, shape, groups: arm_groups(), surface, part: link as u16 });
            }
        }
        let slot = engine.scene.insert(Tree::of_arm(arm, posture_rad), solids);
        let passing = arm.passing_links.iter().map(|pair| pair.map(|link| PlacedLink { slot, link }));
        engine.scene.passing_links.extend(passing);
        ArmBodies { slot, colliders: engine.scene.colliders_in(slot).collect() }
    }

    /// The link that carries a collider; `None` for a collider of something else.
    pub(super) fn link_of(&self, engine: &Engine, collider: ColliderHandle) -> Option<usize> {
        let PlacedLink { slot, link } = engine.scene.mount(collider).at;
        (slot == self.slot).then_some(link)
    }

    /// Sets the equilibrium angles φ, rad, of the joints' springs.
    ///
    /// A spring has no torque limit, so each rest angle is kept where |K (φ − q)| is within the limit at the present angle
    /// q. Call it before every step, even if φ stays the same, so that the limit holds while q changes.
    pub(super) fn set_equilibrium(&self, arm: &Arm, equilibrium_angle_rad: &[f64], engine: &mut Engine) {
        let coordinates = engine.scene.tree_mut(self.slot).coordinates.iter_mut();
        for ((own, joint), target) in coordinates.zip(&arm.joints).zip(equilibrium_angle_rad) {
            let reach = joint.torque_limit_nm / joint.stiffness_nm_per_rad;
            // `clamp` would panic if the engine has diverged and the angle is not a number; this passes NaN on.
            own.spring.rest =
                if target.is_nan() { *target } else { target.max(own.position - reach).min(own.position + reach) };
        }
    }

    /// Writes the state of every joint into `states`.
    pub(super) fn read_joints(&self, engine: &Engine, states: &mut Vec<JointState>) {
        states.clear();
        states.extend(engine.scene.tree(self.slot).coordinates.iter().map(|own| JointState {
            angle_rad: own.position,
            velocity_rad_per_s: own.velocity,
            rest_angle_rad: own.spring.rest,
            torque_nm: own.spring.stiffness * (own.spring.rest - own.position) - own.spring.damping * own.velocity,
        }));
    }
}

#[cfg(test)]
mod tests;
