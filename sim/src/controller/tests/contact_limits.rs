use glam::DVec3;
use nalgebra::Matrix3xX;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use underbrush_recording::Pose;

use super::super::{ControlStatus, Controller, ControllerInput, ModelPredictive, Preset, TaxelContact};
use super::single_step::{presets, random_situation};
use crate::arm::Arm;

#[test]
fn the_usual_limit_given_to_each_contact_changes_nothing() {
    // Tests that the answer is the same bit for bit whether contacts have no limit of their own or the limit of the
    // parameter set, and that a lower limit changes it.
    let arm = Arm::cody().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for preset in presets() {
        let mut controller = ModelPredictive::new(preset.clone(), &arm);
        let mut changed = 0;
        for _ in 0..200 {
            let mut situation = random_situation(&arm, &mut random);
            let without = situation.step(&mut controller);
            let mut with = |limit_n: f64| {
                let contacts = situation.contacts.iter_mut();
                contacts.for_each(|contact| contact.allowed_force_n = Some(limit_n));
                situation.step(&mut controller)
            };
            let usual = with(preset.force_limit_n);
            assert_eq!(usual.status, without.status);
            let bits = |angles: &[f64]| -> Vec<u64> { angles.iter().map(|angle| angle.to_bits()).collect() };
            assert_eq!(bits(&usual.equilibrium_angle_rad), bits(&without.equilibrium_angle_rad));
            changed += usize::from(with(0.5 * preset.force_limit_n) != without);
        }
        assert!(changed > 50, "{}: {changed}", preset.name);
    }
}

#[test]
fn one_joint_presses_up_to_the_contacts_limit() {
    // Tests the closed form for one joint of stiffness K whose skin presses at the distance r on a spring k, on the way
    // to a goal beyond: Δq = K / (K + k r²) Δφ, and Δφ is such that the force k r Δq grows by 0.1 N, or up to the limit
    // of the contact, or not at all if the force is over that limit.
    let mut arm = Arm::cody().unwrap();
    arm.joints.truncate(1);
    let (lever_m, force_n, preset) = (0.3, 1.45, Preset::cody_2013());
    let stiffness = arm.joints[0].model_stiffness_nm_per_rad;
    let spring = preset.contact_stiffness_n_per_m;
    let newton_per_rad = spring * lever_m * stiffness / (stiffness + spring * lever_m * lever_m);
    let angle = [0.5 * (arm.joints[0].controller_limits_rad[0] + arm.joints[0].controller_limits_rad[1])];
    let along_x = |lever_m: f64| Matrix3xX::from_column_slice(&[lever_m, 0.0, 0.0]);
    let limits = [(None, 0.1), (Some(6.0), 0.1), (Some(1.5), 0.05), (Some(1.47), 0.02), (Some(1.2), 0.0)];
    for (allowed_force_n, expected_n) in limits {
        let output = ModelPredictive::new(preset.clone(), &arm).control(&ControllerInput {
            joint_angle_rad: angle.to_vec(),
            joint_velocity_rad_per_s: vec![0.0],
            equilibrium_angle_rad: angle.to_vec(),
            end_effector_pose_world: Pose::IDENTITY,
            end_effector_jacobian: along_x(0.7),
            goal_position_world: DVec3::X,
            contacts: vec![TaxelContact {
                patch: 0,
                taxel: 0,
                link: 1,
                position_world: DVec3::ZERO,
                position_jacobian: along_x(lever_m),
                inward_normal_world: -DVec3::X,
                force_n,
                allowed_force_n,
                verdict: None,
            }],
        });
        assert_eq!(output.status, ControlStatus::Solved);
        let rise_n = newton_per_rad * (output.equilibrium_angle_rad[0] - angle[0]);
        assert!((rise_n - expected_n).abs() < 1e-9, "{allowed_force_n:?}: {rise_n} N");
    }
}
