//! Check 8: the arm without springs, dampers, gravity and contacts keeps its energy.

use nalgebra::DVector;
use underbrush_oracles::numeric::log_log_slope;
use underbrush_recording::{FRAME_PERIOD_S, Pose};
use underbrush_sim::simulation::JointState;
use underbrush_sim::{Arm, Clutter, PhysicsOptions};

use crate::pressed_arm::simulation;
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 8.
pub const CHECK: Check = Check {
    name: "free-arm",
    summary: "The free arm, without springs, dampers, gravity or contacts, conserves energy; with springs and dampers it never gains any",
    cases: &[
        Case { compare: free, falsifications: &[DAMPERS_LEFT_ON, LONG_STEP] },
        Case { compare: sprung, falsifications: &[DRIVING_DAMPERS] },
    ],
};

const DAMPERS_LEFT_ON: Falsification =
    Falsification::new("dampers of the simulated joints", "1e-4 N m s/rad instead of none").breaking(&["after 5 s"]);
const LONG_STEP: Falsification =
    Falsification::new("the shortest step of the engine", "twice as long").breaking(&["order in the step"]);
const DRIVING_DAMPERS: Falsification = Falsification::new("sign of the simulated joints' dampers", "negative");

const STEP_S: f64 = 1e-3;
const SECONDS: f64 = 5.0;
/// Joint velocities of a typical reach, rad/s.
const VELOCITY_RAD_PER_S: [f64; 7] = [0.3, -0.2, 0.4, -0.3, 0.5, 0.3, -0.4];

fn free(simulated: Simulated) -> Found {
    let mut arm = Arm::cody()?;
    for joint in &mut arm.joints {
        joint.stiffness_nm_per_rad = 0.0;
        joint.damping_nm_s_per_rad = simulated.with(DAMPERS_LEFT_ON, 0.0, 1e-4);
    }
    let mut rises = Vec::new();
    for share in [1.0, 0.5, 0.25] {
        let wrong = if share < 0.5 { simulated.with(LONG_STEP, 1.0, 2.0) } else { 1.0 };
        let energies = energies_j(arm.clone(), STEP_S * share * wrong)?;
        rises.push((share, largest_rise_share(&energies)));
    }
    let energies = energies_j(arm, STEP_S)?;
    let (start, end) = (energies[0], energies[energies.len() - 1]);
    let rise = "order in the step of the largest rise of the free arm's energy in one step";
    let reason = "0.2: fit of a straight line on a log-log scale. Coriolis forces are those of the start of the step, so \
                  their work has an error of either sign that is second order in the step";
    Ok(vec![
        Comparison::of("energy of the free arm after 5 s, step 1 ms", "J", start, end)
            .relative(1e-3, "0.1 %: the integrator is first order; joints rotate by half a milliradian in a step"),
        Comparison::of(rise, "", 2.0, log_log_slope(&rises)).absolute(0.2, reason),
    ])
}

/// The arm as it is, but a hundred times less damped, so that it vibrates through all five seconds.
fn sprung(simulated: Simulated) -> Found {
    let mut arm = Arm::cody()?;
    for joint in &mut arm.joints {
        joint.damping_nm_s_per_rad /= simulated.with(DRIVING_DAMPERS, 100.0, -100.0);
    }
    let quantity = "largest rise of the energy of the arm on its springs in one step, over the initial energy";
    let rise = largest_rise_share(&energies_j(arm, STEP_S)?);
    Ok(vec![Comparison::of(quantity, "", 0.0, rise).at_most(1e-9, "1e-9: rounding only")])
}

/// The largest rise of the energy in one step, over the initial energy.
fn largest_rise_share(energies_j: &[f64]) -> f64 {
    let rises = energies_j.windows(2).map(|pair| pair[1] - pair[0]);
    rises.fold(f64::NEG_INFINITY, f64::max) / energies_j[0]
}

/// Energy, J, at the start and after each step, of an arm that is released in its start posture with some velocity.
fn energies_j(mut arm: Arm, step_s: f64) -> Result<Vec<f64>, Fault> {
    for joint in &mut arm.joints {
        joint.limits_rad = [f64::NEG_INFINITY, f64::INFINITY];
    }
    let physics = PhysicsOptions { step_s, gravity_m_per_s2: 0.0 };
    let posture = arm.start_posture_rad();
    let mut simulation = simulation(arm, Clutter::default(), physics);
    simulation.set_joint_velocity(&VELOCITY_RAD_PER_S);
    let start = simulation.report();
    let mut energies = vec![energy_j(simulation.arm(), &start.joints, &start.link_pose_world)];
    for _ in 0..(SECONDS / FRAME_PERIOD_S).round() as usize {
        simulation.step_observed(&posture, &mut |step| {
            energies.push(energy_j(step.arm, step.joints, step.link_pose_world));
        });
    }
    Ok(energies)
}

/// Energy of the joints' springs, which rest in the start posture, of the links and of the drives' reflected inertia,
/// J, from joint angles and velocities alone.
fn energy_j(arm: &Arm, joints: &[JointState], link_poses: &[Pose]) -> f64 {
    let velocity = DVector::from_iterator(joints.len(), joints.iter().map(|joint| joint.velocity_rad_per_s));
    let mut energy = 0.0;
    for (index, link) in arm.links.iter().enumerate().skip(1) {
        let pose = &link_poses[index];
        let center = pose.transform_point(link.center_of_mass_link);
        let speed = arm.position_jacobian(link_poses, index, center) * &velocity;
        let rotation = arm.angular_jacobian(link_poses, index) * &velocity;
        let rotation_link = pose.inverse_transform_vector(glam::DVec3::new(rotation[0], rotation[1], rotation[2]));
        energy += 0.5 * (link.mass_kg * speed.norm_squared() + rotation_link.dot(link.inertia_link * rotation_link));
    }
    for (joint, state) in arm.joints.iter().zip(joints) {
        energy += 0.5 * joint.armature_kg_m2 * state.velocity_rad_per_s.powi(2);
        energy += 0.5 * joint.stiffness_nm_per_rad * (state.angle_rad - joint.start_rad).powi(2);
    }
    energy
}
