//! An arm in its start posture, with everything that is needed to draw a clutter.

use glam::DVec3;
use underbrush_recording::Pose;

use super::{Arm, Link};
use crate::geometry::PlacedShape;

/// An arm, and where it starts.
#[derive(Clone, Debug)]
pub struct ArmAtStart {
    /// Its collision shapes in the start posture, world frame.
    pub links: Vec<PlacedShape>,
    /// Position of its end effector, m, world frame.
    pub end_effector_world: DVec3,
    /// Position of its shoulder, m, world frame.
    pub shoulder_world: DVec3,
    /// Length of the chain from the shoulder to the end effector, m.
    pub length_m: f64,
    /// Its first patch of skin, which is the one that is classified by default.
    pub skin: SkinAlongArm,
    /// The arm.
    pub arm: Arm,
}

/// Where a patch of skin lies on a fully extended arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinAlongArm {
    /// Distances behind the end effector, along the bones, of the first taxels, the middle and the last taxels, m.
    pub behind_end_effector_m: [f64; 3],
    /// Largest distance of its taxels from the axis of its link, m.
    pub radius_m: f64,
}

/// Joints closer to each other than this count as one joint with several axes, without a bone between them, m.
const MIN_BONE_M: f64 = 1e-3;

impl ArmAtStart {
    /// The arm in its start posture.
    pub fn of(arm: &Arm) -> Self {
        let poses = arm.forward_kinematics(&arm.start_posture_rad());
        let end_effector_world = arm.end_effector_pose(&poses).position;
        let chain: Vec<DVec3> = poses[1..].iter().map(|pose| pose.position).chain([end_effector_world]).collect();
        ArmAtStart {
            links: arm.placed_shapes(&poses).collect(),
            end_effector_world,
            shoulder_world: chain[0],
            length_m: path_length_m(&chain),
            skin: first_patch(arm, &poses, &chain),
            arm: arm.clone(),
        }
    }
}

impl Link {
    /// Its collision shapes with the link at this pose.
    pub(super) fn placed_shapes(&self, link_pose: Pose) -> impl Iterator<Item = PlacedShape> + '_ {
        self.colliders.iter().map(move |collider| collider.placed(&link_pose))
    }
}

fn path_length_m(points: &[DVec3]) -> f64 {
    points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

impl Arm {
    /// The collision shapes of all links with their poses in the world, from the poses of the links.
    pub fn placed_shapes<'a>(&'a self, link_poses: &'a [Pose]) -> impl Iterator<Item = PlacedShape> + 'a {
        self.links.iter().zip(link_poses).flat_map(|(link, pose)| link.placed_shapes(*pose))
    }
}

/// The bone of a moving link: its far end, at the next joint or the end effector, and the direction from there to the
/// near end, world frame. `chain` holds the positions of the joints, followed by that of the end effector.
fn bone(chain: &[DVec3], link: usize) -> (DVec3, DVec3) {
    let far_end = chain[link];
    let near_end = chain[..link].iter().rev().find(|joint| joint.distance(far_end) > MIN_BONE_M);
    (far_end, near_end.map_or(DVec3::Z, |near_end| (*near_end - far_end).normalize()))
}

/// Where the first patch on a moving link lies; if there is none, the axis of the whole arm.
fn first_patch(arm: &Arm, poses: &[Pose], chain: &[DVec3]) -> SkinAlongArm {
    let length_m = path_length_m(chain);
    let whole = SkinAlongArm { behind_end_effector_m: [0.0, length_m / 2.0, length_m], radius_m: 0.0 };
    let patches = arm.skin.layout.patches.iter().zip(&arm.skin.surfaces);
    let mut patches = patches.filter(|(patch, surface)| surface.link > 0 && !patch.taxels.is_empty());
    let Some((patch, surface)) = patches.next() else {
        return whole;
    };
    let (far_end, axis) = bone(chain, surface.link);
    let behind_far_end_m = path_length_m(&chain[surface.link..]);
    let (mut first_m, mut last_m, mut radius_m) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for taxel in &patch.taxels {
        let from_far_end = poses[surface.link].transform_point(taxel.position_link) - far_end;
        let along_m = from_far_end.dot(axis);
        first_m = first_m.min(along_m);
        last_m = last_m.max(along_m);
        radius_m = radius_m.max((from_far_end - axis * along_m).length());
    }
    SkinAlongArm {
        behind_end_effector_m: [first_m, (first_m + last_m) / 2.0, last_m].map(|along_m| behind_far_end_m + along_m),
        radius_m,
    }
}
