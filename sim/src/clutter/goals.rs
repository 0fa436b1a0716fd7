//! The goals: drawn so that the arm passes through plants on its way.

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::InputError;

use super::PlacedObject;
use crate::arm::ArmAtStart;
use crate::geometry::{Capsule, segment_distance};
use crate::object::Object;
use crate::range::Quantity;
use crate::scene::Scene;

/// Candidates for one goal before the attempt is given up.
const GOAL_TRIES: usize = 5000;
/// Clearance between an obstacle and a hand that points along it and ends at a goal, m. Choice: a finger's breadth.
const GOAL_MARGIN_M: f64 = 0.02;
/// Largest distance of a goal from the shoulder, as a share of the arm's length. Choice: a fully extended arm cannot
/// yield.
const REACHABLE_SHARE: f64 = 0.97;

/// Distance that goals keep from the surface of trunks and rolls, m: half the thickness of the hand, and the margin.
/// 6.1 cm for Cody.
pub(super) fn goal_clearance_m(arm: &ArmAtStart) -> f64 {
    arm.hand_half_thickness_m + GOAL_MARGIN_M
}

/// Draws the goals one by one, such that the arm passes through a plant on its way from each goal to the next.
pub(super) fn draw_goals(
    scene: &Scene,
    arm: &ArmAtStart,
    objects: &[PlacedObject],
    random: &mut ChaCha8Rng,
) -> Result<Vec<DVec3>, InputError> {
    let settings = &scene.file.goals;
    let capsules = |wanted: fn(&dyn Object) -> bool| -> Vec<Capsule> {
        let wanted = objects.iter().filter(|placed| wanted(placed.object.as_ref()));
        wanted.map(PlacedObject::bounding_capsule).collect()
    };
    let plants = capsules(|object| object.foam_top().is_none());
    let obstacles = capsules(|object| object.is_obstacle());
    let anywhere = (-5.0, 5.0);
    let mut from = arm.end_effector_world;
    let mut goals = Vec::new();
    for number in 0..settings.count {
        let mut too_far = 0;
        let goal = (0..GOAL_TRIES).find_map(|_| {
            let draw = |quantity: &Quantity, random: &mut ChaCha8Rng| quantity.draw(random, anywhere).ok();
            let goal = DVec3::new(
                draw(&settings.x_m, random)?,
                draw(&settings.y_m, random)?,
                draw(&settings.z_m, random)?,
            );
            if goal.distance(arm.shoulder_world) > REACHABLE_SHARE * arm.length_m {
                too_far += 1;
                return None;
            }
            let hand = Capsule {
                start: goal,
                end: goal,
                radius_m: goal_clearance_m(arm),
            };
            let clear = obstacles.iter().all(|object| object.distance(&hand) > 0.0);
            let wanted = plants.is_empty() || passes_through(arm, &plants, from, goal);
            (clear && wanted).then_some(goal)
        });
        let goal = goal.ok_or_else(|| {
            let found = format!(
                "no goal number {} that leads through the clutter ({too_far} of {GOAL_TRIES} were out of the arm's reach)",
                number + 1
            );
            scene.fault("goals", found, "ranges of goals among the objects and within the arm's reach")
        })?;
        goals.push(goal);
        from = goal;
    }
    Ok(goals)
}

/// Whether the skin meets a plant on the way, if the arm is taken to be straight from the shoulder to the end effector.
///
/// This looks at the first patch of skin and not at the hand, because that patch is the one that is classified: an
/// operator picks goals that bring it among plants.
fn passes_through(arm: &ArmAtStart, plants: &[Capsule], from: DVec3, goal: DVec3) -> bool {
    let behind = |end: DVec3, distance: f64| end + (arm.shoulder_world - end).normalize_or_zero() * distance;
    let sweeps = arm
        .skin
        .behind_end_effector_m
        .map(|distance| (behind(from, distance), behind(goal, distance)));
    let [nearest, _, farthest] = sweeps;
    let at_goal = (nearest.1, farthest.1);
    plants.iter().any(|plant| {
        sweeps.iter().chain([&at_goal]).any(|(a, b)| {
            let middle_lines = segment_distance(*a, *b, plant.start, plant.end);
            middle_lines - plant.radius_m < arm.skin.radius_m
        })
    })
}
