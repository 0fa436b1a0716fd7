//! Check 7: dry friction.

use glam::{DQuat, DVec3};
use underbrush_oracles::numeric::bisected;
use underbrush_oracles::statics;
use underbrush_recording::{BodyShape, Pose};
use underbrush_sim::object::structure::part;
use underbrush_sim::simulation::test_rig::{FreeBody, Rig};
use underbrush_sim::{Arm, Surface};

use crate::pressed_arm::{Beside, GRAVITY_M_PER_S2, OPTIONS, PressedArm, SLIDING_M_PER_S, friction_of, scale_friction};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 7.
pub const CHECK: Check = Check {
    name: "friction",
    summary: "A box slips at a slope of atan μ and slides with Coulomb friction; the shear on a taxel never exceeds μ times its normal force",
    cases: &[
        Case { compare: boxes, falsifications: &[SMOOTH_BOX] },
        Case { compare: every_direction, falsifications: &[SMOOTH_FLOOR] },
        Case { compare: sliding_forearm, falsifications: &[ROUGH_FOREARM, TILTED_AXIS] },
    ],
};

const SMOOTH_BOX: Falsification = Falsification::new("friction of the simulated box", "10 % too low");
const SMOOTH_FLOOR: Falsification = Falsification::new(
    "friction under the simulated box that slides in twelve directions",
    "10 % too low, and a floor that slopes by 1 %",
);
const ROUGH_FOREARM: Falsification =
    Falsification::new("friction between the simulated forearm and trunk", "twice what the arm's file says")
        .breaking(&["largest shear", "dragged"]);
const TILTED_AXIS: Falsification = Falsification::new(
    "axis of the simulated arm's first joint",
    "tilted by 10°, so that the forearm slides another way",
)
.breaking(&["share of the friction force"]);

const FRICTION: f64 = 0.4;

fn boxes(simulated: Simulated) -> Found {
    let friction = FRICTION * simulated.with(SMOOTH_BOX, 1.0, 0.9);
    let mut comparisons = Vec::new();
    for (name, may_rotate) in [("box that cannot rotate", false), ("free box", true)] {
        let expected = statics::slip_angle_rad(FRICTION).to_degrees();
        // A box that still slides after one second counts as slipping. At the bound of 5 mm/s, the slope is 0.03° too
        // steep.
        let slides = |slope| sliding_speeds(slope, friction, may_rotate).last().is_some_and(|speed| *speed > 5e-3);
        let found = bisected([0.1, 0.8], 12, |slope| !slides(slope)).to_degrees();
        let slope = Comparison::of(format!("slope at which a {name} slips"), "deg", expected, found);
        let reason = "0.5°: the bisection ends at 0.01°; slip and creep are told apart within one second";
        comparisons.push(slope.absolute(0.5, reason));
        for slope_deg in [30.0_f64, 45.0] {
            let slope = slope_deg.to_radians();
            let speeds = sliding_speeds(slope, friction, may_rotate);
            // The first half second lets the contact settle.
            let half = speeds.len() / 2;
            let seconds = (speeds.len() - 1 - half) as f64 * OPTIONS.step_s;
            let quantity = format!("acceleration of a {name} at {slope_deg}°");
            let expected = statics::sliding_acceleration_m_per_s2(GRAVITY_M_PER_S2, slope, FRICTION);
            let found = (speeds[speeds.len() - 1] - speeds[half]) / seconds;
            let reason = "1 %: a constant force has no discretization error; what remains is the solver's residual";
            comparisons.push(Comparison::of(quantity, "m/s²", expected, found).relative(1e-2, reason));
        }
    }
    Ok(comparisons)
}

/// The forearm sliding along a trunk: the largest shear on a taxel over μ times its normal force, the share of the
/// friction that opposes the slip, and the normal force that balances the joints.
fn sliding_forearm(simulated: Simulated) -> Found {
    const FRAMES: u32 = 50;
    // From this frame on the arm hardly speeds up any more.
    const STEADY: u32 = 40;
    let wrong = |arm: &mut Arm| {
        scale_friction(arm, simulated.with(ROUGH_FOREARM, 1.0, 2.0));
        let axis = &mut arm.joints[0].axis_child;
        *axis = axis.rotate_x(simulated.with(TILTED_AXIS, 0.0, 10.0_f64.to_radians()));
    };
    let mut pressed = PressedArm::new(Beside::trunk(), OPTIONS, wrong)?;
    let friction = friction_of(&pressed.arm);
    let mut equilibrium = pressed.pressing_rad(6.0);
    pressed.hold(&equilibrium, 1.0);
    let (mut largest, mut opposed, mut whole) = (0.0_f64, 0.0, 0.0);
    let (mut pressing_n, mut balancing_n) = (0.0, 0.0);
    for frame in 0..FRAMES {
        // The upper arm keeps moving and draws the forearm along the trunk.
        equilibrium[0] += 0.004;
        pressed.hold(&equilibrium, 0.01);
        for taxel in pressed.forearm_taxels() {
            let [first, second] = taxel.true_shear_force_n;
            if taxel.true_normal_force_n > 0.0 {
                largest = largest.max(first.hypot(second) / (friction * taxel.true_normal_force_n));
            }
        }
        for contact in &pressed.report().contacts {
            let slip = pressed.velocity_world(contact.link, contact.position_link);
            let along = slip.reject_from_normalized(contact.inward_world);
            let rubbing = contact.force_world.reject_from_normalized(contact.inward_world);
            if along.length() > SLIDING_M_PER_S {
                opposed -= rubbing.dot(along.normalize());
                whole += rubbing.length();
            }
        }
        let balance = pressed.normal_force_n(&equilibrium, friction);
        if let Some((pressing, balancing)) = balance.filter(|_| frame >= STEADY) {
            pressing_n += pressing;
            balancing_n += balancing;
        }
    }
    let balanced =
        "forearm dragged along a trunk, normal force that balances springs and dampers with Coulomb friction";
    let (expected, found) = (balancing_n / f64::from(FRAMES - STEADY), pressing_n / f64::from(FRAMES - STEADY));
    let reason =
        "2 %: the closed form leaves out the arm's inertia, whose share falls from 8 % to 1 % while the arm speeds up";
    Ok(vec![
        Comparison::of("sliding forearm, largest shear of a taxel over μ times its normal force", "", 1.0, largest)
            .at_most(1e-6, "1e-6: Coulomb's bound, up to rounding"),
        Comparison::of("sliding forearm, share of the friction force that opposes the slip", "", 1.0, opposed / whole)
            .absolute(1e-3, "0.1 %: friction opposes the slip, whose direction changes a little within a frame"),
        Comparison::of(balanced, "N", expected, found).relative(0.02, reason),
    ])
}

