//! Tests of the law on patches with closed forms, and of the solver.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use nalgebra::Vector3;
use parry3d::shape::SharedShape;
use proptest::prelude::*;
use underbrush_recording::Pose;

use super::chord::Faces;
use super::law::{Law, STICTION_M};
use super::outline::Outline;
use super::patch::{Columns, Node};
use super::plane::Pair;
use super::solver::{ROWS, Solver};
use super::surface::{Interface, Layer};
use crate::physics::Theta;

const LAW: Law = Law {
    interface: Interface { stiffness_n_per_m3: 3e7, layer: Layer::LINEAR, loss_time_s: 0.002, friction: 0.35 },
    step_s: 0.005,
    theta: Theta::EULER,
};

/// The columns of a contact near the origin with a vertical normal. The first shape lies above the second.
fn nodes(first: (SharedShape, Pose), second: (SharedShape, Pose)) -> Vec<Node> {
    let pair = Pair { shapes: [first.0.as_ref(), second.0.as_ref()], poses_world: [first.1, second.1] };
    let mut nodes = Vec::new();
    let mut faces = [Faces::default(), Faces::default()];
    let columns = Columns::new(&pair, &pair.plane(DVec3::ZERO, DVec3::Z), &mut faces).unwrap();
    nodes.extend(columns.region(0.0, &Outline::default()).unwrap().nodes());
    nodes
}

/// The static force of a patch, N.
fn force_n(nodes: &[Node]) -> f64 {
    LAW.normal(nodes, &Vector3::zeros()).impulse[0] / LAW.step_s
}

fn at(height_m: f64) -> Pose {
    Pose::from_position(DVec3::Z * height_m)
}

/// A cylinder about y (as parry's are), rotated by `angle_rad` about the vertical, at this height.
fn lying(radius_m: f64, angle_rad: f64, height_m: f64) -> (SharedShape, Pose) {
    let pose = Pose::new(DVec3::Z * height_m, DQuat::from_rotation_z(angle_rad));
    (SharedShape::cylinder(0.12, radius_m), pose)
}

