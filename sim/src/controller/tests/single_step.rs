use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::super::{ControlStatus, Controller, ControllerKind, ModelPredictive, Preset};
use super::{Situation, middle, vector};
use crate::arm::Arm;

pub(super) fn presets() -> [Preset; 2] {
    [Preset::cody_2013(), Preset::ijrr_foliage()]
}

/// The published model, written with full matrices: P K_j, and the rows n_iᵀ K_ci J_ci P K_j of the contacts that
/// count.
fn model(situation: &Situation<'_>, preset: &Preset) -> (DMatrix<f64>, Vec<(f64, DVector<f64>)>) {
    let joints = &situation.arm.joints;
    let springs = joints.iter().map(|joint| joint.model_stiffness_nm_per_rad);
    let spring = DMatrix::from_diagonal(&DVector::from_iterator(7, springs));
    let mut stiffness = spring.clone();
    let mut rows = Vec::new();
    for contact in situation.contacts.iter().filter(|contact| contact.force_n >= 1.0) {
        let jacobian = DMatrix::from_column_slice(3, 7, contact.position_jacobian.as_slice());
        let normal = -vector(contact.inward_normal_world);
        let contact_stiffness = normal * normal.transpose() * preset.contact_stiffness_n_per_m;
        stiffness += jacobian.transpose() * contact_stiffness * &jacobian;
        rows.push((contact.force_n, (normal.transpose() * contact_stiffness * jacobian).transpose()));
    }
    let response = stiffness.try_inverse().unwrap() * spring;
    let rows = rows.into_iter().map(|(force, row)| (force, response.tr_mul(&row))).collect();
    (response, rows)
}

/// The published cost of a step.
fn cost(situation: &Situation<'_>, preset: &Preset, change: &DVector<f64>) -> f64 {
    let (response, rows) = model(situation, preset);
    let error = situation.goal_position_world - situation.end_effector().position;
    let slow = preset.slow_distance_m.unwrap_or(preset.end_effector_step_m);
    let wanted = vector(error.normalize() * preset.end_effector_step_m * (error.length() / slow).min(1.0));
    let moved = DMatrix::from_column_slice(3, 7, situation.end_effector_jacobian().as_slice()) * &response * change;
    let position = (wanted - moved).norm_squared() * preset.position_weight;
    let springs = situation.arm.joints.iter().map(|joint| joint.model_stiffness_nm_per_rad);
    let torque: f64 = springs.zip(change).map(|(stiffness, change)| (stiffness * change).powi(2)).sum();
    let over: Vec<&(f64, DVector<f64>)> = rows.iter().filter(|(force, _)| *force > preset.force_limit_n).collect();
    let excess = |row: &DVector<f64>| (row.dot(change) + preset.over_limit_force_reduction_n).powi(2);
    let force: f64 = over.iter().map(|(_, row)| excess(row)).sum();
    position + preset.torque_change_weight * torque + preset.force_weight * force / over.len().max(1) as f64
}

/// By how much a step violates the published bounds.
fn violation(situation: &Situation<'_>, preset: &Preset, change: &DVector<f64>) -> f64 {
    let (response, rows) = model(situation, preset);
    let mut worst = f64::NEG_INFINITY;
    for (force, row) in rows {
        let max = if force > preset.force_limit_n {
            preset.over_limit_force_change_n
        } else {
            preset.force_rise_n.min(preset.force_limit_n - force)
        };
        let predicted = row.dot(change);
        worst = worst.max(predicted - max).max(-10.0 - predicted);
    }
    let moved = response * change;
    for (index, joint) in situation.arm.joints.iter().enumerate() {
        let angle = situation.angle[index] + moved[index];
        let [lower, upper] = joint.controller_limits_rad;
        worst = worst.max(angle - upper.max(situation.angle[index])).max(lower.min(situation.angle[index]) - angle);
        let step = (joint.slew_limit_rad_per_s / preset.rate_hz).min(preset.equilibrium_step_rad.unwrap_or(10.0));
        worst = worst.max(change[index].abs() - step);
        if let Some(limit) = preset.equilibrium_offset_rad {
            let before = situation.equilibrium[index] - situation.angle[index];
            worst = worst.max((before + change[index]).abs() - limit.max(before.abs()));
        }
    }
    worst
}

