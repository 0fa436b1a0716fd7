//! Tests of joint trees against mechanics. The check `joint-trees` of `validate` compares them with Rapier's.

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use underbrush_recording::Pose;

use super::{Coordinate, Link, Tree};
use crate::object::Object;
use crate::object::leaf::Leaf;
use crate::object::structure::{Axis, Spring};
use crate::physics::Theta;

const GRAVITY_M_PER_S2: f64 = 9.81;

/// Kinetic energy of the links, J.
fn kinetic_energy_j(tree: &Tree) -> f64 {
    let links = (1..tree.links().len()).map(|index| {
        let link = &tree.links()[index];
        let center = tree.center_of_mass_world(index);
        let [[linear, angular]] = tree.velocities_at(index, center, |at| [tree.coordinates[at].velocity]);
        let angular_link = link.pose_world.inverse_transform_vector(angular);
        link.mass_kg * linear.length_squared() + angular_link.dot(link.inertia_link * angular_link)
    });
    0.5 * links.sum::<f64>()
}

/// Energy of the links in the field of gravity, J.
fn potential_energy_j(tree: &Tree) -> f64 {
    let heights = (1..tree.links().len()).map(|link| tree.links()[link].mass_kg * tree.center_of_mass_world(link).z);
    GRAVITY_M_PER_S2 * heights.sum::<f64>()
}

fn hinge(axis_joint: DVec3) -> Coordinate {
    Coordinate::new(Axis::about(axis_joint), Spring::elastic(0.0, 0.0))
}

/// Two rods of 1 kg and 0.5 m that hang on hinges with axes at right angles.
fn double_pendulum() -> Tree {
    let mut tree = Tree::new(Pose::IDENTITY, true);
    for (parent, axis) in [(0, DVec3::X), (1, DVec3::Y)] {
        let joint_parent = Pose::from_position(if parent == 0 { DVec3::ZERO } else { DVec3::Z * -0.5 });
        let link = Link {
            mass_kg: 1.0,
            center_of_mass_link: DVec3::Z * -0.25,
            inertia_link: DMat3::from_diagonal(DVec3::new(0.021, 0.021, 0.001)),
            ..Link::new(parent, joint_parent)
        };
        tree.add(link, [hinge(axis)]);
    }
    tree
}

/// Tests that a spatial double pendulum keeps its energy: the error of semi-implicit Euler is proportional to the step.
#[test]
fn a_double_pendulum_keeps_its_energy() {
    let drift_j = |step_s: f64| {
        let mut tree = double_pendulum();
        tree.coordinates[0].position = 1.2;
        tree.coordinates[1].position = 0.7;
        tree.place();
        let energy = |tree: &Tree| kinetic_energy_j(tree) + potential_energy_j(tree);
        let start = energy(&tree);
        let mut worst = 0.0_f64;
        for _ in 0..(1.0 / step_s) as usize {
            tree.begin(step_s, Theta::EULER);
            tree.prepare(GRAVITY_M_PER_S2);
            tree.advance();
            worst = worst.max((energy(&tree) - start).abs());
        }
        worst
    };
    let [coarse, fine] = [1e-4, 5e-5].map(drift_j);
    // The pendulum exchanges some 5 J.
    assert!(coarse < 1e-2, "{coarse} J");
    assert!((coarse / fine - 2.0).abs() < 0.1, "{coarse} J, {fine} J");
}

/// Tests the mass matrix through the kinetic energy ½ q̇ᵀ M q̇ of the links, without springs and dampers.
#[test]
fn the_mass_matrix_gives_the_kinetic_energy() {
    let mut tree = double_pendulum();
    for (own, (position, velocity)) in tree.coordinates.iter_mut().zip([(0.8, 1.3), (-0.5, -2.1)]) {
        (own.position, own.velocity) = (position, velocity);
    }
    tree.place();
    tree.begin(1e-3, Theta::EULER);
    tree.prepare(0.0);
    let speeds: Vec<f64> = tree.coordinates.iter().map(|own| own.velocity).collect();
    let speeds = DVector::from_vec(speeds);
    let found = 0.5 * speeds.dot(&(mass(&tree, &[0, 1]) * &speeds));
    assert!((found / kinetic_energy_j(&tree) - 1.0).abs() < 1e-13);
}