proptest! {
    /// Tests force against depth for a ball on a plane, k π R d², and for crossed cylinders, k π √(R₁R₂) d² / sin α.
    /// Both are the first term of a series in d / R, and the quadrature of an ellipse is within 0.3 %.
    #[test]
    fn balls_and_crossed_cylinders_press_with_the_closed_form(
        radius_m in 0.01..0.06f64,
        other_m in 0.01..0.06f64,
        depth_m in 1e-5..2e-3f64,
        angle_rad in 0.5..2.6f64,
    ) {
        let table = || (SharedShape::cuboid(0.5, 0.5, 0.1), at(-0.1));
        let ball = nodes((SharedShape::ball(radius_m), at(radius_m - depth_m)), table());
        let expected = LAW.interface.stiffness_n_per_m3 * PI * radius_m * depth_m.powi(2);
        let relative = force_n(&ball) / expected - 1.0;
        prop_assert!(relative.abs() < 5e-3 + depth_m / radius_m, "ball: {relative}");
        let crossed = nodes(lying(radius_m, angle_rad, radius_m - depth_m), lying(other_m, 0.0, -other_m));
        let expected = LAW.interface.stiffness_n_per_m3 * PI * (radius_m * other_m).sqrt() * depth_m.powi(2) / angle_rad.sin();
        let relative = force_n(&crossed) / expected - 1.0;
        let slender = depth_m / radius_m.min(other_m) / angle_rad.sin().powi(2);
        prop_assert!(relative.abs() < 5e-3 + slender, "crossed: {relative}");
    }

    /// Tests a blade of width w across a cylinder, k w (4/3) √(2R) d^1.5, however the blade lies around it, and a flat
    /// box, k d times its area. The first is exact up to the error of a parabola in place of the circle.
    #[test]
    fn blades_and_flats_press_with_the_closed_form(
        radius_m in 0.02..0.06f64,
        depth_m in 1e-5..1e-3f64,
        width_m in 0.002..0.05f64,
        offset_m in -0.02..0.02f64,
    ) {
        let blade = (SharedShape::cuboid(width_m / 2.0, 0.1, 0.001), Pose::from_position(DVec3::new(0.0, offset_m, -0.001)));
        let cylinder = lying(radius_m, std::f64::consts::FRAC_PI_2, radius_m - depth_m);
        let expected = LAW.interface.stiffness_n_per_m3 * width_m * 4.0 / 3.0 * (2.0 * radius_m).sqrt() * depth_m.powf(1.5);
        let relative = force_n(&nodes(cylinder, blade)) / expected - 1.0;
        prop_assert!(relative.abs() < 2e-3 + depth_m / radius_m, "blade: {relative}");
        let flat = nodes(
            (SharedShape::cuboid(width_m / 2.0, 0.03, 0.01), at(0.01 - depth_m)),
            (SharedShape::cuboid(0.5, 0.5, 0.1), at(-0.1)),
        );
        let expected = LAW.interface.stiffness_n_per_m3 * depth_m * width_m * 0.06;
        prop_assert!((force_n(&flat) / expected - 1.0).abs() < 3e-3);
    }

    /// Tests the force of a flat face of radius R that is tilted by θ in any direction and stands on a segment of
    /// height s, with the plane's origin at any place in the segment: k tan θ (2/3 (R² − c²)^1.5 − c A), where c = R −
    /// s and A is the segment's area. The quadrature of a segment is within 1.1 %. The search for the ends of a region
    /// may stop a little before a sharp corner: up to 3 % of the force was missing in 2000 cases.
    #[test]
    fn a_tilted_face_presses_with_its_whole_segment(
        tilt_rad in 0.003..0.02f64,
        azimuth_rad in -3.1..3.1f64,
        share in 0.15..0.6f64,
        aside in -0.6..0.6f64,
    ) {
        let (radius_m, half_height_m) = (0.13, 0.2);
        let height_m = share * radius_m;
        let c = radius_m - height_m;
        let half_chord_m = (radius_m * radius_m - c * c).sqrt();
        // The lowest point is in this direction; the face turns about the other.
        let lowest = DVec3::new(azimuth_rad.cos(), azimuth_rad.sin(), 0.0);
        let axis = DVec3::new(-azimuth_rad.sin(), azimuth_rad.cos(), 0.0);
        let tilt = DQuat::from_axis_angle(axis, tilt_rad);
        let center = -lowest * (c + 0.3 * height_m) - axis * (aside * half_chord_m)
            + DVec3::Z * (radius_m * tilt_rad.sin() - height_m * tilt_rad.tan());
        let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let pose = Pose::new(center + tilt * DVec3::Z * half_height_m, tilt * upright);
        let table = (SharedShape::cuboid(5.0, 5.0, 0.5), at(-0.5));
        let found = force_n(&nodes((SharedShape::cylinder(half_height_m, radius_m), pose), table));
        let area_m2 = radius_m * radius_m * (c / radius_m).acos() - c * half_chord_m;
        let moment = 2.0 / 3.0 * half_chord_m.powi(3) - c * area_m2;
        let expected = LAW.interface.stiffness_n_per_m3 * tilt_rad.tan() * moment;
        prop_assert!((found / expected - 1.0).abs() < 0.06, "{}", found / expected);
    }

    /// Tests the pressure of a layer against the deflections that its parts have under it.
    #[test]
    fn a_layer_gives_way_as_its_parts_do(depth_m in 1e-6..8e-3f64, thickness_m in 1e-3..6e-3f64, linear_share in 0.02..0.9f64) {
        let layer = Layer::new(thickness_m, linear_share);
        let (pressure, _) = layer.pressed(depth_m);
        let deflection = |pressure: f64| {
            let soft = (1.0 - linear_share) * pressure;
            linear_share * pressure + soft / (1.0 + soft / thickness_m)
        };
        prop_assert!((deflection(pressure) / depth_m - 1.0).abs() < 1e-9, "{pressure}");
    }

    /// Tests that the law's stiffness is minus the derivative of its impulse, by central differences, for the normal
    /// part and for friction.
    #[test]
    fn the_stiffness_is_the_slope_of_the_impulse(
        speeds in prop::array::uniform3(-0.1..0.1f64),
        slip in prop::array::uniform3(-0.02..0.02f64),
        deflection in prop::array::uniform3(-6e-6..6e-6f64),
        phase in 0.5..2.5f64,
    ) {
        let interface = Interface { layer: Layer::new(3e-3, 0.1), ..LAW.interface };
        let law = Law { theta: Theta::of_phase(phase, Theta::EULER), interface, ..LAW };
        let nodes = nodes(lying(0.046, 1.3, 0.045), lying(0.015, 0.0, -0.015));
        let deflection = Vector3::from(deflection);
        let slip = Vector3::from(slip);
        let before = Vector3::new(0.004, -0.01, 0.007);
        let normal = |at: &Vector3<f64>| law.normal(&nodes, at);
        let friction = |at: &Vector3<f64>| law.friction(&deflection, 0.01, &before, at);
        // The normal impulse has kinks where a column begins to press, which the differences must not straddle.
        let speeds = Vector3::new(speeds[0], 3.0 * speeds[1], 3.0 * speeds[2]);
        let step = 1e-7;
        for axis in 0..3 {
            let change = Vector3::from_fn(|row, _| if row == axis { step } else { 0.0 });
            let [above, below] = [speeds + change, speeds - change].map(|speeds| normal(&speeds));
            // Between kinks the stiffness changes little.
            if (above.stiffness - below.stiffness).norm() < 1e-5 * above.stiffness.norm() {
                let slope = (above.impulse - below.impulse) / (-2.0 * step);
                let own = normal(&speeds).stiffness.column(axis).into_owned();
                prop_assert!((slope - own).norm() <= 1e-4 * normal(&speeds).stiffness.norm() + 1e-9);
            }
            let slope = (friction(&(slip + change)).impulse - friction(&(slip - change)).impulse) / (-2.0 * step);
            let own = friction(&slip).stiffness.column(axis).into_owned();
            prop_assert!((slope - own).norm() <= 1e-3 * friction(&slip).stiffness.norm());
        }
    }

    /// Tests Coulomb's law for a sliding block with any mass matrix: the solver's friction opposes the slip at the end
    /// of the step to 5e-5 rad, and is μ times the normal force to 1e-5, whatever the coupling between the tangents.
    #[test]
    fn friction_opposes_the_slip_for_any_mass_matrix(
        entries in prop::array::uniform9(-1.0..1.0f64),
        push in prop::array::uniform2(-1.0..1.0f64),
    ) {
        let root = nalgebra::Matrix3::from_row_slice(&entries);
        let mass = root * root.transpose() + nalgebra::Matrix3::identity() * 0.2;
        let free = [push[0] * 2.0, push[1] * 2.0, -0.3];
        prop_assume!(push[0].hypot(push[1]) > 0.5);
        let table = (SharedShape::cuboid(0.5, 0.5, 0.1), at(-0.1));
        let nodes = nodes((SharedShape::ball(0.05), at(0.049)), table);
        let mut solver = Solver::default();
        solver.start(LAW.step_s);
        let block = solver.add_block(free.into_iter(), free.into_iter(), |row, column| mass[(row, column)]);
        let patch = solver.add_patch(LAW, &nodes, Vector3::zeros());
        // Velocities are (tangent, tangent, normal).
        let mut columns = [[0.0; ROWS]; 3];
        (columns[0][3], columns[1][4], columns[2][0]) = (1.0, 1.0, 1.0);
        solver.add_side(patch, 0, block).copy_from_slice(&columns);
        let convergence = solver.solve();
        prop_assert!(convergence.residual < 1e-6, "{convergence:?}");
        let solved = &solver.patches[patch];
        let (slip, force) = (solved.speeds().1, solved.friction.impulse);
        if slip.norm() * LAW.step_s > STICTION_M {
            let cosine = -force.dot(&slip) / (force.norm() * slip.norm());
            prop_assert!(cosine > 1.0 - 1e-9, "{cosine}");
            prop_assert!((force.norm() / (LAW.interface.friction * solved.normal.impulse[0]) - 1.0).abs() < 1e-5);
        }
        // The impulses add up to the change of momentum.
        let after = solver.velocity(block).iter();
        let change: Vec<f64> = after.zip(free).map(|(after, free)| after - free).collect();
        let momentum = mass * Vector3::from_row_slice(&change);
        let impulse = Vector3::new(force[0], force[1], solved.normal.impulse[0]);
        prop_assert!((momentum - impulse).norm() < 3e-6 * impulse.norm());
    }
}

