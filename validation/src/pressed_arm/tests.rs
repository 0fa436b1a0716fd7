//! Tests of the arm pressed on an object: its springs, its skin and the audit.
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use underbrush_oracles::foundation;
use underbrush_recording::Audit;
use underbrush_sim::audit::Auditor;
use underbrush_sim::audit::energy::EnergyBalance;
use underbrush_sim::simulation::TactileFrame;

use super::*;

/// The arm with an object beside its forearm.
fn beside(object: Box<dyn Object>, gap_m: f64, physics: PhysicsOptions) -> PressedArm {
    PressedArm::new(Beside::facing(object, gap_m, 0.3), physics, |_| {}).unwrap()
}

/// The arm pressed for `seconds` on one object by equilibrium angles that would press with `force_n` (N) if nothing
/// moved, with those angles and the audit.
fn press(object: Box<dyn Object>, gap_m: f64, force_n: f64, seconds: f64) -> (PressedArm, Vec<f64>, Audit) {
    let mut pressed = beside(object, gap_m, OPTIONS);
    let equilibrium = pressed.pressing_rad(force_n);
    let mut auditor = Auditor::new(&pressed.simulation);
    for _ in 0..(seconds / FRAME_PERIOD_S) as usize {
        let simulation = &mut pressed.simulation;
        simulation.step_observed(&equilibrium, &mut |step| auditor.observe_step(step));
        auditor.observe_frame(simulation.arm(), simulation.report());
    }
    (pressed, equilibrium, auditor.audit())
}

fn largest_force_n(tactile: &TactileFrame) -> f64 {
    tactile.largest_force().map_or(0.0, |force| force.force_n)
}

fn trunk() -> Box<dyn Object> {
    Beside::trunk().object
}

/// Tests that contact forces balance the joints' springs, K (φ − q) = −Σ Jᵀ f, to 1e-3 once the arm is at rest, and
/// that the taxel forces add up to the contact forces to 1e-9.
#[test]
fn springs_balance_contact_forces() {
    for force in [2.0, 9.0] {
        let (pressed, equilibrium, audit) = press(trunk(), 0.017, force, 8.0);
        let (arm, report) = (&pressed.arm, pressed.report());
        let angle = report.joint_angle_rad();
        let spring: Vec<f64> = (0..angle.len())
            .map(|joint| arm.joints[joint].stiffness_nm_per_rad * (equilibrium[joint] - angle[joint]))
            .collect();
        let spring = DVector::from_vec(spring);
        let contact = DVector::from_vec(report.contact_torque_nm(arm));
        assert!(contact.norm() > 0.1 * force, "no contact: {contact}");
        let residual = (&spring + &contact).norm() / spring.norm();
        assert!(residual < 1e-3, "relative residual {residual} at {force} N: {spring} {contact}");
        // The weaker push loads the joints with 0.3 N m: too little for the audit to count.
        assert!((audit.rest_frames > 0) == (force > 5.0) && audit.largest_static_residual < 0.05, "{audit:?}");
        assert!(
            report.tactile.force_residual < 1e-9,
            "taxels miss the solver's force by {}",
            report.tactile.force_residual
        );
    }
}

/// Tests that a trunk presses about as many taxels as in a stored frame of the real skin (nine newtons on 4 × 2 taxels
/// of 0.6–1.5 N), and that a larger force presses at least as many.
#[test]
fn a_broad_contact_lights_a_patch() {
    let lit = |force: f64| {
        let (pressed, ..) = press(trunk(), 0.017, force, 8.0);
        let taxels = &pressed.report().tactile.taxels;
        taxels.iter().filter(|taxel| taxel.true_normal_force_n > 0.02).count()
    };
    let (few, many) = (lit(3.0), lit(12.0));
    assert!((2..=12).contains(&few) && few <= many && many <= 24, "{few} taxels at 3 N, {many} at 12 N");
}

/// Tests that an arm that starts 5 mm deep in a trunk is pushed out, and after two seconds rests against the trunk on
/// its springs. The skin gives 2π √(R₁R₂) ∫ p dh at first. The trunk is too low to touch the upper arm.
#[test]
fn an_arm_that_starts_in_contact_is_pushed_out() {
    let trunk = Trunk { diameter_m: 0.03, height_m: 0.34 };
    let (pressed, _, audit) = press(Box::new(trunk), 0.010, 0.0, 2.0);
    let layer = foundation::Layer {
        stiffness_n_per_m3: pressed.arm.skin.stiffness_n_per_m3,
        ground_n_per_m3: 3e8,
        thickness_m: pressed.arm.skin.thickness_m.unwrap(),
    };
    let first_n = layer.force_n([FOREARM_RADIUS_M, 0.015], 0.005);
    assert!(audit.largest_frame_force_jump_n < first_n, "{first_n} N, {audit:?}");
    let force = largest_force_n(&pressed.report().tactile);
    // 5 mm against the arm's 0.1–0.5 kN/m.
    assert!((0.1..10.0).contains(&force), "{force} N");
}

