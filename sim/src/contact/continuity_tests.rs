//! Tests that a contact is followed, and that its force is continuous, along straight paths of random pairs of shapes.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use parry3d::query;
use parry3d::shape::SharedShape;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use underbrush_recording::Pose;

use super::chord::Faces;
use super::plane::{DepthSearch, Pair};
use super::settle::{KnownContact, settle};
use crate::geometry::parry_pose;

const MODULUS_N_PER_M3: f64 = 3e7;
const STEP_M: f64 = 5e-5;
/// Paths end at this overlap, m.
const DEEPEST_M: f64 = 0.003;
/// What a step may change beyond the law's own modulus × area × step: the normal turns, too.
const LIPSCHITZ: f64 = 5.0;
/// Ends of patches are found to 1e-3, so small forces change by more than their share.
const RESOLUTION_N: f64 = 1e-3;

/// A direction or a turn about it, with equal density in the cube: any will do.
fn random_direction(rng: &mut ChaCha8Rng) -> DVec3 {
    let mut part = || rng.random_range(-1.0..1.0);
    DVec3::new(part(), part(), part()).try_normalize().unwrap_or(DVec3::X)
}

/// A pair of shapes that meet with rims, edges, corners and faces: blades on cylinders, boxes, two blades, hull and capsule.
fn random_shapes(kind: usize, rng: &mut ChaCha8Rng) -> [SharedShape; 2] {
    match kind {
        0 => [SharedShape::cuboid(0.0005, 0.0186, 0.02), SharedShape::cylinder(0.1185, 0.046)],
        1 => [SharedShape::cuboid(0.012, 0.0186, 0.02), SharedShape::cuboid(0.02, 0.03, 0.05)],
        2 => [SharedShape::cuboid(0.0005, 0.018, 0.05), SharedShape::cuboid(0.0005, 0.015, 0.05)],
        3 => [SharedShape::cuboid(0.0005, 0.0186, 0.04), SharedShape::cylinder(0.15, 0.015)],
        _ => {
            let half = DVec3::new(0.03, 0.02, 0.05);
            let mut part = || rng.random_range(-1.0..1.0);
            let points: Vec<DVec3> = (0..14).map(|_| half * DVec3::new(part(), part(), part())).collect();
            [SharedShape::convex_hull(&points).unwrap(), SharedShape::capsule_y(0.08, 0.03)]
        }
    }
}

/// What was counted along the paths.
#[derive(Debug, Default)]
struct Counted {
    steps: usize,
    /// Steps with an overlap of more than 0.1 mm for which no patch was found.
    lost: usize,
    /// Steps in which the force changed by more than the bound, and those of them before an overlap of a millimetre.
    jumps: usize,
    shallow_jumps: usize,
}

/// Moves the first shape along a random straight line into the second, and follows their contact.
fn follow(path: u64, counted: &mut Counted) {
    let mut rng = ChaCha8Rng::seed_from_u64(path);
    let shapes = random_shapes(path as usize % 5, &mut rng);
    let [turn, other_turn] = [0, 1].map(|_| {
        let axis = random_direction(&mut rng);
        DQuat::from_axis_angle(axis, rng.random_range(0.0..PI))
    });
    let mut part = || rng.random_range(-1.0..1.0);
    let target = other_turn * (DVec3::new(part(), part(), part()) * shapes[1].compute_local_aabb().half_extents());
    let way = -(target + random_direction(&mut rng) * (0.5 * target.length())).normalize();
    let pair_at = |along_m: f64| Pair {
        shapes: shapes.each_ref().map(AsRef::as_ref),
        poses_world: [Pose::new(target + way * along_m, turn), Pose::new(DVec3::ZERO, other_turn)],
    };
    let depth_m = |along_m: f64| {
        let pair = pair_at(along_m);
        let [first, second] = pair.poses_world.each_ref().map(parry_pose);
        let found = query::contact(&first, pair.shapes[0], &second, pair.shapes[1], 1.0).unwrap();
        found.map_or(-1.0, |contact| -contact.dist)
    };
    let Some(meets) = (0..200).map(|step| -0.3 + 0.004 * f64::from(step)).find(|along_m| depth_m(*along_m) >= 0.0)
    else {
        return;
    };
    let (mut apart, mut overlap) = (meets - 0.004, meets);
    while overlap - apart > 1e-9 {
        let middle = 0.5 * (apart + overlap);
        *(if depth_m(middle) < 0.0 { &mut apart } else { &mut overlap }) = middle;
    }
    let mut faces = [Faces::default(), Faces::default()];
    let mut known: Option<KnownContact> = None;
    let (mut force_before, mut area_before) = (DVec3::ZERO, 0.0);
    for step in 0..200 {
        let along_m = apart + f64::from(step) * STEP_M;
        let depth_m = depth_m(along_m);
        if depth_m > DEEPEST_M {
            break;
        }
        let pair = pair_at(along_m);
        let known_or_nearest = known.or_else(|| {
            let (normal_world, middle_world) = pair.nearest(0.005, &mut DepthSearch::default())?;
            Some(KnownContact { origin_world: middle_world?, normal_world, region: None })
        });
        let mut nodes = Vec::new();
        let found = known_or_nearest.and_then(|from| settle(&pair, &from, &mut faces, |_, _| 0.0, &mut nodes));
        let area: f64 = nodes.iter().map(|node| node.area_m2).sum();
        let volume: f64 = nodes.iter().map(|node| node.area_m2 * node.overlap_m).sum();
        let force = found.map_or(DVec3::ZERO, |(plane, _)| plane.normal_world * (MODULUS_N_PER_M3 * volume));
        let allowed = RESOLUTION_N + LIPSCHITZ * MODULUS_N_PER_M3 * area.max(area_before) * STEP_M;
        let jumps = force.distance(force_before) > allowed;
        counted.steps += 1;
        counted.lost += usize::from(found.is_none() && depth_m > 1e-4);
        counted.jumps += usize::from(jumps);
        counted.shallow_jumps += usize::from(jumps && depth_m < 1e-3);
        (force_before, area_before) = (force, area);
        known = found.map(|(_, next)| next);
    }
}

/// Tests that no contact is lost on the way to an overlap of 3 mm, that its force does not jump before 1 mm, and that it
/// jumps in at most one of a thousand steps beyond. Such jumps remain where a blade is cut through by an edge.
#[test]
fn contacts_are_followed_with_a_continuous_force() {
    let mut counted = Counted::default();
    for path in 0..1000 {
        follow(path, &mut counted);
    }
    assert!(counted.steps > 50_000, "{counted:?}");
    assert_eq!((counted.lost, counted.shallow_jumps), (0, 0), "{counted:?}");
    assert!(counted.jumps * 1000 <= counted.steps, "{counted:?}");
}
