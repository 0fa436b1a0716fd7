use std::f64::consts::TAU;

use glam::DVec3;
use nalgebra::{DVector, Vector3};

use super::joints;
use crate::arm::{Arm, ArmSource};
use crate::physics::PhysicsOptions;
use crate::simulation::arm::ArmBodies;
use crate::simulation::engine::Engine;

/// A pendulum on one compliant joint: 1.5 kg at 0.3 m, 0.004 kg m² about the centre of mass.
fn one_joint_arm() -> Arm {
    let source = |name: &str, text: &str| ArmSource { name: name.into(), text: text.into() };
    let arm = r#"name = "one"
        urdf = "one.urdf"
        skin = "one.skin.toml"
        base_link = "base"
        tip_link = "bar"
        friction = 0.3
        [[joint]]
        name = "hinge"
        stiffness_nm_per_rad = 20
        damping_nm_s_per_rad = 0.2
        armature_kg_m2 = 0.011
        model_stiffness_nm_per_rad = 20
        controller_limits_deg = [-90, 90]
        start_deg = 0"#;
    let urdf = r#"<robot name="one"><link name="base"/><link name="bar"><inertial><origin xyz="0 0 -0.3"/>
        <mass value="1.5"/><inertia ixx="0.004" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.004"/></inertial></link>
        <joint name="hinge" type="revolute"><parent link="base"/><child link="bar"/><axis xyz="0 1 0"/>
        <limit lower="-3" upper="3" effort="100" velocity="1"/></joint></robot>"#;
    let files =
        [source("one.toml", arm), source("one.urdf", urdf), source("one.skin.toml", "stiffness_n_per_m3 = 1e7")];
    Arm::from_files(&files).unwrap()
}

#[test]
fn step_of_the_equilibrium_angle_gives_the_second_order_response() {
    // Tests stiffness, damping, inertia and armature together: I = m r² + I_c + armature = 0.15 kg m²,
    // ω₀ = sqrt(K/I), ζ = D / (2 sqrt(K I)); period 2π/(ω₀ sqrt(1 − ζ²)), overshoot exp(−π ζ / sqrt(1 − ζ²)).
    let arm = one_joint_arm();
    let step_s = 1e-4;
    let options = PhysicsOptions { step_s, gravity_m_per_s2: 9.81 };
    let mut engine = Engine::new(options);
    let bodies = ArmBodies::insert(&arm, &[0.0], &mut engine);
    let target = 0.2;
    bodies.set_equilibrium(&arm, &[target], &mut engine);
    let mut rising = Vec::new();
    let mut highest = 0.0_f64;
    let mut last = 0.0;
    for step in 0..25_000 {
        engine.step();
        let angle = joints(&bodies, &engine).iter().map(|joint| joint.angle_rad).collect::<Vec<f64>>()[0];
        if last < target && angle >= target {
            rising.push(step_s * (f64::from(step) + (target - last) / (angle - last)));
        }
        highest = highest.max(angle);
        last = angle;
    }
    let inertia = 1.5 * 0.3 * 0.3 + 0.004 + 0.011;
    let natural = (20.0_f64 / inertia).sqrt();
    let ratio = 0.2 / (2.0 * (20.0 * inertia).sqrt());
    let damped = natural * (1.0 - ratio * ratio).sqrt();
    let periods = (rising.len() - 1) as f64;
    assert!(periods >= 3.0);
    let period = (rising[rising.len() - 1] - rising[0]) / periods;
    // Backward Euler shortens the frequency by (ω₀ dt)² and adds ω₀ dt/2 = 6e-4 to the damping ratio.
    assert!((period * damped / TAU - 1.0).abs() < 5e-3, "period {period} s");
    let overshoot = (highest - target) / target;
    let expected = (-std::f64::consts::PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
    assert!((overshoot / expected - 1.0).abs() < 5e-3, "overshoot {overshoot}, expected {expected}");
}

#[test]
fn end_effector_force_at_rest_is_held_by_the_springs() {
    // Tests statics: K (φ − q) + Jᵀ f = 0 for a known force at the end effector, to 1e-3 of the largest joint torque.
    let arm = Arm::cody().unwrap();
    let options = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 };
    let posture = arm.start_posture_rad();
    for force in [DVec3::new(-4.0, 0.0, 0.0), DVec3::new(1.0, 3.0, -2.0)] {
        let mut engine = Engine::new(options);
        let bodies = ArmBodies::insert(&arm, &posture, &mut engine);
        for _ in 0..2400 {
            let end_effector = arm.end_effector_pose(&arm.forward_kinematics(
                &joints(&bodies, &engine).iter().map(|joint| joint.angle_rad).collect::<Vec<f64>>(),
            ));
            let tree = engine.scene.tree_mut(bodies.slot);
            tree.push(arm.end_effector_link, force, end_effector.position, DVec3::ZERO);
            engine.step();
        }
        let angles = joints(&bodies, &engine).iter().map(|joint| joint.angle_rad).collect::<Vec<f64>>();
        let links = arm.forward_kinematics(&angles);
        let jacobian = arm.position_jacobian(&links, arm.end_effector_link, arm.end_effector_pose(&links).position);
        let load = jacobian.transpose() * Vector3::new(force.x, force.y, force.z);
        let stiffness = arm.joints.iter().map(|joint| joint.stiffness_nm_per_rad);
        let spring =
            DVector::from_iterator(7, stiffness.zip(posture.iter().zip(&angles)).map(|(k, (rest, q))| k * (rest - q)));
        assert!(load.amax() > 0.5, "the force must load the joints for the check to mean anything");
        assert!((&spring + &load).amax() < 1e-3 * load.amax(), "{spring} against {load}");
        let read = joints(&bodies, &engine).iter().map(|joint| joint.torque_nm).collect::<Vec<f64>>();
        assert!(spring.iter().zip(&read).all(|(spring, read)| (spring - read).abs() < 1e-3 * load.amax()));
    }
}
