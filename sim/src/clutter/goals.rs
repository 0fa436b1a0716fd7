//! The goals: drawn so that the arm passes through plants on its way.

use std::collections::BTreeMap;

use glam::DVec3;
use parry3d::shape::Cuboid;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::{InputError, Pose};

use super::PlacedObject;
use crate::arm::{Arm, ArmAtStart};
use crate::geometry::{Capsule, PlacedShape, ROUNDING_M, segment_distance};
use crate::range::{Draw, PLACE_M};
use crate::scene::Scene;

/// Candidates for one goal before the attempt is given up.
const GOAL_TRIES: usize = 5000;
/// Candidates for which postures are sought. Each may take some milliseconds.
const POSTURE_TRIES: usize = 100;
/// Postures tried for one goal: the arm's own, and random ones to start the search from.
const STARTS: usize = 24;
/// A goal that is not reached from this many starts is out of reach.
const STARTS_WITHIN_REACH: usize = 6;
/// Clearance between the arm at a goal and trunks, rolls and bottles, m. Choice: a finger's breadth.
const GOAL_MARGIN_M: f64 = 0.02;

/// The goals that the scene lists, m, world frame, which are not checked; or else goals that are drawn one by one. On its way
/// from each goal to the next the arm passes through a plant, and it has a posture at each goal that is within its joints'
/// limits and clear of table, foam and obstacles. `for_postures` gives the postures from which such a one is sought.
pub(super) fn draw_goals(
    scene: &Scene,
    arm: &ArmAtStart,
    objects: &[PlacedObject],
    random: &mut ChaCha8Rng,
    for_postures: &mut ChaCha8Rng,
) -> Result<Vec<DVec3>, InputError> {
    let settings = &scene.file.goals;
    if let Some(goals) = &settings.positions_m {
        return Ok(goals.iter().copied().map(DVec3::from_array).collect());
    }
    let is_plant = |placed: &&PlacedObject| placed.object.foam_top().is_none() && !placed.object.is_ground();
    let plants: Vec<Capsule> = objects.iter().filter(is_plant).map(PlacedObject::bounding_capsule).collect();
    let surroundings = Surroundings::new(&arm.arm, scene.file.workspace.table_height_m, objects);
    let mut from = arm.end_effector_world;
    let mut goals = Vec::new();
    for number in 0..settings.count {
        let mut rejected = Rejected::default();
        let goal = (0..GOAL_TRIES).find_map(|_| {
            let mut draw = |own: Draw| own.draw(random, PLACE_M).ok();
            let goal = DVec3::new(draw(settings.x_m)?, draw(settings.y_m)?, draw(settings.z_m)?);
            if rejected.sought() >= POSTURE_TRIES {
                return None;
            }
            rejected.tried += 1;
            let is_beyond_length = arm.shoulder_world.distance(goal) > arm.length_m;
            if !plants.is_empty() && !passes_through(arm, &plants, from, goal) {
                let count = if is_beyond_length { &mut rejected.beside_beyond_length } else { &mut rejected.beside };
                *count += 1;
                return None;
            }
            match surroundings.admit(&arm.arm, goal, for_postures) {
                Ok(()) => return Some(goal),
                Err(Some(by)) => *rejected.blocked.entry(by).or_default() += 1,
                Err(None) if is_beyond_length => rejected.beyond_length += 1,
                Err(None) => rejected.no_posture += 1,
            }
            None
        });
        let goal = goal.ok_or_else(|| {
            let is_skin_beside = rejected.beside > 0 && rejected.sought() == 0;
            let first = arm.arm.skin.layout.patches.first().filter(|_| is_skin_beside);
            let skin =
                first.map(|own| format!("; the skin here is its first patch, {} of link {}", own.name, own.link));
            let found = format!("no goal number {} in {}{}", number + 1, rejected.text(), skin.unwrap_or_default());
            let allowed = match first {
                Some(_) => "goals among the objects, or a first patch in the skin file that is farther from the base",
                None => "ranges of goals among the objects, where the arm has room",
            };
            scene.fault("goals", found, allowed)
        })?;
        goals.push(goal);
        from = goal;
    }
    Ok(goals)
}

/// How many places of a goal were rejected, and why, for the error message.
#[derive(Default)]
struct Rejected {
    tried: usize,
    beside: usize,
    /// Beside the plants, and farther from the shoulder than the arm is long.
    beside_beyond_length: usize,
    /// Farther from the shoulder than the arm is long, of those for which postures were sought.
    beyond_length: usize,
    /// Out of reach within the limits of the joints.
    no_posture: usize,
    /// By what is in the way of the last posture that was found.
    blocked: BTreeMap<&'static str, usize>,
}

impl Rejected {
    /// Places for which postures were sought.
    fn sought(&self) -> usize {
        self.beyond_length + self.no_posture + self.blocked.values().sum::<usize>()
    }

