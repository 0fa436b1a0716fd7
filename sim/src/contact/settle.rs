//! Finds the patch of two shapes whose contact is roughly known.

use glam::{DVec2, DVec3};

use super::chord::Faces;
use super::outline::{Outline, Region};
use super::patch::{Columns, Node};
use super::plane::{Pair, Plane};
use crate::geometry::parry_pose;

/// Where a contact was a step ago, or where a first search found it.
#[derive(Clone, Copy, Debug)]
pub struct KnownContact {
    /// A place of the patch, m, world frame.
    pub origin_world: DVec3,
    /// Its unit normal, from the second shape into the first, world frame.
    pub normal_world: DVec3,
    /// Where its region ended, and the direction of the strips of the region, world frame. `None` in a first search.
    pub region: Option<(Outline, DVec3)>,
}

/// Columns may lie along a direction that differs from the normal by less than this, rad: overlaps along both differ by half
/// of its square.
const ALONG_NORMAL_RAD: f64 = 0.01;
/// Trials to settle. A contact that was found a step ago needs one or two.
const MAX_TRIALS: usize = 7;

/// Adds the columns of the patch to `nodes`, and returns its plane and what is known of the contact for the next step. `over_m`
/// returns the overlap beyond which columns belong to the patch, m, for a plane and the overlap at its origin. `None` if
/// there is no such column.
pub fn settle(
    pair: &Pair,
    known: &KnownContact,
    faces: &mut [Faces; 2],
    mut over_m: impl FnMut(&Plane, f64) -> f64,
    nodes: &mut Vec<Node>,
) -> Option<(Plane, KnownContact)> {
    let (mut plane, mut outline) = match known.region {
        None => (pair.plane(known.origin_world, known.normal_world), Outline::default()),
        Some((outline, strip_world)) => {
            (pair.plane_along(known.origin_world, known.normal_world, strip_world), outline)
        }
    };
    let leading = pair.leading(known.normal_world);
    // The last region, its plane, its normal and its center.
    let mut last: Option<(Region, Plane, DVec3, DVec2)> = None;
    for _ in 0..MAX_TRIALS {
        let columns = Columns::new(pair, &plane, faces)?;
        let over_m = over_m(&plane, columns.overlap_m(DVec2::ZERO).unwrap_or(f64::NEG_INFINITY));
        let Some(region) = columns.region(over_m, &outline) else {
            let reach_m = reach_m(pair, &plane);
            let longest = columns.common(reach_m).map(|(place, _)| place);
            let Some(place) = longest.or_else(|| columns.within(over_m, reach_m)) else { break };
            plane.origin_world += plane.vector_world(place.x, place.y);
            outline = outline.seen_from(place);
            continue;
        };
        let found_world = region.normal_world(&plane, leading);
        let turn = found_world - plane.normal_world;
        // Anderson's method: the turn is taken to be linear between this trial and the one before, and the next normal is where
        // it vanishes.
        let normal_world = match &last {
            Some((_, former, former_found_world, _)) => {
                let change = turn - (*former_found_world - former.normal_world);
                let share = (turn.dot(change) / change.length_squared()).clamp(-1.0, 1.0);
                found_world.lerp(*former_found_world, share)
            }
            None => found_world,
        };
        let center = region.center();
        outline = region.outline.seen_from(center);
        let origin_world = plane.origin_world + plane.vector_world(center.x, center.y);
        let is_settled = turn.length() < ALONG_NORMAL_RAD;
        let next = normal_world.try_normalize().map(|normal_world| plane.turned_to(normal_world));
        last = Some((region, plane, found_world, center));
        match next {
            Some(next) if !is_settled => plane = Plane { origin_world, ..next },
            _ => break,
        }
    }
    let (region, mut plane, found_world, center) = last?;
    // Forces act between the surfaces.
    plane.origin_world += plane.normal_world * region.height_m();
    nodes.extend(region.nodes());
    let turn = found_world - plane.normal_world;
    // Only half the turn: where the normal of the region depends on the direction of its columns, the whole turn may overshoot.
    let next = KnownContact {
        origin_world: plane.origin_world + plane.vector_world(center.x, center.y),
        normal_world: (plane.normal_world + 0.5 * turn).normalize(),
        region: Some((region.outline.seen_from(center), plane.tangents_world[1])),
    };
    Some((if turn.length() < ALONG_NORMAL_RAD { plane.turned_to(found_world) } else { plane }, next))
}

/// How far from the origin of a plane the smaller shape may lie, m.
fn reach_m(pair: &Pair, plane: &Plane) -> f64 {
    let reach = |side: usize| {
        let sphere = pair.shapes[side].compute_bounding_sphere(&parry_pose(&pair.poses_world[side]));
        sphere.radius + sphere.center.distance(plane.origin_world)
    };
    reach(0).min(reach(1))
}
