//! Tests that a contact is followed, and how seldom its force jumps, along straight paths of random pairs of shapes.

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
/// Where bands of the overlap end, m.
const BANDS_M: [f64; 4] = [0.001, 0.003, 0.008, 0.01];
/// What a step may change beyond the law's own modulus × area × step: the normal turns, too.
const LIPSCHITZ: f64 = 5.0;
/// Ends of patches are found to 1e-3, so small forces change by more than their share.
const RESOLUTION_N: f64 = 1e-3;

/// A direction or a turn about it, with equal density in the cube: any will do.
fn random_direction(rng: &mut ChaCha8Rng) -> DVec3 {
    let mut part = || rng.random_range(-1.0..1.0);
    DVec3::new(part(), part(), part()).try_normalize().unwrap_or(DVec3::X)
}

/// The kinds of pairs, which meet with rims, edges, corners and faces.
const KINDS: [&str; 5] = ["blade, forearm", "box, box", "blade, blade", "blade, post", "hull, capsule"];

/// A pair of shapes of a kind.
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

/// What was counted along the paths in a band of the overlap.
#[derive(Clone, Copy, Debug, Default)]
struct Counted {
    steps: usize,
    /// Steps with an overlap of more than 0.1 mm for which no patch was found.
    lost: usize,
    /// Steps in which the force changed by more than the bound.
    jumps: usize,
    /// Steps in which the contact was also searched anew, and those in which this gave a force that differs by more than a tenth.
    compared: usize,
    differ: usize,
}

/// Moves the first shape along a random straight line into the second, up to an overlap of `deepest_m`, and follows their contact.
fn follow(path: u64, deepest_m: f64, counted: &mut [Counted; BANDS_M.len()]) {
    let mut rng = ChaCha8Rng::seed_from_u64(path);
    let shapes = random_shapes(path as usize % KINDS.len(), &mut rng);
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
        if depth_m > deepest_m {
            break;
        }
        let pair = pair_at(along_m);
        let nearest = || {
            let (normal_world, middle_world) = pair.nearest(0.005, &mut DepthSearch::default())?;
            Some(KnownContact { origin_world: middle_world?, normal_world, region: None })
        };
        // The force, the area of the patch, and where the next step looks for it.
        let mut press = |from: Option<KnownContact>| {
            let mut nodes = Vec::new();
            let found = from.and_then(|from| settle(&pair, &from, &mut faces, |_, _| 0.0, &mut nodes));
            let area: f64 = nodes.iter().map(|node| node.area_m2).sum();
            let volume: f64 = nodes.iter().map(|node| node.area_m2 * node.overlap_m).sum();
            let force = found.map_or(DVec3::ZERO, |(plane, _)| plane.normal_world * (MODULUS_N_PER_M3 * volume));
            (force, area, found.map(|(_, next)| next))
        };
        let (force, area, next) = press(known.or_else(nearest));
        let allowed = RESOLUTION_N + LIPSCHITZ * MODULUS_N_PER_M3 * area.max(area_before) * STEP_M;
        let band = &mut counted[BANDS_M.partition_point(|end_m| *end_m < depth_m)];
        band.steps += 1;
        band.lost += usize::from(next.is_none() && depth_m > 1e-4);
        band.jumps += usize::from(force.distance(force_before) > allowed);
        if step % 10 == 9 {
            let (fresh, ..) = press(nearest());
            band.compared += 1;
            band.differ += usize::from(fresh.distance(force) > RESOLUTION_N + 0.1 * force.length());
        }
        (force_before, area_before, known) = (force, area, next);
    }
}

/// Tests that no contact is lost on the way to an overlap of 3 mm, that its force does not jump before 1 mm, and that it
/// jumps in at most one of a thousand steps. Jumps remain where an edge of the shape that gives the normal lies in the patch.
#[test]
fn contacts_are_followed_with_a_continuous_force() {
    let mut counted = Default::default();
    for path in 0..1000 {
        follow(path, 0.003, &mut counted);
    }
    let sum = |count: fn(&Counted) -> usize| counted.iter().map(count).sum::<usize>();
    let steps = sum(|band| band.steps);
    assert!(steps > 50_000, "{counted:?}");
    assert_eq!((sum(|band| band.lost), counted[0].jumps), (0, 0), "{counted:?}");
    assert!(sum(|band| band.jumps) * 1000 <= steps, "{counted:?}");
}

/// Prints the table of docs/evidence/physics.md: what is counted along 10,000 paths up to an overlap of 10 mm.
#[test]
#[ignore = "takes minutes and prints a table"]
#[expect(clippy::print_stdout, reason = "the table is what it is for")]
fn jumps_of_the_force_up_to_10_mm() {
    for (kind, name) in KINDS.iter().enumerate() {
        let mut counted = [Counted::default(); BANDS_M.len()];
        for path in (kind..10_000).step_by(KINDS.len()) {
            follow(path as u64, 0.01, &mut counted);
        }
        let jumps = counted.map(|Counted { steps, jumps, .. }| format!("{jumps} of {steps}"));
        let percent = |Counted { differ, compared, .. }| format!("{:.1}", 100.0 * differ as f64 / compared as f64);
        let lost: usize = counted.iter().map(|band| band.lost).sum();
        println!("| {name} | {} | {lost} | {} |", jumps.join(" | "), counted.map(percent).join(", "));
    }
}