/// The symmetric matrix of [`Tree::mass_of`].
fn mass(tree: &Tree, coordinates: &[usize]) -> DMatrix<f64> {
    let (size, mut lower) = (coordinates.len(), Vec::new());
    tree.mass_of(coordinates, &mut lower);
    DMatrix::from_fn(size, size, |row, column| lower[row.max(column) * size + row.min(column)])
}

/// A shrub: a stem of two rods, on which two twigs of two rods stand, each on hinges across and along it, with springs.
fn shrub() -> Tree {
    let mut tree = Tree::new(Pose::IDENTITY, true);
    for (link, parent) in [0, 1, 2, 3, 2, 5].into_iter().enumerate() {
        let rod = Link {
            mass_kg: 0.1 + 0.01 * link as f64,
            center_of_mass_link: DVec3::new(0.005, 0.0, 0.05),
            inertia_link: DMat3::from_diagonal(DVec3::new(3e-4, 4e-4, 1e-4)),
            ..Link::new(parent, Pose::from_position(DVec3::new(0.01 * link as f64, -0.02, 0.1)))
        };
        let axes = [DVec3::X, DVec3::Z].map(|axis| Coordinate::new(Axis::about(axis), Spring::elastic(0.3, 0.002)));
        tree.add(rod, axes);
    }
    for (at, own) in tree.coordinates.iter_mut().enumerate() {
        (own.position, own.velocity) = (0.1 * at as f64 - 0.4, 0.5 - 0.2 * at as f64);
    }
    tree.place();
    tree.begin(5e-3, Theta::MIDPOINT);
    tree.prepare(GRAVITY_M_PER_S2);
    tree
}

/// Tests the mass that some coordinates feel, and how the others follow, against nalgebra's solution of the whole equations
/// of motion. A generalized force acts on the stem and on the first rod of one twig.
#[test]
fn coordinates_that_nothing_acts_on_follow_the_others() {
    let mut tree = shrub();
    let (all, unknowns): (Vec<usize>, _) = ((0..12).collect(), [0, 1, 2, 3, 8, 9]);
    let force = DVector::from_fn(12, |at, _| if unknowns.contains(&at) { 0.2 - 0.03 * at as f64 } else { 0.0 });
    let whole = mass(&tree, &all).lu().solve(&force).unwrap();
    let own_force = DVector::from_iterator(6, unknowns.iter().map(|at| force[*at]));
    let own = mass(&tree, &unknowns).lu().solve(&own_force).unwrap();
    let free = tree.next().to_vec();
    tree.set_next(|at| unknowns.iter().position(|own| *own == at).map(|place| free[at] + own[place]));
    for at in all {
        let change = tree.next()[at] - free[at];
        assert!((change - whole[at]).abs() < 1e-10 * whole.amax(), "coordinate {at}: {change}, not {}", whole[at]);
    }
}

/// A free body of 2 kg, which may be weightless.
fn free_body(weighs: bool) -> Tree {
    let mut tree = Tree::new(Pose::IDENTITY, weighs);
    let slide = |axis_joint| Coordinate::new(Axis::along(axis_joint), Spring::elastic(0.0, 0.0));
    let link = Link {
        mass_kg: 2.0,
        center_of_mass_link: DVec3::ZERO,
        inertia_link: DMat3::from_diagonal(DVec3::new(0.01, 0.02, 0.025)),
        ..Link::new(0, Pose::IDENTITY)
    };
    let axes = DVec3::AXES.map(slide).into_iter().chain(DVec3::AXES.map(hinge));
    tree.add(link, axes);
    tree
}

/// The angular momentum of a free body, N m s, world frame.
fn angular_momentum(tree: &Tree) -> DVec3 {
    let link = &tree.links()[1];
    let [[_, angular]] = tree.velocities_at(1, link.pose_world.position, |at| [tree.coordinates[at].velocity]);
    let angular_link = link.pose_world.inverse_transform_vector(angular);
    link.pose_world.transform_vector(link.inertia_link * angular_link)
}

