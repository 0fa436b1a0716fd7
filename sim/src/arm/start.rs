//! Where an arm starts: the arm in its start posture, with everything that is needed to draw a clutter; which links pass
//! through each other; and a start posture for an arm that has none yet, with the room in front of it for clutter and goals.

use glam::DVec3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use underbrush_recording::Pose;

use super::{Arm, Link, within_half_turn};
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
        let chain = arm.chain(&poses);
        ArmAtStart {
            links: arm.placed_shapes(&poses).collect(),
            end_effector_world: chain[chain.len() - 1],
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

    /// The positions of the joints, followed by that of the end effector, from the poses of the links.
    fn chain(&self, link_poses: &[Pose]) -> Vec<DVec3> {
        let joints = link_poses[1..].iter().map(|pose| pose.position);
        joints.chain([self.end_effector_pose(link_poses).position]).collect()
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
    let Some((patch, surface)) = patches.next() else { return whole };
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

/// Links with at most this many joints between them pass through each other. Choice: simple shapes overlap where links are
/// joined, also across a short link between them. In random postures the first and the third link of the Panda in
/// docs/arms.md overlap in 27 %, by up to 21 mm, and Cody's forearm and flipper in 17 %, by up to 10 mm.
const JOINTS_BETWEEN: usize = 2;

/// The pairs of links that pass through each other, the one nearer to the base first: those with one or two joints between
/// them, those that overlap in the start posture, and those that the arm has already.
pub(super) fn passing_links(arm: &Arm) -> Vec<[usize; 2]> {
    let poses = arm.forward_kinematics(&arm.start_posture_rad());
    let links = arm.links.len();
    let pairs = (0..links).flat_map(|first| (first + 1..links).map(move |second| [first, second]));
    let passes = |pair: &[usize; 2]| {
        let [first, second] = *pair;
        second - first <= JOINTS_BETWEEN || arm.passing_links.contains(pair) || overlap(arm, &poses, *pair)
    };
    pairs.filter(passes).collect()
}

/// Whether two links overlap when the links are at these poses.
pub(super) fn overlap(arm: &Arm, poses: &[Pose], pair: [usize; 2]) -> bool {
    let [own, other] = pair.map(|link| arm.links[link].placed_shapes(poses[link]));
    let other: Vec<_> = other.collect();
    own.into_iter().any(|own| other.iter().any(|other| own.distance_to(other.shape.as_ref(), &other.pose) <= 0.0))
}

/// The room in front of an arm, in shares of its reach. Choice: that of the Panda in docs/arms.md, whose reach is 0.93 m.
pub(super) struct Room {
    /// Length of the chain from the second joint, the shoulder, to the end effector, m.
    pub(super) reach_m: f64,
    /// Place of the shoulder in the frame of the base at zero angles, m.
    pub(super) shoulder_m: DVec3,
}

/// Postures that the search begins with for each place of the end effector.
const STARTS: usize = 48;

impl Room {
    pub(super) fn of(arm: &Arm) -> Self {
        let chain = arm.chain(&arm.forward_kinematics(&[]));
        let beyond = &chain[1.min(arm.joints.len() - 1)..];
        Room { reach_m: path_length_m(beyond), shoulder_m: beyond[0] }
    }

    /// Height of the table top, m.
    pub(super) fn table_m(&self) -> f64 {
        self.shoulder_m.z - 0.15 * self.reach_m
    }

    /// Smallest and largest height of goals, m.
    pub(super) fn goal_heights_m(&self) -> [f64; 2] {
        [0.05, 0.20].map(|share| self.shoulder_m.z + share * self.reach_m)
    }

    /// A posture with the end effector drawn back in front of the shoulder, above the table and level with the goals. Of those
    /// that are found it is the one in which the fewest links overlap, and then the one that is farthest from the limits of
    /// its joints. `None` if the end effector cannot be there.
    pub(super) fn start_posture(&self, arm: &Arm) -> Option<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let [low, high] = self.goal_heights_m();
        let mut best: Option<(usize, f64, Vec<f64>)> = None;
        for (forward, height) in [(0.35, low), (0.35, high), (0.45, low), (0.45, high), (0.25, high)] {
            let place = DVec3::new(self.shoulder_m.x + forward * self.reach_m, self.shoulder_m.y, height);
            for number in 0..STARTS {
                let mut share = || if number == 0 { 0.5 } else { f64::from(random.next_u32()) / f64::from(u32::MAX) };
                let from: Vec<f64> = arm.joints.iter().map(|joint| joint.at_share(share())).collect();
                let Some(posture) = arm.posture_at(place, &from) else { continue };
                let room = posture.iter().zip(&arm.joints).map(|(angle, joint)| {
                    let [low, high] = joint.controller_limits_rad;
                    let [from, to] = within_half_turn([low, high]);
                    (angle - from).min(to - angle) / (high - low)
                });
                let room = room.fold(f64::INFINITY, f64::min);
                let Some(overlaps) = self.overlaps(arm, &posture) else { continue };
                if best.as_ref().is_none_or(|(most, least, _)| (overlaps, *least) < (*most, room)) {
                    best = Some((overlaps, room, posture));
                }
            }
        }
        best.map(|(.., posture)| posture)
    }

    /// How many pairs of links that are not neighbours overlap; `None` if a link beyond the shoulder is below the table.
    fn overlaps(&self, arm: &Arm, posture: &[f64]) -> Option<usize> {
        let poses = arm.forward_kinematics(posture);
        let shapes = arm.links.iter().zip(&poses).skip(3);
        let mut beyond = shapes.flat_map(|(link, pose)| link.placed_shapes(*pose));
        if beyond.any(|shape| -shape.extent_m(DVec3::NEG_Z) < self.table_m()) {
            return None;
        }
        let links = poses.len();
        let pairs = (0..links).flat_map(|a| (a + 2..links).map(move |b| [a, b]));
        Some(pairs.filter(|pair| overlap(arm, &poses, *pair)).count())
    }
}
