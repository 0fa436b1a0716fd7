//! The arm in the engine against the arm as data.

use nalgebra::Vector3;

use super::ArmBodies;
use crate::arm::tests::kinematics::matrix;
use crate::arm::tests::random_postures;
use crate::geometry::parry_pose;
use crate::simulation::engine::Engine;
use crate::simulation::report::JointState;
use crate::{Arm, PhysicsOptions};

mod dynamics;

const OPTIONS: PhysicsOptions = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };

/// The state of every joint.
fn joints(bodies: &ArmBodies, engine: &Engine) -> Vec<JointState> {
    let mut states = Vec::new();
    bodies.read_joints(engine, &mut states);
    states
}

fn inserted(arm: &Arm, posture: &[f64]) -> (Engine, ArmBodies) {
    let mut engine = Engine::new(OPTIONS);
    let bodies = ArmBodies::insert(arm, posture, &mut engine);
    (engine, bodies)
}

#[test]
fn the_tree_has_the_same_poses_and_jacobians() {
    // Tests that kinematics here and the tree are the same arm: link poses and the Jacobians of the centres of mass at
    // random postures.
    let arm = Arm::cody().unwrap();
    for posture in random_postures(&arm, 1000) {
        let (engine, bodies) = inserted(&arm, &posture);
        let tree = engine.scene.tree(bodies.slot);
        let poses = arm.forward_kinematics(&posture);
        assert_eq!(tree.coordinates.len(), 7);
        for (index, pose) in poses.iter().enumerate() {
            assert!((matrix(&tree.links()[index].pose_world) - matrix(pose)).amax() < 1e-12);
            let center = pose.transform_point(arm.links[index].center_of_mass_link);
            assert!(tree.center_of_mass_world(index).distance(center) < 1e-12);
            let position = arm.position_jacobian(&poses, index, center);
            let angular = arm.angular_jacobian(&poses, index);
            let motions: Vec<_> = tree.motions(index, center).collect();
            assert_eq!(motions.len(), index);
            for (at, [linear, turning]) in motions {
                assert!((Vector3::from(linear.to_array()) - position.column(at)).amax() < 1e-12);
                assert!((Vector3::from(turning.to_array()) - angular.column(at)).amax() < 1e-12);
            }
        }
        for (joint, set) in joints(&bodies, &engine).iter().zip(&posture) {
            assert!((joint.angle_rad - set).abs() < 1e-12);
        }
    }
}

#[test]
fn arm_stays_where_it_is_put() {
    // Tests that nothing moves an untouched arm: gravity is compensated, springs rest at the posture, damping and
    // springs sit on the right joints.
    let arm = Arm::cody().unwrap();
    let posture = arm.start_posture_rad();
    let (mut engine, bodies) = inserted(&arm, &posture);
    for _ in 0..200 {
        engine.step();
    }
    for (joint, set) in joints(&bodies, &engine).iter().zip(&posture) {
        assert!((joint.angle_rad - set).abs() < 1e-12);
    }
    let coordinates = &engine.scene.tree(bodies.slot).coordinates;
    assert_eq!(coordinates.len(), 7);
    for (joint, own) in arm.joints.iter().zip(coordinates) {
        assert_eq!(own.spring.damping, joint.damping_nm_s_per_rad);
        assert_eq!(own.spring.stiffness, joint.stiffness_nm_per_rad);
    }
}

#[test]
fn torque_stays_within_the_actuator_limit() {
    // Tests that an equilibrium angle far away pulls with the torque limit and no more, in both directions, and that
    // the arm comes to its stops.
    let arm = Arm::cody().unwrap();
    let posture = arm.start_posture_rad();
    for sign in [-1.0, 1.0] {
        let (mut engine, bodies) = inserted(&arm, &posture);
        let far: Vec<f64> = posture.iter().map(|angle| angle + sign * 10.0).collect();
        bodies.set_equilibrium(&arm, &far, &mut engine);
        for (torque, joint) in
            joints(&bodies, &engine).iter().map(|joint| joint.torque_nm).collect::<Vec<f64>>().iter().zip(&arm.joints)
        {
            assert!((torque - sign * joint.torque_limit_nm).abs() < 1e-9, "{}: {torque} N m", joint.name);
        }
        for _ in 0..400 {
            bodies.set_equilibrium(&arm, &far, &mut engine);
            engine.step();
        }
        let angles = joints(&bodies, &engine).iter().map(|joint| joint.angle_rad).collect::<Vec<f64>>();
        for (angle, joint) in angles.iter().zip(&arm.joints) {
            // A stop gives way by 0.035 rad under the full torque.
            let [lower, upper] = joint.limits_rad;
            let stop = if sign > 0.0 { upper } else { lower };
            assert!((angle - stop).abs() < 0.05, "{} is at {angle}, its stop at {stop}", joint.name);
        }
    }
}

#[test]
fn shapes_sit_where_the_files_put_them() {
    // Tests the rotation from the engine's y axis to the files' z axis: the forearm's cylinder spans its skin
    // lengthwise, and the flipper's hulls end at the end effector.
    let arm = Arm::cody().unwrap();
    let (engine, bodies) = inserted(&arm, &[0.0; 7]);
    let lowest_and_highest = |name: &str| {
        let link = arm.link_index(name).unwrap();
        let boxes = bodies.colliders.iter().filter(|own| bodies.link_of(&engine, **own) == Some(link));
        boxes
            .map(|own| engine.scene.shape(*own).compute_aabb(&parry_pose(&engine.scene.collider_pose(*own))))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), bounds| {
                (low.min(bounds.mins.z), high.max(bounds.maxs.z))
            })
    };
    let elbow_z = -0.27795;
    let (low, high) = lowest_and_highest("forearm");
    assert!((high - (elbow_z - 0.0300)).abs() < 1e-4 && (low - (elbow_z - 0.267)).abs() < 1e-3, "{low} {high}");
    let (low, high) = lowest_and_highest("flipper");
    let wrist_z = elbow_z - 0.27853;
    assert!((low - (wrist_z - 0.27)).abs() < 1e-9 && (high - (wrist_z - 0.02)).abs() < 1e-9, "{low} {high}");
}

/// Tests that an engine that has lost its numbers does not make the springs panic: NaN comes back as NaN.
#[test]
fn an_engine_without_numbers_does_not_panic() {
    let arm = Arm::cody().unwrap();
    let (mut engine, bodies) = inserted(&arm, &arm.start_posture_rad());
    let nothing = vec![f64::NAN; arm.joints.len()];
    for own in &mut engine.scene.tree_mut(bodies.slot).coordinates {
        own.position = f64::NAN;
    }
    assert!(
        joints(&bodies, &engine)
            .iter()
            .map(|joint| joint.angle_rad)
            .collect::<Vec<f64>>()
            .iter()
            .all(|angle| angle.is_nan())
    );
    bodies.set_equilibrium(&arm, &arm.start_posture_rad(), &mut engine);
    bodies.set_equilibrium(&arm, &nothing, &mut engine);
    assert!(
        joints(&bodies, &engine)
            .iter()
            .map(|joint| joint.torque_nm)
            .collect::<Vec<f64>>()
            .iter()
            .all(|torque| torque.is_nan())
    );
}
