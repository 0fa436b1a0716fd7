//! Check 9: a step of one joint's equilibrium angle.

use underbrush_oracles::oscillator::Oscillator;
use underbrush_sim::arm::Arm;
use underbrush_sim::arm::engine::insert_arm;
use underbrush_sim::physics::{Physics, PhysicsOptions, groups};

use crate::leaf_case::measure_vibration;
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 9.
pub const CHECK: Check = Check {
    number: 9,
    name: "joint-step",
    summary: "A step of a compliant joint's equilibrium angle gives the second-order response",
    falsification: "stiffness of the simulated joint 5 % too high",
    compare,
};

const STEP_S: f64 = 1e-4;
const SECONDS: f64 = 3.0;
const TARGET_RAD: f64 = 0.1;
/// Cody's shoulder is nearly critically damped; a tenth of that shows the period.
const DAMPING_RATIO: f64 = 0.1;

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    // The shoulder and the link on it, alone; the posture does not matter to a single joint.
    let mut arm = Arm::cody()?;
    arm.joints.truncate(1);
    arm.links.truncate(2);
    arm.tip_link = 1;
    let (joint, link) = (&mut arm.joints[0], &arm.links[1]);
    let lever = link.center_of_mass_link - joint.axis_child * joint.axis_child.dot(link.center_of_mass_link);
    let inertia = joint.axis_child.dot(link.inertia_link * joint.axis_child)
        + link.mass_kg * lever.length_squared()
        + joint.armature_kg_m2;
    let stiffness = joint.stiffness_nm_per_rad;
    joint.damping_nm_s_per_rad = DAMPING_RATIO * 2.0 * (stiffness * inertia).sqrt();
    joint.limits_rad = [f64::NEG_INFINITY, f64::INFINITY];
    let expected = Oscillator::new(inertia, stiffness, joint.damping_nm_s_per_rad);
    joint.stiffness_nm_per_rad *= simulated.with(1.0, 1.05);

    let mut physics = Physics::new(PhysicsOptions {
        step_s: STEP_S,
        substeps: 1,
        gravity_m_per_s2: 0.0,
    });
    let handles = insert_arm(&arm, &[0.0], &mut physics, groups::arm());
    let mut response = Vec::new();
    for _ in 0..(SECONDS / STEP_S) as usize {
        handles.set_equilibrium(&arm, &[TARGET_RAD], &mut physics);
        physics.step();
        response.extend(
            handles
                .joint_angle_rad(&physics)
                .first()
                .map(|angle| angle / TARGET_RAD - 1.0),
        );
    }
    let stepped = expected.under_implicit_euler(STEP_S);
    let (frequency, _) = measure_vibration(&response, STEP_S)?;
    let overshoot = response.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let largest_miss = response
        .iter()
        .enumerate()
        .map(|(index, found)| (found + 1.0 - stepped.step_response((index + 1) as f64 * STEP_S)).abs())
        .fold(0.0, f64::max);
    Ok(vec![
        Comparison::relative(
            "period",
            "s",
            expected.period_s(),
            std::f64::consts::TAU / frequency,
            5e-3,
            "0.5 %: the implicit step changes it by (ω Δt)², 6e-5; zeros are read between steps",
        ),
        Comparison::relative(
            "overshoot, in steps",
            "",
            stepped.overshoot(),
            overshoot,
            5e-3,
            "0.5 %: the closed form of the implicit Euler step, which adds ω Δt / 2 to the damping ratio; first order left",
        ),
        Comparison::absolute(
            "largest miss of the whole response, in steps",
            "",
            0.0,
            largest_miss,
            1e-2,
            "1 %: against the same; the first step acts ω Δt too early",
        ),
    ])
}