fn turn(tree: &mut Tree, rates_rad_per_s: [f64; 3]) {
    for (own, speed) in tree.coordinates[3..].iter_mut().zip(rates_rad_per_s) {
        own.velocity = speed;
    }
}

/// Tests that a weightless body that tumbles at up to 20 rad/s keeps its energy and angular momentum over 10 s, at the default step and
/// at a short one. One step of second order errs by some (ω Δt)³ / 12 of the motion, 1e-4 at 20 rad/s, which partly cancels from turn to turn.
#[test]
fn a_tumbling_body_keeps_its_energy() {
    for (rate, step_s, tolerance) in [(1.0, 5e-3, 1e-2), (5.0, 5e-3, 1e-3), (20.0, 5e-3, 2e-2), (5.0, 1e-3, 1e-4)] {
        let mut tree = free_body(false);
        turn(&mut tree, [0.3, 1.0, 0.2].map(|share| rate * share));
        let (energy_j, momentum) = (kinetic_energy_j(&tree), angular_momentum(&tree));
        for _ in 0..f64::round(10.0 / step_s) as usize {
            tree.begin(step_s, Theta::MIDPOINT);
            tree.prepare(0.0);
            tree.advance();
        }
        let change = kinetic_energy_j(&tree) / energy_j - 1.0;
        assert!(change.abs() < tolerance, "{rate} rad/s in steps of {step_s} s: energy {change}");
        let change = angular_momentum(&tree).distance(momentum) / momentum.length();
        assert!(change < tolerance, "{rate} rad/s in steps of {step_s} s: angular momentum {change}");
    }
}

/// Tests a free body: it falls with g t²/2, to the first order of the step, and keeps its angular momentum while it
/// tumbles.
#[test]
fn a_free_body_falls_and_tumbles() {
    let mut tree = free_body(true);
    turn(&mut tree, [1.0, 3.0, -2.0]);
    let (start, step_s) = (angular_momentum(&tree), 1e-5);
    for _ in 0..50_000 {
        tree.begin(step_s, Theta::EULER);
        tree.prepare(GRAVITY_M_PER_S2);
        tree.advance();
    }
    let fallen_m = -tree.links()[1].pose_world.position.z;
    assert!((fallen_m / (0.125 * GRAVITY_M_PER_S2) - 1.0).abs() < 3.0 * step_s, "{fallen_m} m");
    let end = angular_momentum(&tree);
    assert!(end.distance(start) < 1e-3 * start.length(), "{end} {start}");
}

proptest! {
    /// Tests that leaves that are flung at up to 1,000 rad/s in every joint, some as light as film, come to rest: steps of 5 ms do not
    /// resolve such speeds.
    #[test]
    fn a_leaf_that_is_flung_comes_to_rest(
        speeds in prop::collection::vec(-1000.0..1000.0f64, 9),
        mass_per_area_kg_per_m2 in 0.03..1.0f64,
        flexural_rigidity_n_m2 in 0.005..0.05f64,
    ) {
        let leaf = Leaf {
            height_m: 0.3,
            width_m: 0.05,
            flexural_rigidity_n_m2,
            torsion_over_bending: 1.5,
            mass_per_area_kg_per_m2,
            loss_factor: 0.1,
            yield_moment_nm: None,
            root_stiffness_nm_per_rad: Some(2.0),
            grip: None,
            segments: 4,
        };
        let mut tree = Tree::of_structure(&leaf.structure(9.81), Pose::IDENTITY);
        prop_assert_eq!(tree.coordinates.len(), speeds.len());
        for (own, speed) in tree.coordinates.iter_mut().zip(&speeds) {
            own.velocity = *speed;
        }
        for _ in 0..1000 {
            let theta = tree.own_theta(0.005);
            tree.begin(0.005, theta);
            tree.prepare(GRAVITY_M_PER_S2);
            tree.advance();
        }
        let fastest = tree.coordinates.iter().map(|own| own.velocity.abs()).reduce(f64::max);
        prop_assert!(fastest < Some(5.0), "{:?}", tree.coordinates.iter().map(|own| own.velocity).collect::<Vec<_>>());
    }
}