    fn text(&self) -> String {
        let Rejected { tried, beside, beside_beyond_length, beyond_length, no_posture, blocked } = self;
        let beyond_length = beside_beyond_length + beyond_length;
        let blocked =
            blocked.iter().map(|(by, count)| format!(", at {count} every posture found is too close to {by}"));
        format!(
            "{tried} places: on a straight way to {beside} the skin meets no plant, {beyond_length} are farther than the arm \
             is long, {no_posture} are out of reach within the limits of its joints{}",
            blocked.collect::<String>()
        )
    }
}

/// What an arm at a goal must be clear of.
struct Surroundings {
    table_height_m: f64,
    /// Foam blocks, with their poses.
    foam: Vec<(Cuboid, Pose)>,
    obstacles: Vec<Capsule>,
    /// Whether each collision shape of the arm is clear in the start posture. Of a base that stands on the table, some
    /// never are, and these are not compared.
    clear_at_start: Vec<bool>,
}

impl Surroundings {
    fn new(arm: &Arm, table_height_m: f64, objects: &[PlacedObject]) -> Self {
        let foam = objects.iter().filter(|placed| placed.object.foam_top().is_some());
        let obstacles = objects.iter().filter(|placed| placed.object.is_obstacle());
        let mut surroundings = Surroundings {
            table_height_m,
            foam: foam.map(PlacedObject::outline).collect(),
            obstacles: obstacles.map(PlacedObject::bounding_capsule).collect(),
            clear_at_start: Vec::new(),
        };
        let poses = arm.forward_kinematics(&arm.start_posture_rad());
        let clear = arm.placed_shapes(&poses).map(|shape| surroundings.in_the_way(&shape).is_none());
        surroundings.clear_at_start = clear.collect();
        surroundings
    }

    /// Looks for a free posture with the end effector at `goal`, first from the arm's start posture.
    ///
    /// # Errors
    /// What is in the way of the last posture that was found; `None` if the arm cannot reach the goal.
    fn admit(&self, arm: &Arm, goal: DVec3, random: &mut ChaCha8Rng) -> Result<(), Option<&'static str>> {
        let mut start_rad = arm.start_posture_rad();
        let mut blocked = None;
        for starts in 1..=STARTS {
            if let Some(posture_rad) = arm.posture_at(goal, &start_rad) {
                blocked = self.in_the_way_of_all(arm, &posture_rad);
                if blocked.is_none() {
                    return Ok(());
                }
            }
            if blocked.is_none() && starts >= STARTS_WITHIN_REACH {
                return Err(None);
            }
            for (angle, joint) in start_rad.iter_mut().zip(&arm.joints) {
                *angle = joint.at_share(random.next_u32() as f64 / f64::from(u32::MAX));
            }
        }
        Err(blocked)
    }

    fn in_the_way_of_all(&self, arm: &Arm, posture_rad: &[f64]) -> Option<&'static str> {
        let poses = arm.forward_kinematics(posture_rad);
        let shapes = arm.placed_shapes(&poses).zip(&self.clear_at_start);
        shapes.filter(|(_, compared)| **compared).find_map(|(shape, _)| self.in_the_way(&shape))
    }

    /// What leaves no room for a shape.
    fn in_the_way(&self, shape: &PlacedShape) -> Option<&'static str> {
        if -shape.extent_m(DVec3::NEG_Z) <= self.table_height_m {
            return Some("the table");
        }
        // Balls rule out most of what is far away.
        let (middle, reach_m) = shape.ball();
        let is_in = |(block, pose): &(Cuboid, Pose)| {
            pose.position.distance(middle) <= reach_m + block.half_extents.length() + ROUNDING_M
                && shape.distance_to(block, pose) <= 0.0
        };
        let is_near = |obstacle: &Capsule| {
            !obstacle.is_farther(middle, reach_m + GOAL_MARGIN_M + ROUNDING_M)
                && shape.distance(obstacle) < GOAL_MARGIN_M
        };
        if self.foam.iter().any(is_in) {
            return Some("foam");
        }
        self.obstacles.iter().any(is_near).then_some("an obstacle")
    }
}

/// Whether the skin meets a plant on the way, if the arm is taken to be straight from the shoulder to the end effector.
///
/// This looks at the first patch of skin and not at the hand, because that patch is the one that is classified: an
/// operator picks goals that bring it among plants.
pub(super) fn passes_through(arm: &ArmAtStart, plants: &[Capsule], from: DVec3, goal: DVec3) -> bool {
    let behind = |end: DVec3, distance: f64| end + (arm.shoulder_world - end).normalize_or_zero() * distance;
    let sweeps = arm.skin.behind_end_effector_m.map(|distance| (behind(from, distance), behind(goal, distance)));
    let [nearest, _, farthest] = sweeps;
    let at_goal = (nearest.1, farthest.1);
    plants.iter().any(|plant| {
        let mut ways = sweeps.iter().chain([&at_goal]);
        ways.any(|(a, b)| segment_distance(*a, *b, plant.start, plant.end) - plant.radius_m < arm.skin.radius_m)
    })
}
