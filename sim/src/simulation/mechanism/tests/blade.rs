//! Tests of blades and plants in the engine against closed forms.

use glam::{DQuat, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{pose, step_pushed};
use crate::object::Footing;
use crate::object::Group;
use crate::object::blade::{Blade, SHEET_TORSION_OVER_BENDING};
use crate::object::plant::Plant;
use crate::object::structure::{Axis, Body, Drag, Inertia, Joint, Spring, Structure};
use crate::simulation::engine::Engine;
use crate::simulation::mechanism::Mechanism;
use crate::{PhysicsOptions, Surface};

const OPTIONS: PhysicsOptions = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };

fn blade(segments: u32) -> Blade {
    Blade {
        length_m: 0.3,
        width_m: 0.03,
        flexural_rigidity_n_m2: 0.02,
        torsional_rigidity_n_m2: 0.02 * SHEET_TORSION_OVER_BENDING,
        mass_per_area_kg_per_m2: 0.8,
        // Heavily damped, so that the static state is reached soon.
        loss_factor: 1.0,
        yield_moment_nm: None,
        segments,
    }
}

/// A clamped blade; its base is turned by this angle about y.
fn clamped(blade: &Blade, turned_rad: f64, engine: &mut Engine) -> Mechanism {
    clamped_with(blade, turned_rad, |_| None, engine)
}

/// The same with a body that is fixed to the last piece; `weight` is given the joint at its tip.
fn clamped_with(
    blade: &Blade,
    turned_rad: f64,
    weight: impl Fn(Joint) -> Option<Body>,
    engine: &mut Engine,
) -> Mechanism {
    let hinges = blade.hinges();
    let base = Body {
        joint: Some(Joint {
            orientation_parent: DQuat::from_rotation_y(turned_rad),
            ..Joint::parallel(0, DVec3::Z * 0.5, Vec::new())
        }),
        ..blade.piece(0.0, hinges[0].place_m)
    };
    let mut bodies = vec![Body::foot(), base];
    blade.grow(&hinges, blade.length_m, 0.0, &mut bodies);
    let tip_body = DVec3::Z * (blade.length_m - hinges[hinges.len() - 1].place_m);
    bodies.extend(weight(Joint::parallel(bodies.len() - 1, tip_body, Vec::new())));
    let structure = Structure { bodies, axisymmetric: false, surface: Surface::hard(0.4) };
    Mechanism::build(&structure, engine, DVec3::ZERO, 0.0)
}

/// A body on one hinge about y.
fn hinge(spring: Spring, engine: &mut Engine) -> Mechanism {
    let body = Body {
        joint: Some(Joint::parallel(0, DVec3::ZERO, vec![(Axis::about(DVec3::Y), spring)])),
        inertia: Inertia::of_box(0.01, DVec3::Z * 0.1, DVec3::splat(0.02)),
        ..Body::foot()
    };
    let structure = Structure { bodies: vec![Body::foot(), body], axisymmetric: false, surface: Surface::hard(0.4) };
    Mechanism::build(&structure, engine, DVec3::ZERO, 0.0)
}

/// Tests that a torque T at place a twists a blade by T a / (G J). The hinges make steps of it, each as high as its weight
/// in the quadrature; at places that share the length as the weights do, the steps meet the line.
#[test]
fn a_torque_twists_up_to_where_it_acts() {
    let blade = blade(4);
    let torque_nm = 1e-3;
    // Sums of the weights of Gauss-Legendre quadrature with four nodes.
    for (pieces, share) in [(1, 0.173_927_422_568_727), (2, 0.5), (3, 0.826_072_577_431_273), (4, 1.0)] {
        let mut engine = Engine::new(PhysicsOptions { gravity_m_per_s2: 0.0, ..OPTIONS });
        let mechanism = clamped(&blade, 0.0, &mut engine);
        let link = 1 + pieces;
        for _ in 0..2000 {
            let tree = engine.scene.tree_mut(mechanism.slot);
            tree.push(link, DVec3::ZERO, DVec3::ZERO, DVec3::Z * torque_nm);
            engine.step();
        }
        let turned = pose(&engine, mechanism, link).transform_vector(DVec3::Y);
        let expected = torque_nm * share * blade.length_m / blade.torsional_rigidity_n_m2;
        assert!(((-turned.x).asin() / expected - 1.0).abs() < 1e-4, "{turned} {expected}");
    }
}

