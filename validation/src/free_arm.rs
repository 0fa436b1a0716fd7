//! Check 8: the arm without springs, dampers, gravity and contacts keeps its energy.

use underbrush_sim::arm::Arm;
use underbrush_sim::arm::engine::{ArmHandles, insert_arm};
use underbrush_sim::physics::{Physics, PhysicsOptions, groups};

use crate::{Breaks, Case, Check, CheckError, Comparison, Falsification, Simulated};

/// Check 8.
pub const CHECK: Check = Check {
    number: 8,
    name: "free-arm",
    summary: "The arm without springs, dampers, gravity and contacts keeps its energy; with them it never gains any",
    cases: &[
        Case {
            compare: free,
            falsifications: &[DAMPERS_LEFT_ON, LONG_STEP],
        },
        Case {
            compare: sprung,
            falsifications: &[DRIVING_DAMPERS],
        },
    ],
};

const DAMPERS_LEFT_ON: Falsification = Falsification {
    wrong: "dampers of the simulated joints",
    by: "1e-4 Nm s/rad instead of none",
    breaks: Breaks::Named(&["after 5 s"]),
};
const LONG_STEP: Falsification = Falsification {
    wrong: "step of the engine",
    by: "2 ms instead of 1 ms",
    breaks: Breaks::Named(&["largest rise"]),
};
const DRIVING_DAMPERS: Falsification = Falsification {
    wrong: "sign of the simulated joints' dampers",
    by: "negative",
    breaks: Breaks::Every,
};

const STEP_S: f64 = 1e-3;
const SECONDS: f64 = 5.0;
/// Joint velocities of an ordinary reach, rad/s.
const VELOCITY_RAD_PER_S: [f64; 7] = [0.3, -0.2, 0.4, -0.3, 0.5, 0.3, -0.4];

fn free(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut arm = Arm::cody()?;
    for joint in &mut arm.joints {
        joint.stiffness_nm_per_rad = 0.0;
        joint.damping_nm_s_per_rad = simulated.with(DAMPERS_LEFT_ON, 0.0, 1e-4);
    }
    let energies = energies_j(arm, STEP_S * simulated.with(LONG_STEP, 1.0, 2.0))?;
    let (start, end) = (energies[0], energies[energies.len() - 1]);
    Ok(vec![
        Comparison::relative(
            "energy of the free arm after 5 s, step 1 ms",
            "J",
            start,
            end,
            1e-3,
            "0.1 %: a step of first order; joints turn by half a milliradian in it",
        ),
        largest_rise("the free arm", &energies),
    ])
}

/// The arm as it is, but a hundred times less damped, so that it vibrates through all five seconds.
fn sprung(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut arm = Arm::cody()?;
    for joint in &mut arm.joints {
        joint.damping_nm_s_per_rad /= simulated.with(DRIVING_DAMPERS, 100.0, -100.0);
    }
    Ok(vec![largest_rise("the arm on its springs", &energies_j(arm, STEP_S)?)])
}

fn largest_rise(name: &str, energies_j: &[f64]) -> Comparison {
    let rises = energies_j.windows(2).map(|pair| pair[1] - pair[0]);
    Comparison::at_most(
        format!("largest rise of the energy of {name} in one step, of the energy at the start"),
        "",
        0.0,
        rises.fold(f64::NEG_INFINITY, f64::max) / energies_j[0],
        1e-9,
        "1e-9: never rising but for rounding",
    )
}

/// Energy, J, at the start and after each step, of an arm that is let go in its start posture with some velocity.
fn energies_j(mut arm: Arm, step_s: f64) -> Result<Vec<f64>, CheckError> {
    for joint in &mut arm.joints {
        joint.limits_rad = [f64::NEG_INFINITY, f64::INFINITY];
    }
    let mut physics = Physics::new(PhysicsOptions {
        step_s,
        substeps: 1,
        gravity_m_per_s2: 0.0,
    });
    let posture = arm.start_posture_rad();
    let handles = insert_arm(&arm, &posture, &mut physics, groups::arm());
    let multibody = handles.joints.first().and_then(|joint| physics.joints.get_mut(*joint));
    let Some((multibody, _)) = multibody else {
        return Err(CheckError::Case("an arm without joints".into()));
    };
    multibody
        .generalized_velocity_mut()
        .copy_from_slice(&VELOCITY_RAD_PER_S);
    let energy =
        |physics: &Physics| kinetic_energy_j(&arm, &handles, physics) + spring_energy_j(&arm, &handles, physics);
    let mut energies = vec![energy(&physics)];
    for _ in 0..(SECONDS / step_s).round() as usize {
        physics.step();
        energies.push(energy(&physics));
    }
    Ok(energies)
}

/// Energy of the joints' springs, which rest in the start posture, J.
fn spring_energy_j(arm: &Arm, handles: &ArmHandles, physics: &Physics) -> f64 {
    let stretch = handles
        .joint_angle_rad(physics)
        .into_iter()
        .zip(arm.start_posture_rad());
    arm.joints
        .iter()
        .zip(stretch)
        .map(|(joint, (angle, rest))| 0.5 * joint.stiffness_nm_per_rad * (angle - rest).powi(2))
        .sum()
}

/// Kinetic energy of the links and of the drives' reflected inertia, J, from the joint velocities alone.
fn kinetic_energy_j(arm: &Arm, handles: &ArmHandles, physics: &Physics) -> f64 {
    let velocity = nalgebra::DVector::from_vec(handles.joint_velocity_rad_per_s(physics));
    let poses = arm.forward_kinematics(&handles.joint_angle_rad(physics));
    let mut energy = 0.0;
    for (index, link) in arm.links.iter().enumerate().skip(1) {
        let center = poses[index].transform_point(link.center_of_mass_link);
        let speed = arm.position_jacobian(&poses, index, center) * &velocity;
        let turn = arm.angular_jacobian(&poses, index) * &velocity;
        let turn_link = poses[index].inverse_transform_vector(glam::DVec3::new(turn[0], turn[1], turn[2]));
        energy += 0.5 * (link.mass_kg * speed.norm_squared() + turn_link.dot(link.inertia_link * turn_link));
    }
    for (joint, velocity) in arm.joints.iter().zip(velocity.iter()) {
        energy += 0.5 * joint.armature_kg_m2 * velocity * velocity;
    }
    energy
}