/// A free box that slides over a level floor in twelve directions: its slowest and fastest deceleration, and the
/// largest angle between friction and slip.
fn every_direction(simulated: Simulated) -> Found {
    const SPEED_M_PER_S: f64 = 1.0;
    const STEPS: u32 = 20;
    let surface = Surface::hard(FRICTION * simulated.with(SMOOTH_FLOOR, 1.0, 0.9));
    let slope_rad = simulated.with(SMOOTH_FLOOR, 0.0, 0.01);
    let (mut farthest_rad, mut slowest, mut fastest) = (0.0_f64, f64::INFINITY, 0.0_f64);
    for hour in 0..12 {
        let direction = DVec3::X.rotate_z(f64::from(hour) * std::f64::consts::PI / 6.0 + 0.1);
        let mut rig = Rig::new(OPTIONS);
        let floor = part(BodyShape::Box { size_m: DVec3::new(10.0, 10.0, 0.1) }, DVec3::Z * -0.05);
        rig.add_fixed(&floor, surface, &Pose::from_orientation(DQuat::from_rotation_y(slope_rad)));
        let block = part(BodyShape::Box { size_m: DVec3::new(0.12, 0.1, 0.02) }, DVec3::ZERO);
        let resting = FreeBody::resting(block, 0.5, surface, Pose::from_position(DVec3::Z * 0.01));
        let sliding = rig.add_free(&FreeBody { velocity_world: direction * SPEED_M_PER_S, ..resting });
        let sliding = sliding.ok_or_else(|| Fault::Run("a box without volume".into()))?;
        rig.step_times(STEPS);
        let before = rig.velocity_world(sliding).with_z(0.0);
        rig.step_times(STEPS);
        let change = before - rig.velocity_world(sliding).with_z(0.0);
        farthest_rad = farthest_rad.max(change.angle_between(direction));
        let deceleration = change.length() / (f64::from(STEPS) * OPTIONS.step_s);
        (slowest, fastest) = (slowest.min(deceleration), fastest.max(deceleration));
    }
    let expected = FRICTION * GRAVITY_M_PER_S2;
    let reason = "1 %: as on a slope";
    let angle = "box that slides in twelve directions, largest angle between friction and slip";
    Ok(vec![
        Comparison::of(angle, "deg", 0.0, farthest_rad.to_degrees())
            .at_most(0.1, "0.1°: the solver's residual, 1e-6 of the force, and a little rotation of the box"),
        Comparison::of("box that slides in twelve directions, slowest deceleration", "m/s²", expected, slowest)
            .relative(0.01, reason),
        Comparison::of("box that slides in twelve directions, fastest deceleration", "m/s²", expected, fastest)
            .relative(0.01, reason),
    ])
}

/// Speed of a box down a slope after each step within one second, m/s.
fn sliding_speeds(slope_rad: f64, friction: f64, may_rotate: bool) -> Vec<f64> {
    let surface = Surface::hard(friction);
    let mut rig = Rig::new(OPTIONS);
    let tilt = Pose::from_orientation(DQuat::from_rotation_y(slope_rad));
    let plate = part(BodyShape::Box { size_m: DVec3::new(10.0, 1.0, 0.1) }, DVec3::Z * -0.05);
    rig.add_fixed(&plate, surface, &tilt);
    let block = part(BodyShape::Box { size_m: DVec3::new(0.12, 0.1, 0.04) }, DVec3::ZERO);
    let resting = FreeBody::resting(block, 0.5, surface, tilt * Pose::from_position(DVec3::Z * 0.02));
    let sliding = rig.add_free(&FreeBody { may_rotate, ..resting });
    let down = tilt.transform_vector(DVec3::X);
    (0..(1.0 / OPTIONS.step_s).round() as usize)
        .map(|_| {
            rig.step();
            sliding.map_or(f64::NAN, |body| rig.velocity_world(body).dot(down))
        })
        .collect()
}