/// Tests the motion in which a blade bends and twists at once: a point mass m beside its tip, at a distance e along its width,
/// swings at ω² = 1 / (m (L³ / 3 E I + e² L / G J)), as bending and twist give way one after the other. The blade's own mass
/// adds 33/140 of it to m. The midpoint rule changes ω by (ω Δt)² / 12 of it, below 1e-6, and four hinges by a thousandth.
#[test]
fn a_mass_beside_the_tip_swings_by_bending_and_twist() {
    for beside_m in [0.0, 0.06, 0.12] {
        let blade = Blade { mass_per_area_kg_per_m2: 0.01, loss_factor: 0.0, ..blade(4) };
        let mass_kg = 0.05;
        let weight = |joint| {
            let center_body = DVec3::Y * beside_m;
            let inertia = Inertia { mass_kg, center_of_mass_body: center_body, principal_kg_m2: DVec3::splat(1e-9) };
            Some(Body { joint: Some(joint), inertia, ..Body::foot() })
        };
        let mut engine = Engine::new(PhysicsOptions { step_s: 0.0002, gravity_m_per_s2: 0.0 });
        let mechanism = clamped_with(&blade, 0.0, weight, &mut engine);
        let last = engine.scene.tree(mechanism.slot).links().len() - 1;
        let place = |engine: &Engine| pose(engine, mechanism, last).transform_point(DVec3::Y * beside_m).x;
        for _ in 0..50 {
            step_pushed(&mut engine, mechanism, last, DVec3::X * 0.01, DVec3::Y * beside_m);
        }
        // The times at which it crosses the middle towards +x.
        let mut crossings = Vec::new();
        let mut before = place(&engine);
        for step in 0..40_000 {
            engine.step();
            let now = place(&engine);
            if before < 0.0 && now >= 0.0 {
                crossings.push(f64::from(step) + before / (before - now));
            }
            before = now;
        }
        let periods = crossings.len() - 1;
        let period_s = 0.0002 * (crossings[periods] - crossings[0]) / periods as f64;
        let bending = blade.length_m.powi(3) / 3.0 / blade.flexural_rigidity_n_m2;
        let twist = beside_m * beside_m * blade.length_m / blade.torsional_rigidity_n_m2;
        let own_kg = blade.mass_per_length_kg_per_m() * blade.length_m * 33.0 / 140.0;
        let expected = std::f64::consts::TAU * (mass_kg * (bending + twist) + own_kg * bending).sqrt();
        assert!(periods > 3 && (period_s / expected - 1.0).abs() < 2e-3, "{beside_m} m: {period_s} s, {expected} s");
    }
}

/// The load at the tip along its width at which a blade leaves its plane, as a share of 4.013 √(E I G J) / L², within 1 / 128.
fn buckling_share(segments: u32) -> f64 {
    let blade = blade(segments);
    let rigidity = (blade.flexural_rigidity_n_m2 * blade.torsional_rigidity_n_m2).sqrt();
    let expected_n = 4.013 * rigidity / blade.length_m.powi(2);
    let (mut low, mut high) = (0.875, 1.0);
    for _ in 0..4 {
        let share = 0.5 * (low + high);
        let mut engine = Engine::new(PhysicsOptions { gravity_m_per_s2: 0.0, ..OPTIONS });
        let mechanism = clamped(&blade, 0.0, &mut engine);
        let last = engine.scene.tree(mechanism.slot).links().len() - 1;
        let tip_body = DVec3::Z * (blade.length_m - blade.hinges()[segments as usize - 1].place_m);
        for step in 0..6000 {
            let nudge = if step < 20 { DVec3::X * 0.001 } else { DVec3::ZERO };
            step_pushed(&mut engine, mechanism, last, DVec3::Y * (share * expected_n) + nudge, tip_body);
        }
        let aside_m = pose(&engine, mechanism, last).transform_point(tip_body).x.abs();
        if aside_m > 1e-3 { high = share } else { low = share }
    }
    0.5 * (low + high)
}