/// The arm in a random posture, pressed in up to eight places, with a goal up to half a metre away.
pub(super) fn random_situation<'a>(arm: &'a Arm, random: &mut ChaCha8Rng) -> Situation<'a> {
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    let angle: Vec<f64> = arm
        .joints
        .iter()
        .map(|joint| between(joint.controller_limits_rad[0], joint.controller_limits_rad[1]))
        .collect();
    let mut situation = Situation::at(arm, &angle);
    for value in &mut situation.equilibrium {
        *value += between(-0.3, 0.3);
    }
    situation.goal_position_world += DVec3::new(between(-0.3, 0.3), between(-0.3, 0.3), between(-0.3, 0.3));
    for _ in 0..between(0.0, 9.0) as usize {
        let patch = between(0.0, 2.0) as usize;
        let count = arm.skin.layout.patches[patch].taxels.len();
        situation.press(patch, between(0.0, count as f64) as usize, between(0.5, 7.0));
    }
    situation
}

fn change_of(situation: &Situation<'_>, controller: &mut dyn Controller) -> (ControlStatus, DVector<f64>) {
    let output = situation.step(controller);
    let pairs = output.equilibrium_angle_rad.iter().zip(&situation.equilibrium);
    (output.status, DVector::from_iterator(7, pairs.map(|(after, before)| after - before)))
}

#[test]
fn steps_are_the_constrained_minimum_of_the_published_cost() {
    // Tests cost and constraints against the published formulas with full matrices: each step keeps all bounds, and no
    // other step that keeps them costs less.
    let arm = Arm::cody().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for preset in presets() {
        let mut controller = ModelPredictive::new(preset.clone(), &arm);
        let (mut solved, mut compared) = (0, 0);
        for _ in 0..300 {
            let situation = random_situation(&arm, &mut random);
            let (status, change) = change_of(&situation, &mut controller);
            if status != ControlStatus::Solved {
                assert_eq!(status, ControlStatus::Infeasible);
                assert_eq!(change.amax(), 0.0, "φ must stay");
                // A step of zero keeps all bounds unless a force must fall.
                assert!(preset.over_limit_force_change_n < 0.0);
                continue;
            }
            solved += 1;
            assert!(violation(&situation, &preset, &change) < 1e-9);
            let optimum = cost(&situation, &preset, &change);
            for round in 0..200 {
                let size = 10.0_f64.powi(-1 - round % 5);
                let other = &change + DVector::from_fn(7, |_, _| random.random_range(-0.1..0.1) * size);
                if violation(&situation, &preset, &other) <= 0.0 {
                    compared += 1;
                    assert!(cost(&situation, &preset, &other) >= optimum - 1e-13);
                }
            }
        }
        assert!(solved > 200 && compared > 1000, "{}: {solved} solved, {compared} compared", preset.name);
    }
}

#[test]
fn opposed_forces_over_the_limit_leave_the_arm_where_it_is() {
    // Tests the infeasible case: two forces at one place that push against each other cannot both fall.
    let arm = Arm::cody().unwrap();
    let mut situation = Situation::at(&arm, &middle());
    situation.press(0, 100, 8.0);
    let mut opposed = situation.contacts[0].clone();
    opposed.inward_normal_world = -opposed.inward_normal_world;
    situation.contacts.push(opposed);
    situation.goal_position_world += DVec3::X * 0.1;
    let output = situation.step(&mut ModelPredictive::new(Preset::ijrr_foliage(), &arm));
    assert_eq!(output.status, ControlStatus::Infeasible);
    assert_eq!(output.equilibrium_angle_rad, situation.equilibrium);
}

#[test]
fn numbers_that_are_none_leave_the_arm_where_it_is() {
    // Tests the failed case: if the input holds NaN, φ stays as it was.
    let arm = Arm::cody().unwrap();
    for preset in presets() {
        let mut situation = Situation::at(&arm, &middle());
        situation.goal_position_world.x = f64::NAN;
        let output = situation.step(&mut ModelPredictive::new(preset, &arm));
        assert_eq!(output.status, ControlStatus::Failed);
        assert_eq!(output.equilibrium_angle_rad, situation.equilibrium);
    }
}

