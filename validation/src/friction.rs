//! Check 7: dry friction.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_oracles::statics;
use underbrush_sim::arm::Arm;
use underbrush_sim::object::FRICTION as TRUNK_FRICTION;
use underbrush_sim::object::trunk::Trunk;
use underbrush_sim::physics::{Physics, PhysicsOptions};
use underbrush_sim::skin::SkinPatch;

use crate::pressed_arm::{self, PressedArm};
use crate::{Breaks, Case, Check, CheckError, Comparison, Falsification, Simulated};

/// Check 7.
pub const CHECK: Check = Check {
    number: 7,
    name: "friction",
    summary: "A box slips at the slope atan μ and slides as Coulomb says; no taxel is sheared by more than μ times its pressure",
    cases: &[
        Case {
            compare: boxes,
            falsifications: &[SMOOTH_BOX],
        },
        Case {
            compare: sliding_forearm,
            falsifications: &[ROUGH_FOREARM],
        },
    ],
};

const SMOOTH_BOX: Falsification = Falsification {
    wrong: "friction of the simulated box",
    by: "10 % too low",
    breaks: Breaks::Every,
};
const ROUGH_FOREARM: Falsification = Falsification {
    wrong: "friction between the simulated forearm and trunk",
    by: "twice what the arm's file says",
    breaks: Breaks::Every,
};

const GRAVITY_M_PER_S2: f64 = 9.81;
const FRICTION: f64 = 0.4;
const OPTIONS: PhysicsOptions = PhysicsOptions {
    step_s: 0.005,
    substeps: 4,
    gravity_m_per_s2: GRAVITY_M_PER_S2,
};

fn boxes(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let friction = FRICTION * simulated.with(SMOOTH_BOX, 1.0, 0.9);
    let mut comparisons = Vec::new();
    for (name, may_turn) in [("box that cannot turn", false), ("free box", true)] {
        comparisons.push(Comparison::absolute(
            format!("slope at which a {name} slips"),
            "deg",
            statics::slip_angle_rad(FRICTION).to_degrees(),
            slip_slope_rad(friction, may_turn).to_degrees(),
            0.5,
            "0.5°: the search ends at 0.01°; a slip is told from creep within a second",
        ));
        for slope_deg in [30.0_f64, 45.0] {
            let slope = slope_deg.to_radians();
            let speeds = sliding_speeds(slope, friction, may_turn);
            // The first half second lets the soft contact settle.
            let half = speeds.len() / 2;
            let seconds = (speeds.len() - 1 - half) as f64 * OPTIONS.step_s;
            comparisons.push(Comparison::relative(
                format!("acceleration of a {name} at {slope_deg}°"),
                "m/s²",
                statics::sliding_acceleration_m_per_s2(GRAVITY_M_PER_S2, slope, FRICTION),
                (speeds[speeds.len() - 1] - speeds[half]) / seconds,
                1e-2,
                "1 %: a constant force has no error of the step; what remains is the solver's, shared by four points",
            ));
        }
    }
    Ok(comparisons)
}

/// The forearm sliding along a trunk: the largest shear on a taxel over μ times its normal force, and how far the arm's
/// friction is from opposing the slip.
fn sliding_forearm(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let arm = Arm::cody()?;
    // The engine's rule for two surfaces: the mean.
    let friction = 0.5 * (arm.friction + TRUNK_FRICTION);
    let trunk = Trunk {
        diameter_m: 0.03,
        height_m: 0.6,
    };
    let mut pressed = PressedArm::new(arm.clone(), arm, Box::new(trunk), 0.017, 0.3, pressed_arm::OPTIONS)?;
    pressed.scale_friction(simulated.with(ROUGH_FOREARM, 1.0, 2.0));
    let patches = SkinPatch::of_arm(&pressed.arm);
    let mut equilibrium = pressed.pressing_rad(6.0);
    pressed.hold(&equilibrium, 1.0);
    let (mut largest, mut opposed, mut whole) = (0.0_f64, 0.0, 0.0);
    for _ in 0..50 {
        // The upper arm swings on: the forearm is drawn along the trunk.
        equilibrium[0] += 0.004;
        pressed.hold(&equilibrium, 0.01);
        for (patch, contacts, collider) in pressed.touched(&patches) {
            let shape = &pressed.world.physics.colliders[collider];
            let pose = pressed.world.link_pose(patch.link).inverse() * recorded(shape.position());
            for force in patch.spread(&contacts, shape.shape(), &pose) {
                largest = largest.max(force.shear_link.length() / (friction * force.normal_force_n));
            }
        }
        for contact in pressed.world.contacts() {
            let slip = pressed.velocity_world(contact.link, contact.position_link);
            let along = slip.reject_from_normalized(contact.inward_world);
            let rubbing = contact.force_world.reject_from_normalized(contact.inward_world);
            // Slower than this it may stick.
            if along.length() > 5e-3 {
                opposed -= rubbing.dot(along.normalize());
                whole += rubbing.length();
            }
        }
    }
    Ok(vec![
        Comparison::at_most(
            "sliding forearm, largest shear of a taxel over μ times its pressure",
            "",
            1.0,
            largest,
            1e-6,
            "1e-6: Coulomb's bound, but for rounding",
        ),
        Comparison::absolute(
            "sliding forearm, share of the friction that opposes the slip",
            "",
            1.0,
            opposed / whole,
            1e-2,
            "1 %: friction opposes the slip; the slip turns a little within a frame",
        ),
    ])
}

/// A pose of the engine's.
fn recorded(pose: &Pose) -> underbrush_recording::Pose {
    underbrush_recording::Pose::new(pose.translation, pose.rotation)
}

/// The slope at which a box begins to slide, by bisection.
fn slip_slope_rad(friction: f64, may_turn: bool) -> f64 {
    let (mut holds, mut slips) = (0.1, 0.8);
    for _ in 0..12 {
        let slope = 0.5 * (holds + slips);
        // What still slides after a second slips: 5 mm/s is a slope 0.03° too steep.
        let speeds = sliding_speeds(slope, friction, may_turn);
        if speeds.last().is_some_and(|speed| *speed > 5e-3) {
            slips = slope;
        } else {
            holds = slope;
        }
    }
    0.5 * (holds + slips)
}

/// Speed of a box down a slope after each step of one second, m/s.
fn sliding_speeds(slope_rad: f64, friction: f64, may_turn: bool) -> Vec<f64> {
    let mut physics = Physics::new(OPTIONS);
    let tilt = Pose::rotation(DVec3::Y * slope_rad);
    let ground = physics.bodies.insert(RigidBodyBuilder::fixed().pose(tilt));
    let plate = ColliderBuilder::cuboid(5.0, 0.5, 0.05)
        .translation(DVec3::Z * -0.05)
        .friction(friction);
    physics.colliders.insert_with_parent(plate, ground, &mut physics.bodies);
    let pose = tilt * Pose::translation(0.0, 0.0, 0.02);
    let sliding = physics.bodies.insert(
        RigidBodyBuilder::dynamic()
            .pose(pose)
            .enabled_rotations(may_turn, may_turn, may_turn)
            .can_sleep(false),
    );
    let shape = ColliderBuilder::cuboid(0.06, 0.05, 0.02).mass(0.5).friction(friction);
    physics
        .colliders
        .insert_with_parent(shape, sliding, &mut physics.bodies);
    let down = tilt.transform_vector(DVec3::X);
    (0..(1.0 / OPTIONS.step_s).round() as usize)
        .map(|_| {
            physics.step();
            physics.bodies[sliding].linvel().dot(down)
        })
        .collect()
}