/// Tests that a bare upper arm that starts inside a trunk is pushed out by its shell with at most π k √(R₁R₂) d² at 5
/// mm depth, and not with the kilonewtons of a contact that is stiffer on heavier bodies.
#[test]
fn a_bare_upper_arm_in_a_trunk_meets_its_shell() {
    const HARD_N_PER_M3: f64 = 3e8;
    let mut pressed = beside(trunk(), 0.010, OPTIONS);
    let equilibrium = pressed.posture_rad.clone();
    pressed.hold(&equilibrium, FRAME_PERIOD_S);
    let covered: Vec<usize> = pressed.arm.skin.surfaces.iter().map(|surface| surface.link).collect();
    let report = pressed.report();
    let bare: Vec<_> = report.contacts.iter().filter(|contact| !covered.contains(&contact.link)).collect();
    let force: f64 = bare.iter().map(|contact| contact.force_world.length()).sum();
    let depth_m = bare.iter().map(|contact| contact.penetration_m).fold(0.0, f64::max);
    let law_n = std::f64::consts::PI * HARD_N_PER_M3 * (0.06 * 0.015_f64).sqrt() * 0.005_f64.powi(2);
    assert!(force > 10.0, "nothing bare touches: {:?}", report.contacts);
    assert!(force < law_n && depth_m < 0.005, "{force} N, {depth_m} m");
}

/// Tests that a leaf gives way where a trunk does not: under the same push, its largest taxel force is less than 0.3 of
/// the trunk's.
#[test]
fn a_leaf_pushes_back_less_than_a_trunk() {
    let leaf = Leaf { loss_factor: 0.1, segments: 8, ..LEAF };
    let (soft, ..) = press(Box::new(leaf), 0.005, 6.0, 4.0);
    let (hard, ..) = press(trunk(), 0.017, 6.0, 4.0);
    let [soft, hard] = [soft, hard].map(|pressed| largest_force_n(&pressed.report().tactile));
    assert!(soft > 0.01, "the leaf was not touched");
    assert!(soft < 0.3 * hard, "{} N, {} N", soft, hard);
}

/// Tests the energy balance of an arm that is pressed on a trunk and dragged along it with friction. Less than 0.2 % of
/// the exchanged work is unexplained at steps of 1 ms, and the contacts take more than a fifth of the actuators' work.
#[test]
fn dragging_along_a_trunk_keeps_the_balance() {
    let options = PhysicsOptions { step_s: 0.001, gravity_m_per_s2: 9.81 };
    let mut pressed = beside(trunk(), 0.017, options);
    let mut balance = EnergyBalance::new(&pressed.simulation);
    let arm = pressed.arm.clone();
    let (posture, across) = (pressed.posture_rad.clone(), pressed.across_world);
    let poses = arm.forward_kinematics(&posture);
    let place = poses[pressed.forearm].transform_point(PLACE_LINK);
    let jacobian = pressed.jacobian(&poses, place).transpose();
    let (press, drag) = (&jacobian * Vector3::from((across * 6.0).to_array()), &jacobian * Vector3::new(8.0, 0.0, 0.0));
    for frame in 0..600 {
        let pressing = (f64::from(frame) / 100.0).min(1.0);
        let dragging = (f64::from(frame - 200) * 0.02).max(0.0).sin();
        let angle = |(joint, start): (usize, &f64)| {
            start + (press[joint] * pressing + drag[joint] * dragging) / arm.joints[joint].stiffness_nm_per_rad
        };
        let equilibrium: Vec<f64> = posture.iter().enumerate().map(angle).collect();
        pressed.simulation.step_observed(&equilibrium, &mut |step| balance.observe_step(step));
    }
    let sums = &balance.sums;
    assert!(sums.contacts_j > 0.2 * sums.actuators_j, "{sums:?}");
    assert!(sums.residual_j().abs() < 2e-3 * sums.exchanged_j, "{sums:?}: {}", sums.residual_j());
}