/// Tests that a patch which sticks does not creep: under a steady push below the friction limit the displacement stays
/// within the stiction distance for ten thousand steps.
#[test]
fn a_patch_that_sticks_does_not_creep() {
    let nodes = nodes((SharedShape::ball(0.05), at(0.049)), (SharedShape::cuboid(0.5, 0.5, 0.1), at(-0.1)));
    let weight_n = force_n(&nodes);
    let mass = 1.0;
    let mut deflection = Vector3::zeros();
    let (mut velocity, mut place) = (0.0, 0.0);
    for _ in 0..10_000 {
        let mut solver = Solver::default();
        solver.start(LAW.step_s);
        // The overlap is held; a push of 0.9 of the limit acts along the first tangent.
        let free = velocity + LAW.step_s * 0.9 * LAW.interface.friction * weight_n / mass;
        let block = solver.add_block(std::iter::once(velocity), std::iter::once(free), |_, _| mass);
        let patch = solver.add_patch(LAW, &nodes, deflection);
        let mut column = [0.0; ROWS];
        column[3] = 1.0;
        solver.add_side(patch, 0, block)[0] = column;
        solver.solve();
        velocity = solver.velocity(block)[0];
        place += velocity * LAW.step_s;
        deflection = solver.patches[patch].deflection_after_m();
    }
    assert!(place.abs() < STICTION_M, "crept by {place} m");
}

