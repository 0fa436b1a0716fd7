//! How much room an arm has in a posture: distances of its collision shapes to upright obstacles, to a floor and to each other.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use underbrush_recording::{BodyShape, Pose};

use crate::arm::{Arm, Joint, LinkCollider};
use crate::geometry::{Capsule, PlacedShape, ROUNDING_M};

/// Random postures in which shapes of one arm are compared, to find those that may touch. Choice: a pair that is near in half a
/// per cent of all postures is missed once in 150 times.
const POSTURES: usize = 1000;
/// Shapes that come this near to each other may touch, m. Choice: an overlap itself is rarer, so it would be missed more often.
const MAY_TOUCH_M: f64 = 0.03;
/// What touches the skin this near to another link is that link, m. Choice: the pitch of taxels, and what shapes leave out.
const OWN_M: f64 = 0.02;

/// The collision shapes of an arm's links, for many queries.
#[derive(Clone, Debug)]
pub struct ArmShapes {
    /// Base first.
    parts: Vec<Part>,
    /// How many of them the base has, which does not move.
    of_base: usize,
    /// Pairs of parts that may touch each other, the one nearer to the base first.
    touching: Vec<[usize; 2]>,
    /// Nothing of the arm may be lower, m, world frame.
    floor_height_m: f64,
}

/// One collision shape.
#[derive(Clone, Debug)]
struct Part {
    link: usize,
    shape: PlacedShape,
    /// A capsule that contains the shape, link frame.
    around: Capsule,
    /// Whether the capsule is the shape.
    is_capsule: bool,
    /// Largest distance of a point of the shape from the axis of each joint that moves it, m.
    lever_m: Vec<f64>,
    /// Whether the shape is above the floor in the start posture. A shape that is not, as in a base that stands on the
    /// floor, is never compared with it.
    above_floor: bool,
}

impl ArmShapes {
    /// The shapes of an arm that is to stay above `floor_height_m`, m, world frame.
    pub fn new(arm: &Arm, floor_height_m: f64) -> Self {
        let start = arm.forward_kinematics(&arm.start_posture_rad());
        let links = arm.links.iter().enumerate();
        let colliders = links.flat_map(|(link, own)| own.colliders.iter().map(move |collider| (link, collider)));
        let parts = colliders.map(|(link, collider)| {
            let (around, is_capsule) = around(collider);
            let shape = collider.placed(&Pose::IDENTITY);
            let extent_m = around.start.length().max(around.end.length()) + around.radius_m;
            let part =
                Part { link, lever_m: levers_m(arm, link, extent_m), shape, around, is_capsule, above_floor: true };
            Part { above_floor: part.above_m(&start[link], floor_height_m) > 0.0, ..part }
        });
        let parts: Vec<Part> = parts.collect();
        let of_base = parts.iter().filter(|part| part.link == 0).count();
        ArmShapes { touching: touching(arm, &parts), of_base, parts, floor_height_m }
    }

    fn moving(&self) -> impl Iterator<Item = &Part> {
        self.parts[self.of_base..].iter()
    }

    /// The share of a motion that is certainly free of obstacles, at least 0; `None` if the arm is not free in its
    /// present posture. `change_rad` is the change of every joint in the whole motion. The arm is free if it is farther
    /// than `margin_m` from every obstacle, above the floor, and does not touch itself.
    pub fn free_share(
        &self,
        link_poses: &[Pose],
        change_rad: &[f64],
        obstacles: &[Capsule],
        margin_m: f64,
    ) -> Option<f64> {
        let around: Vec<Capsule> = self.parts.iter().map(|part| part.around.on(&link_poses[part.link])).collect();
        let mut share = f64::INFINITY;
        let positive = |room_m: f64| if room_m <= 0.0 { None } else { Some(room_m) };
        // The hand comes first, because it moves farthest. What is so far away that it cannot make the share smaller is ruled out by
        // balls, which is most.
        for (part, around) in self.parts.iter().zip(&around).skip(self.of_base).rev() {
            let pose = &link_poses[part.link];
            let moved_m = part.moved_m(change_rad, 0).max(f64::MIN_POSITIVE);
            let mut room_m = share * moved_m + ROUNDING_M;
            let (middle, reach_m) = around.ball();
            for obstacle in obstacles {
                if !obstacle.is_farther(middle, reach_m + margin_m + room_m) {
                    room_m = positive(room_m.min(part.distance_m(pose, around, obstacle, margin_m) - margin_m))?;
                }
            }
            if part.above_floor {
                room_m = positive(room_m.min(part.above_m(pose, self.floor_height_m)))?;
            }
            share = share.min(room_m / moved_m);
        }
        for pair in &self.touching {
            let [near, far] = pair.map(|part| &self.parts[part]);
            let moved_m = far.moved_m(change_rad, near.link).max(f64::MIN_POSITIVE);
            let [around_near, around_far] = pair.map(|part| &around[part]);
            let (middle, reach_m) = around_far.ball();
            if around_near.is_farther(middle, reach_m + share * moved_m + ROUNDING_M) {
                continue;
            }
            share = share.min(positive(near.distance_to_part_m(far, link_poses))? / moved_m);
        }
        Some(share)
    }

