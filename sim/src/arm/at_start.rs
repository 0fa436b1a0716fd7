//! Where an arm stands before a reach.

use glam::DVec3;

use super::{Arm, LinkCollider};
use crate::geometry::Capsule;

/// Where an arm starts and how far it reaches: what the clutter must know of it.
#[derive(Clone, Debug)]
pub struct ArmAtStart {
    /// Its links in the start posture, world frame.
    pub links: Vec<Capsule>,
    /// Its tip, m, world frame.
    pub tip_world: DVec3,
    /// The point it reaches from (its shoulder), m, world frame.
    pub shoulder_world: DVec3,
    /// Its length from there, m.
    pub length_m: f64,
}

impl ArmAtStart {
    /// Of an arm in its start posture.
    pub fn of(arm: &Arm) -> Self {
        let poses = arm.forward_kinematics(&arm.start_posture_rad());
        let links = arm
            .links
            .iter()
            .zip(&poses)
            .flat_map(|(link, pose)| link.colliders.iter().filter_map(|collider| capsule(collider, pose)))
            .collect::<Vec<Capsule>>();
        // From the first joint whose offset from the next is a bone rather than an actuator's width.
        let tip_world = arm.tip_pose(&poses).translation;
        let chain: Vec<DVec3> = poses[1..]
            .iter()
            .map(|pose| pose.translation)
            .chain([tip_world])
            .collect();
        let length_m = chain.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        ArmAtStart {
            links,
            tip_world,
            shoulder_world: chain[0],
            length_m,
        }
    }
}

/// The capsule around a link's collision shape.
fn capsule(collider: &LinkCollider, link_pose: &rapier3d::prelude::Pose) -> Option<Capsule> {
    let (shape, turn) = collider.shape.engine_shape()?;
    Some(Capsule::around(
        shape.as_ref(),
        &(*link_pose * collider.pose_link * turn),
    ))
}
