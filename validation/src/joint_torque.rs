//! Check 6: at rest, the springs balance the contact forces.

use glam::DVec3;
use nalgebra::DVector;
use underbrush_sim::arm::Arm;
use underbrush_sim::object::leaf::Leaf;

use crate::pressed_arm::{Beside, LEAF, OPTIONS, PressedArm, scale_stiffness};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 6.
pub const CHECK: Check = Check {
    name: "joint-torque",
    summary: "At rest, the joint springs balance the contact forces: K (φ − q) = −Σ Jᵀ f",
    cases: &[Case { compare, falsifications: &[STIFF_JOINTS] }],
};

const STIFF_JOINTS: Falsification = Falsification::new("stiffness of the simulated joints", "1 % too high");

fn compare(simulated: Simulated) -> Found {
    let leaf = || Beside::facing(Box::new(Leaf { loss_factor: 0.3, ..LEAF }), 0.005, 0.3);
    let compare = |(name, beside, force_n): (&str, Beside, f64)| -> Result<Comparison, Fault> {
        let wrong = |arm: &mut Arm| scale_stiffness(arm, simulated.with(STIFF_JOINTS, 1.0, 1.01));
        let mut pressed = PressedArm::new(beside, OPTIONS, wrong)?;
        let equilibrium = pressed.pressing_rad(force_n);
        pressed.hold(&equilibrium, 8.0);
        let springs = pressed.arm.joints.iter().zip(equilibrium.iter().zip(pressed.report().joint_angle_rad()));
        let springs = springs.map(|(joint, (rest, angle))| joint.stiffness_nm_per_rad * (rest - angle));
        let springs = DVector::from_vec(springs.collect());
        // Of the contacts as a recording has them.
        let poses = &pressed.report().link_pose_world;
        let mut contacts = DVector::zeros(pressed.arm.joints.len());
        for point in pressed.simulation.frame(0, DVec3::ZERO).contact_points {
            let wrench = [point.position_world, point.force_world, point.moment_world].map(|part| part.as_dvec3());
            pressed.arm.add_torque_nm(poses, point.link.into(), wrench, contacts.as_mut_slice());
        }
        let reason =
            "0.1 %: a state of rest has no discretization error; what remains is creep of the contact under friction";
        let torques = Comparison::of(format!("joint torques, {name} (norm)"), "N m", contacts.norm(), springs.norm());
        Ok(Comparison { residual: (&springs + &contacts).norm() / contacts.norm(), ..torques.relative(1e-3, reason) })
    };
    let pushes = [
        ("trunk, 2 N", Beside::trunk(), 2.0),
        ("trunk, 9 N", Beside::trunk(), 9.0),
        ("leaf, lightly touched", leaf(), 9.0),
        ("leaf, bent far", leaf(), 30.0),
    ];
    pushes.into_iter().map(compare).collect()
}