    /// Smallest distance between the arm and an obstacle, m; 0 if they overlap.
    pub fn distance_m(&self, link_poses: &[Pose], obstacle: &Capsule) -> f64 {
        let parts = self.moving().map(|part| {
            let pose = &link_poses[part.link];
            part.distance_m(pose, &part.around.on(pose), obstacle, f64::INFINITY).max(0.0)
        });
        parts.fold(f64::INFINITY, f64::min)
    }

    /// Whether a point on a link is so near to another link which that link may touch that the touch is likely the arm's own.
    pub(super) fn is_near_itself(&self, link_poses: &[Pose], link: usize, point_world: DVec3) -> bool {
        let pairs = self.touching.iter().map(|pair| pair.map(|part| &self.parts[part]));
        let others = pairs.filter_map(|[near, far]| match [near.link == link, far.link == link] {
            [true, false] => Some(far),
            [false, true] => Some(near),
            _ => None,
        });
        others.into_iter().any(|other| other.shape.on(&link_poses[other.link]).signed_distance_m(point_world) < OWN_M)
    }

    /// A capsule around each shape, with its link, in the link's frame.
    pub(super) fn capsules_link(&self) -> impl Iterator<Item = (usize, Capsule)> + '_ {
        self.moving().map(|part| (part.link, part.around))
    }

    /// The largest distance that a point of the arm may move in a motion, m.
    pub fn moved_m(&self, change_rad: &[f64]) -> f64 {
        self.moving().map(|part| part.moved_m(change_rad, 0)).fold(0.0, f64::max)
    }
}

/// The pairs of parts whose capsules come near each other in some posture, of links that do not pass through each other.
fn touching(arm: &Arm, parts: &[Part]) -> Vec<[usize; 2]> {
    let pairs = (0..parts.len()).flat_map(|near| (near + 1..parts.len()).map(move |far| [near, far]));
    let may_meet = |pair: &[usize; 2]| {
        let links = pair.map(|part| parts[part].link);
        links[0] != links[1] && !arm.passing_links.contains(&links)
    };
    let mut apart: Vec<[usize; 2]> = pairs.filter(may_meet).collect();
    let (mut touching, mut random) = (Vec::new(), ChaCha8Rng::seed_from_u64(0));
    for _ in 0..POSTURES {
        let angle = |joint: &Joint| {
            let [low, high] = joint.controller_limits_rad;
            low + (high - low) * random.random::<f64>()
        };
        let poses = arm.forward_kinematics(&arm.joints.iter().map(angle).collect::<Vec<_>>());
        touching.extend(apart.extract_if(.., |pair| {
            let [near, far] = pair.map(|part| parts[part].around.on(&poses[parts[part].link]));
            near.distance(&far) < MAY_TOUCH_M
        }));
    }
    touching.sort_unstable();
    touching
}

impl Part {
    /// The largest distance that a point of the shape may move against a link in a motion, m.
    fn moved_m(&self, change_rad: &[f64], link: usize) -> f64 {
        self.lever_m.iter().zip(change_rad).skip(link).map(|(lever, change)| lever * change.abs()).sum()
    }