/// Tests the load of lateral-torsional buckling (Prandtl 1899). A hinge twists and bends at one place, so the bending sees too
/// much of the twist by half a piece, and the load is low by a share of the order of 1 / n. Twice the share with 40 hinges less
/// that with 20 removes this; what is left is 1 / n² and the width of the search, 3 / 256.
#[test]
fn a_blade_buckles_sideways_at_prandtls_load() {
    let [coarse, fine] = [20, 40].map(buckling_share);
    assert!(1.0 - coarse > 1.5 * (1.0 - fine), "{coarse} {fine}");
    assert!((2.0 * fine - coarse - 1.0).abs() < 3.0 / 256.0 + 1.0 / 400.0, "{coarse} {fine}");
}

/// The sag of the tip of a horizontal elastica of length 1 under its own weight, as a share of the length:
/// θ'' = −γ (1 − s) cos θ, θ(0) = 0, θ'(1) = 0, by shooting with Runge and Kutta's fourth-order method. γ = w L³ / (E I).
fn elastica_sag(gamma: f64) -> f64 {
    let shoot = |curvature: f64| {
        const STEPS: usize = 1000;
        let h = 1.0 / STEPS as f64;
        let slope = |s: f64, [angle, _, bend]: [f64; 3]| [bend, angle.sin(), -gamma * (1.0 - s) * angle.cos()];
        let mut state = [0.0, 0.0, curvature];
        for step in 0..STEPS {
            let s = step as f64 * h;
            let ahead = |by: [f64; 3], share: f64| std::array::from_fn(|at| state[at] + share * h * by[at]);
            let a = slope(s, state);
            let b = slope(s + 0.5 * h, ahead(a, 0.5));
            let c = slope(s + 0.5 * h, ahead(b, 0.5));
            let d = slope(s + h, ahead(c, 1.0));
            state = std::array::from_fn(|at| state[at] + h / 6.0 * (a[at] + 2.0 * b[at] + 2.0 * c[at] + d[at]));
        }
        state
    };
    let (mut low, mut high) = (0.0, gamma);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[2] < 0.0 { low = middle } else { high = middle }
    }
    shoot(low)[1]
}

/// Tests that a horizontal blade sags under its own weight as the elastica does, at a load that bends it by a fifth of its
/// length. With n hinges the error is below 1 / n² (0.6 % with 20; 0.15 % expected from the quadrature's order).
#[test]
fn a_horizontal_blade_sags_as_the_elastica() {
    let blade = Blade { flexural_rigidity_n_m2: 0.004, torsional_rigidity_n_m2: 0.006, ..blade(20) };
    let mut engine = Engine::new(OPTIONS);
    let mechanism = clamped(&blade, std::f64::consts::FRAC_PI_2, &mut engine);
    for _ in 0..4000 {
        engine.step();
    }
    let last = engine.scene.tree(mechanism.slot).links().len() - 1;
    let end_m = blade.length_m - blade.hinges()[19].place_m;
    let tip = pose(&engine, mechanism, last).transform_point(DVec3::Z * end_m);
    let gamma = 9.81 * blade.mass_per_length_kg_per_m() * blade.length_m.powi(3) / blade.flexural_rigidity_n_m2;
    let expected = elastica_sag(gamma);
    assert!(expected > 0.15, "{expected}");
    let found = (0.5 - tip.z) / blade.length_m;
    assert!((found / expected - 1.0).abs() < 1.0 / 400.0, "{found} {expected}");
}

