//! Check 9: a step of one joint's equilibrium angle.

use underbrush_oracles::oscillator::Oscillator;
use underbrush_recording::FRAME_PERIOD_S;
use underbrush_sim::{Arm, Clutter, PhysicsOptions};

use crate::leaf_case::measure_vibration;
use crate::pressed_arm;
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 9.
pub const CHECK: Check = Check {
    name: "joint-step",
    summary: "A step of a compliant joint's equilibrium angle gives the second-order response",
    cases: &[Case { compare, falsifications: &[STIFF_JOINT] }],
};

/// The joint's spring is stiffer than the arm's file says.
pub const STIFF_JOINT: Falsification = Falsification::new("stiffness of the simulated joint", "5 % too high");

const STEP_S: f64 = 1e-4;
const SECONDS: f64 = 1.0;
const TARGET_RAD: f64 = 0.1;
/// Cody's shoulder is nearly critically damped. With a tenth of that damping, the response shows a period.
const DAMPING_RATIO: f64 = 0.1;

fn compare(simulated: Simulated) -> Found {
    let response = respond(simulated, STEP_S)?;
    let expected = response.exact;
    let about_target: Vec<f64> = response.angles.iter().map(|angle| angle - 1.0).collect();
    let (frequency, _) = measure_vibration(&about_target, STEP_S)?;
    let overshoot = about_target.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let reason = "1e-4: the implicit midpoint rule is of second order; a step is 8e-3 rad of the oscillation";
    Ok(vec![
        Comparison::of("period", "s", expected.period_s(), std::f64::consts::TAU / frequency)
            .relative(5e-3, "0.5 %: zero crossings are interpolated between steps"),
        Comparison::of("overshoot, relative to the step", "", expected.overshoot(), overshoot).relative(1e-4, reason),
        Comparison::of("largest error of the whole response, relative to the step", "", 0.0, response.largest_miss)
            .absolute(1e-4, "1e-4: the same"),
    ])
}

/// A simulated step response and the oscillator that it should match.
pub struct Response {
    /// The oscillator of the closed form.
    pub exact: Oscillator,
    /// Angle after each step, in units of the target.
    angles: Vec<f64>,
    /// Largest distance from the closed form, in units of the target.
    pub largest_miss: f64,
}

/// Simulates the response of the shoulder, with only the link on it, to a step of its equilibrium angle.
pub fn respond(simulated: Simulated, step_s: f64) -> Result<Response, Fault> {
    // The posture does not matter for a single joint.
    let mut arm = Arm::cody()?;
    arm.joints.truncate(1);
    arm.links.truncate(2);
    arm.end_effector_link = 1;
    let (joint, link) = (&mut arm.joints[0], &arm.links[1]);
    let lever = link.center_of_mass_link - joint.axis_child * joint.axis_child.dot(link.center_of_mass_link);
    let inertia = joint.axis_child.dot(link.inertia_link * joint.axis_child)
        + link.mass_kg * lever.length_squared()
        + joint.armature_kg_m2;
    let stiffness = joint.stiffness_nm_per_rad;
    joint.damping_nm_s_per_rad = DAMPING_RATIO * 2.0 * (stiffness * inertia).sqrt();
    joint.limits_rad = [f64::NEG_INFINITY, f64::INFINITY];
    let exact = Oscillator::new(inertia, stiffness, joint.damping_nm_s_per_rad);
    joint.stiffness_nm_per_rad *= simulated.with(STIFF_JOINT, 1.0, 1.05);

    // The joint starts at 0, so that angle / target is the step response.
    arm.joints[0].start_rad = 0.0;
    let physics = PhysicsOptions { step_s, gravity_m_per_s2: 0.0 };
    let mut simulation = pressed_arm::simulation(arm, Clutter::default(), physics);
    let mut angles = Vec::new();
    for _ in 0..(SECONDS / FRAME_PERIOD_S).round() as usize {
        simulation.step_observed(&[TARGET_RAD], &mut |step| angles.push(step.joints[0].angle_rad / TARGET_RAD));
    }
    let miss = |(index, found): (usize, &f64)| (found - exact.step_response((index + 1) as f64 * step_s)).abs();
    let largest_miss = angles.iter().enumerate().map(miss).fold(0.0, f64::max);
    Ok(Response { exact, angles, largest_miss })
}