/// Tests that the solver leaves an unstable solution for a stable one, even if it starts near the unstable one and
/// therefore needs hundreds of iterations. A body slides while its friction presses it into the other: N = K (h − r v),
/// with v = v* + (a − μ b) N as long as it slides. If 1 + K r (a − μ b) is negative, there are three solutions: the
/// body parts (N = 0), it slides (unstable), or it sticks, where slip = 0 gives N = K (h − r (v* − b s*/d)) / (1 + K r
/// (a − b²/d)).
#[test]
fn the_solver_leaves_an_unstable_solution_for_a_stable_one() {
    let (a, b, d) = (100.0, 322.0, 1500.0);
    let (free_parting, free_slip) = (0.15, 1.0);
    let node = Node { area_m2: 1e-4, overlap_m: 1e-3, ..Node::default() };
    let rate = LAW.step_s + LAW.interface.loss_time_s;
    let modulus = LAW.step_s * LAW.interface.stiffness_n_per_m3 * node.area_m2;
    let friction = LAW.interface.friction;
    let pressed = modulus * (node.overlap_m - rate * free_parting);
    let sliding = pressed / (1.0 + modulus * rate * (a - friction * b));
    // A patch that sticks still gives way by the stiction distance within the step, so its slip is not quite 0.
    let sticking_at =
        |slip: f64| (pressed + modulus * rate * b * (free_slip - slip) / d) / (1.0 + modulus * rate * (a - b * b / d));
    let mass = nalgebra::Matrix2::new(a, b, b, d).try_inverse().unwrap();
    let solve_from = |normal: f64| {
        let start = [free_parting + (a - friction * b) * normal, free_slip + (b - friction * d) * normal];
        let mut solver = Solver::default();
        solver.start(LAW.step_s);
        let free = [free_parting, free_slip];
        let block = solver.add_block(start.into_iter(), free.into_iter(), |row, column| mass[(row, column)]);
        let patch = solver.add_patch(LAW, &[node], Vector3::zeros());
        let mut columns = [[0.0; ROWS]; 2];
        (columns[0][0], columns[1][3]) = (1.0, 1.0);
        solver.add_side(patch, 0, block).copy_from_slice(&columns);
        let convergence = solver.solve();
        assert!(convergence.residual <= 1e-6, "{convergence:?}");
        assert!(convergence.iterations > 200, "{convergence:?}");
        solver.patches.swap_remove(patch)
    };
    assert_eq!(solve_from(0.999 * sliding).normal.impulse[0], 0.0);
    let stuck = solve_from(1.001 * sliding);
    let range = sticking_at(STICTION_M / LAW.step_s)..sticking_at(0.0);
    assert!(range.contains(&stuck.normal.impulse[0]), "{stuck:?}");
    assert!(stuck.friction.impulse.norm() < friction * stuck.normal.impulse[0]);
}

fn shape(kind: u8, size: [f64; 3]) -> SharedShape {
    let [x, y, z] = size;
    match kind {
        0 => SharedShape::cuboid(x, y, z),
        1 => SharedShape::cylinder(y, x),
        2 => SharedShape::capsule_y(y, x),
        _ => SharedShape::ball(x),
    }
}

proptest! {
    /// Tests that two shapes have a common column exactly if parry finds that they overlap, in any direction of the
    /// columns, unless they only graze.
    #[test]
    fn common_columns_are_found_where_shapes_overlap(
        kinds in prop::array::uniform2(0u8..4),
        sizes in prop::array::uniform2(prop::array::uniform3(0.01..0.05f64)),
        place in prop::array::uniform3(-0.06..0.06f64),
        turns in prop::array::uniform2(prop::array::uniform3(-2.0..2.0f64)),
        normal in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let shapes = [0, 1].map(|side| shape(kinds[side], sizes[side]));
        let [first, second] = turns.map(|turn| DQuat::from_scaled_axis(DVec3::from_array(turn)));
        let pair = Pair {
            shapes: [shapes[0].as_ref(), shapes[1].as_ref()],
            poses_world: [Pose::new(DVec3::ZERO, first), Pose::new(DVec3::from_array(place), second)],
        };
        let depth_m = {
            let [one, other] = pair.poses_world.each_ref().map(crate::geometry::parry_pose);
            let found = parry3d::query::contact(&one, pair.shapes[0], &other, pair.shapes[1], 1.0);
            found.unwrap().map_or(-1.0, |contact| -contact.dist)
        };
        prop_assume!(depth_m.abs() > 1e-4);
        let normal = DVec3::from_array(normal).try_normalize().unwrap_or(DVec3::Z);
        let mut faces = [Faces::default(), Faces::default()];
        let plane = pair.plane(DVec3::from_array(place), normal);
        let common = Columns::new(&pair, &plane, &mut faces).unwrap().common(0.1);
        prop_assert_eq!(common.is_some(), depth_m > 0.0, "depth {} m", depth_m);
    }
}