    /// Distance to another part, m: a bound from below if that is positive, and otherwise exact, with 0 for an overlap.
    fn distance_to_part_m(&self, other: &Part, link_poses: &[Pose]) -> f64 {
        let [own, others] = [self, other].map(|part| part.around.on(&link_poses[part.link]));
        let bound_m = own.distance(&others);
        if bound_m > 0.0 || self.is_capsule && other.is_capsule {
            return bound_m;
        }
        let other = other.shape.on(&link_poses[other.link]);
        self.shape.on(&link_poses[self.link]).distance_to(other.shape.as_ref(), &other.pose)
    }

    /// Distance to an obstacle, m: a bound from below if that is larger than `near_m`, and exact otherwise.
    fn distance_m(&self, link_pose: &Pose, around_world: &Capsule, obstacle: &Capsule, near_m: f64) -> f64 {
        let bound_m = around_world.distance(obstacle);
        if self.is_capsule || bound_m > near_m {
            return bound_m;
        }
        self.shape.on(link_pose).distance(obstacle)
    }

    /// How far the shape is above a height, m: a bound from below if that is positive, and exact otherwise.
    fn above_m(&self, link_pose: &Pose, height_m: f64) -> f64 {
        let around = self.around.on(link_pose);
        let bound_m = around.start.z.min(around.end.z) - around.radius_m - height_m;
        if self.is_capsule || bound_m > 0.0 {
            return bound_m;
        }
        -self.shape.on(link_pose).extent_m(DVec3::NEG_Z) - height_m
    }
}

/// A capsule that contains a collision shape, link frame, and whether it is the shape.
fn around(collider: &LinkCollider) -> (Capsule, bool) {
    let along_z = |half_m: f64, radius_m: f64| Capsule { start: DVec3::Z * -half_m, end: DVec3::Z * half_m, radius_m };
    let (around, is_capsule) = match &collider.shape {
        BodyShape::Sphere { radius_m } => (along_z(0.0, *radius_m), true),
        BodyShape::Capsule { radius_m, length_m } => (along_z(length_m / 2.0, *radius_m), true),
        BodyShape::Cylinder { radius_m, length_m } => (along_z(length_m / 2.0, *radius_m), false),
        // The other corners lie as far from the middle along each axis as these two.
        BodyShape::Box { size_m } => (around_points(&[-*size_m / 2.0, *size_m / 2.0]), false),
        BodyShape::Hull { points_m } => (around_points(points_m), false),
    };
    (around.on(&collider.pose_link), is_capsule)
}

/// A capsule along the axis in which the points extend farthest, which contains them.
fn around_points(points: &[DVec3]) -> Capsule {
    let low = points.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let high = points.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let longest = DVec3::AXES.into_iter().max_by(|a, b| half.dot(*a).total_cmp(&half.dot(*b))).unwrap_or(DVec3::Z);
    let across = |point: &DVec3| (*point - middle).reject_from_normalized(longest).length();
    let along = longest * half.dot(longest);
    Capsule { start: middle - along, end: middle + along, radius_m: points.iter().map(across).fold(0.0, f64::max) }
}

/// For each joint that moves a link, the largest distance of the link's points from the joint, m, if they are at most
/// `extent_m` from the link's origin: the length of the chain between them.
fn levers_m(arm: &Arm, link: usize, extent_m: f64) -> Vec<f64> {
    let offsets: Vec<f64> = arm.joints.iter().map(|joint| joint.origin_parent.position.length()).collect();
    (0..link).map(|joint| offsets[joint + 1..link].iter().sum::<f64>() + extent_m).collect()
}

/// Largest difference of two postures in any joint, rad.
pub fn largest_change_rad(from_rad: &[f64], to_rad: &[f64]) -> f64 {
    from_rad.iter().zip(to_rad).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max)
}

/// The posture at this share of the way between two.
pub fn between(from_rad: &[f64], to_rad: &[f64], share: f64) -> Vec<f64> {
    from_rad.iter().zip(to_rad).map(|(from, to)| from + (to - from) * share).collect()
}

/// Euclidean distance of two postures, rad.
pub fn distance_rad(from_rad: &[f64], to_rad: &[f64]) -> f64 {
    from_rad.iter().zip(to_rad).map(|(from, to)| (to - from) * (to - from)).sum::<f64>().sqrt()
}