#[test]
fn faint_forces_are_no_contacts() {
    // Tests the threshold of 1.0 N: a taxel below it has no effect; one at or above it has.
    let arm = Arm::cody().unwrap();
    for preset in presets() {
        let mut controller = ModelPredictive::new(preset, &arm);
        let mut free = Situation::at(&arm, &middle());
        free.goal_position_world += DVec3::new(0.1, 0.1, 0.0);
        let step_with = |controller: &mut ModelPredictive, force_n: f64| {
            let mut situation = Situation::at(&arm, &middle());
            situation.goal_position_world = free.goal_position_world;
            for taxel in 0..384 {
                situation.press(0, taxel, force_n);
            }
            situation.step(controller).equilibrium_angle_rad
        };
        let without = free.step(&mut controller).equilibrium_angle_rad;
        assert_eq!(step_with(&mut controller, 0.999), without);
        assert_ne!(step_with(&mut controller, 1.0), without);
    }
}

#[test]
fn far_equilibrium_angles_are_reset() {
    // Tests the 20° bound and the reset beyond 25° of `cody-2013`, and that the other set has neither.
    let arm = Arm::cody().unwrap();
    let mut cody = ModelPredictive::new(Preset::cody_2013(), &arm);
    for (offset_deg, reset) in [(15.0, false), (22.0, false), (24.9, false), (25.1, true), (-30.0, true)] {
        let mut situation = Situation::at(&arm, &middle());
        situation.equilibrium[3] += f64::to_radians(offset_deg);
        situation.goal_position_world += DVec3::X * 0.2;
        let output = situation.step(&mut cody);
        assert_eq!(output.status, ControlStatus::Solved);
        let after = (output.equilibrium_angle_rad[3] - situation.angle[3]).to_degrees().abs();
        if reset {
            assert!(after <= 0.5 + 1e-9, "{after}° after {offset_deg}°");
        } else {
            assert!(after <= 20.0_f64.max(offset_deg) + 1e-9 && after >= offset_deg - 0.5 - 1e-9, "{after}°");
        }
        let output = situation.step(&mut ModelPredictive::new(Preset::ijrr_foliage(), &arm));
        let after = (output.equilibrium_angle_rad[3] - situation.equilibrium[3]).abs();
        assert!(after <= arm.joints[3].slew_limit_rad_per_s / 100.0 + 1e-12);
    }
}

#[test]
fn joints_beyond_their_limits_do_not_stop_the_arm() {
    // Tests that limits are clamped so that standing still is allowed: an elbow pushed past its limit may move back but
    // not farther, and the other joints still move.
    let arm = Arm::cody().unwrap();
    for preset in presets() {
        let mut posture = middle();
        posture[3] = arm.joints[3].controller_limits_rad[1] + 0.05;
        let mut situation = Situation::at(&arm, &posture);
        situation.goal_position_world += DVec3::new(-0.1, 0.1, 0.1);
        let (status, change) = change_of(&situation, &mut ModelPredictive::new(preset, &arm));
        assert_eq!(status, ControlStatus::Solved);
        assert!(change[3] <= 1e-12);
        assert!(change.amax() > 1e-4);
    }
}

#[test]
fn blind_is_the_same_controller_without_skin() {
    // Tests that the baseline answers as the same controller does without contacts, whatever its parameters, and that every
    // name gives the controller of that name.
    let arm = Arm::cody().unwrap();
    let mut situation = Situation::at(&arm, &middle());
    situation.goal_position_world += DVec3::new(0.1, 0.0, 0.1);
    let preset = Preset::cody_2013();
    let free = situation.step(&mut ModelPredictive::new(preset.clone(), &arm));
    situation.press(0, 12, 20.0);
    let blind = ControllerKind::Blind;
    assert_eq!(situation.step(blind.controller(blind.preset(), &arm).as_mut()), free);
    assert_eq!(situation.step(blind.controller(preset.clone(), &arm).as_mut()), free);
    assert_ne!(situation.step(&mut ModelPredictive::new(preset, &arm)), free);
    for name in ControllerKind::names() {
        let kind = ControllerKind::from_name(name).unwrap();
        assert_eq!((kind.name(), kind.controller(kind.preset(), &arm).name()), (name, name));
        // Data sets store this one.
        assert_eq!(kind.preset().name, name);
    }
    assert!(ControllerKind::from_name("cody").is_err());
}
