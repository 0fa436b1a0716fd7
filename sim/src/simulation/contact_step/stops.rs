//! End stops of joints, as rows of the contact solver.

use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::Parts;
use super::copied::Copied;
use crate::contact::stop::Stop;

/// An end stop of a joint, on both sides.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(in crate::simulation) struct JointStop {
    pub(in crate::simulation) joint: MultibodyJointHandle,
    /// The free axis in the engine's layout of six.
    pub(in crate::simulation) axis: usize,
    /// Lower and upper limit, rad.
    pub(in crate::simulation) limits_rad: [f64; 2],
    pub(in crate::simulation) stiffness_nm_per_rad: f64,
    pub(in crate::simulation) loss_time_s: f64,
}

/// A stop is solved for when its joint is this close to a limit, rad: at 5 rad/s a joint covers it in a step of 10 ms.
const NEAR_STOP_RAD: f64 = 0.05;

impl JointStop {
    /// The copied body that has this joint; `None` if the joint cannot reach a limit in this step.
    pub(super) fn body(&self, copies: &[Copied], parts: &Parts) -> Option<usize> {
        let (multibody, link) = parts.joints.get(self.joint)?;
        let angle = multibody.link(link)?.joint.coords()[self.axis];
        let [lower, upper] = self.limits_rad;
        if angle >= lower + NEAR_STOP_RAD && angle <= upper - NEAR_STOP_RAD {
            return None;
        }
        let root = multibody.root().rigid_body_handle();
        let index = parts.joints.rigid_body_link(root)?.multibody;
        copies.iter().position(|copied| copied.index == index)
    }

    /// The stops at both limits, for a body whose velocities begin at index `first`.
    pub(super) fn rows(&self, first: usize, parts: &Parts) -> Option<[Stop; 2]> {
        let (multibody, link) = parts.joints.get(self.joint)?;
        let link = multibody.link(link)?;
        // The engine has moved on to the end of its step.
        let angle = link.joint.coords()[self.axis] - parts.step_s * multibody.joint_velocity(link)[0];
        let [lower, upper] = self.limits_rad;
        Some([(1.0, lower - angle), (-1.0, angle - upper)].map(|(sign, overlap_rad)| Stop {
            index: first + link.assembly_id(),
            sign,
            overlap_rad,
            stiffness_nm_per_rad: self.stiffness_nm_per_rad,
            loss_time_s: self.loss_time_s,
        }))
    }
}