/// Tests that a falling plate has the speed √(m g / c) tanh(t √(g c / m)) with c = ½ ρ C A, within the first order of the
/// step, g Δt over the last speed.
#[test]
fn a_falling_plate_reaches_its_final_speed() {
    let mut engine = Engine::new(OPTIONS);
    let (mass_kg, area_m2) = (0.002, 0.01);
    let plate = Body {
        joint: Some(Joint::parallel(0, DVec3::ZERO, vec![(Axis::along(DVec3::Z), Spring::elastic(0.0, 0.0))])),
        inertia: Inertia::of_box(mass_kg, DVec3::ZERO, DVec3::new(0.1, 0.1, 0.001)),
        drag: Some(Drag { area_m2, normal_body: DVec3::Z }),
        ..Body::foot()
    };
    let structure = Structure { bodies: vec![Body::foot(), plate], axisymmetric: false, surface: Surface::hard(0.4) };
    let mechanism = Mechanism::build(&structure, &mut engine, DVec3::ZERO, 0.0);
    // Air of 1.2 kg/m³, and a coefficient of 1.2.
    let drag = 0.5 * 1.2 * 1.2 * area_m2;
    let last_speed = (mass_kg * 9.81 / drag).sqrt();
    for step in 1..=400 {
        engine.step();
        let time_s = f64::from(step) * OPTIONS.step_s;
        let expected = last_speed * (time_s * 9.81 / last_speed).tanh();
        let found = -engine.scene.tree(mechanism.slot).coordinates[0].velocity;
        assert!((found - expected).abs() < 9.81 * OPTIONS.step_s, "{found} {expected}");
    }
    let found = -engine.scene.tree(mechanism.slot).coordinates[0].velocity;
    assert!((found / last_speed - 1.0).abs() < 1e-4, "{found} {last_speed}");
}

/// Tests that a hinge returns from a moment below its yield moment, and that beyond it keeps a set: the largest angle less
/// the elastic one, M / k.
#[test]
fn a_hinge_yields_and_keeps_a_set() {
    let spring = Spring { yield_moment: Some(0.2), ..Spring::elastic(1.0, 0.05) };
    for moment_nm in [0.15, 0.25] {
        let mut engine = Engine::new(PhysicsOptions { gravity_m_per_s2: 0.0, ..OPTIONS });
        let mechanism = hinge(spring, &mut engine);
        let mut largest = 0.0_f64;
        for step in 0..2000 {
            if step < 200 {
                let tree = engine.scene.tree_mut(mechanism.slot);
                tree.push(1, DVec3::ZERO, DVec3::ZERO, DVec3::Y * moment_nm);
            }
            engine.step();
            largest = largest.max(engine.scene.tree(mechanism.slot).coordinates[0].position);
        }
        let set = engine.scene.tree(mechanism.slot).coordinates[0].position;
        let expected = (largest - 0.2 / 1.0).max(0.0);
        assert!((set - expected).abs() < 1e-6, "{set} {expected}");
        assert_eq!(expected > 0.0, moment_nm > 0.2);
    }
}

/// Tests that plants with the default quantities stand as they are drawn, and come back to it from a push on a blade that is
/// too weak to fold it.
#[test]
fn plants_stand_as_they_are_drawn() {
    let group: Group<Plant> = toml::from_str("count = 1\nyield_moment_nm = 1000").unwrap();
    let footing = Footing { height_m: 0.0, foam_modulus_pa: Some(5e4) };
    for seed in 0..10 {
        let plant = group.0.draw(&mut ChaCha8Rng::seed_from_u64(seed), &footing).unwrap().0;
        let mut engine = Engine::new(OPTIONS);
        let mechanism = Mechanism::build(&plant.structure(9.81), &mut engine, DVec3::ZERO, 0.0);
        let last = engine.scene.tree(mechanism.slot).links().len() - 1;
        let away = |engine: &Engine| {
            let coordinates = &engine.scene.tree(mechanism.slot).coordinates;
            coordinates.iter().map(|own| own.position.abs()).fold(0.0, f64::max)
        };
        for _ in 0..200 {
            engine.step();
        }
        assert!(away(&engine) < 1e-9, "{}", away(&engine));
        for _ in 0..40 {
            step_pushed(&mut engine, mechanism, last, DVec3::new(0.03, 0.05, -0.05), DVec3::ZERO);
        }
        assert!(away(&engine) > 1e-3);
        for _ in 0..4000 {
            engine.step();
        }
        assert!(away(&engine) < 1e-3, "{}", away(&engine));
    }
}
