//! Check 5: the forces on taxels add up to the solver's forces, and bodies push each other with equal forces.

use glam::DVec3;
use underbrush_recording::{BodyPart, BodyShape, Pose};
use underbrush_sim::simulation::test_rig::{BodyId, FreeBody, Rig};
use underbrush_sim::{Arm, PhysicsOptions, Surface};

use crate::pressed_arm::{Beside, OPTIONS, PressedArm, friction_of, scale_friction};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 5.
pub const CHECK: Check = Check {
    name: "skin-forces",
    summary: "Taxel forces add up to the solver's force and moment and stay in their friction cones; colliding bodies \
              exchange equal and opposite momentum",
    cases: &[
        Case { compare: taxels, falsifications: &[SHIFTED_TAXELS, ROUGH_CONTACT] },
        Case { compare: collision, falsifications: &[GRAVITY_LEFT_ON] },
    ],
};

const SHIFTED_TAXELS: Falsification = Falsification::new("numbers of the simulated skin's taxels", "one column off")
    .breaking(&["forces of taxels", "moment about the link"]);
const ROUGH_CONTACT: Falsification =
    Falsification::new("friction between the simulated forearm and trunk", "twice what the arm's file says")
        .breaking(&["largest shear"]);
const GRAVITY_LEFT_ON: Falsification =
    Falsification::new("gravity of the simulated collision", "9.81 m/s² instead of none");

/// Half the larger pitch of Cody's forearm: 15.9° on 46.04 mm.
const HALF_PITCH_M: f64 = 0.0064;

/// The worst values over some frames.
#[derive(Default)]
struct Worst {
    force: f64,
    moment_m: f64,
    slip: f64,
    frames: usize,
}

fn taxels(simulated: Simulated) -> Found {
    let wrong = |arm: &mut Arm| {
        scale_friction(arm, simulated.with(ROUGH_CONTACT, 1.0, 2.0));
        for patch in &mut arm.skin.layout.patches {
            patch.taxels.rotate_left(simulated.with(SHIFTED_TAXELS, 0, 1));
        }
    };
    let mut pressed = PressedArm::new(Beside::trunk(), OPTIONS, wrong)?;
    let friction = friction_of(&pressed.arm);
    let push = pressed.pressing_rad(6.0);
    let poses = pressed.arm.forward_kinematics(&pressed.posture_rad);
    let place = poses[pressed.forearm].transform_point(pressed.place_link);
    let drag = pressed.jacobian(&poses, place).transpose() * nalgebra::Vector3::new(8.0, 0.0, 0.0);
    let mut worst = Worst::default();
    pressed.hold(&push, 1.0);
    for frame in 0..400 {
        // Back and forth along the trunk, so that friction reaches its cone in both directions.
        let share = (f64::from(frame) * 0.03).sin();
        let joints = push.iter().zip(&pressed.arm.joints).zip(drag.iter());
        let equilibrium: Vec<f64> =
            joints.map(|((angle, joint), torque)| angle + share * torque / joint.stiffness_nm_per_rad).collect();
        pressed.hold(&equilibrium, 0.01);
        observe(&pressed, friction, &mut worst);
    }
    if worst.frames < 100 {
        return Err(Fault::Run(format!("contact in {} frames only", worst.frames)));
    }
    let half_pitch = "half the pitch between columns: a taxel measures how much presses on it, not where";
    let moment = "moment about the link of taxels against contacts, largest difference over the force";
    let cones = "1e-6: the cones hold up to rounding, the contact's friction up to the solver's convergence";
    Ok(vec![
        Comparison::of("forces of taxels against contacts, largest relative difference", "", 0.0, worst.force)
            .absolute(1e-9, "1e-9: the skin conserves force up to rounding"),
        Comparison::of(moment, "m", 0.0, worst.moment_m).absolute(HALF_PITCH_M, half_pitch),
        Comparison::of("largest shear of a taxel, relative to its friction cone", "", 1.0, worst.slip)
            .at_most(1e-6, cones),
    ])
}

/// Compares the taxel forces of the forearm with the contacts.
fn observe(pressed: &PressedArm, friction: f64, worst: &mut Worst) {
    let report = pressed.report();
    let pose = &report.link_pose_world[pressed.forearm];
    let readings = pressed.forearm_taxels();
    let (mut felt, mut felt_moment) = (DVec3::ZERO, DVec3::ZERO);
    let mut slip: f64 = 0.0;
    for reading in readings.clone() {
        let patch = &pressed.arm.skin.layout.patches[usize::from(reading.patch)];
        let taxel = &patch.taxels[usize::from(reading.taxel)];
        let [first, second] = reading.true_shear_force_n;
        let shear = taxel.tangent_link * first + taxel.normal_link.cross(taxel.tangent_link) * second;
        let force = shear - taxel.normal_link * reading.true_normal_force_n;
        felt += force;
        felt_moment += taxel.position_link.cross(force);
        slip = slip.max(shear.length() / (friction * reading.true_normal_force_n));
    }
    let (mut solver, mut solver_moment) = (DVec3::ZERO, DVec3::ZERO);
    for contact in &report.contacts {
        let force = pose.inverse_transform_vector(contact.force_world);
        solver += force;
        solver_moment += contact.position_link.cross(force);
    }
    // A light touch on one or two taxels may lie outside the cones of both.
    if solver.length() < 0.5 {
        return;
    }
    worst.frames += 1;
    worst.force = worst.force.max(felt.distance(solver) / solver.length());
    worst.moment_m = worst.moment_m.max(felt_moment.distance(solver_moment) / solver.length());
    if readings.count() > 2 {
        worst.slip = worst.slip.max(slip);
    }
}

/// A ball meets a box off its centre, both free.
fn collision(simulated: Simulated) -> Found {
    let gravity_m_per_s2 = simulated.with(GRAVITY_LEFT_ON, 0.0, 9.81);
    let mut rig = Rig::new(PhysicsOptions { gravity_m_per_s2, ..OPTIONS });
    let mut body = |position: DVec3, velocity_world: DVec3, mass_kg: f64, shape: BodyShape| {
        let part = BodyPart { shape, pose_body: Pose::IDENTITY };
        let resting = FreeBody::resting(part, mass_kg, Surface::hard(0.4), Pose::from_position(position));
        rig.add_free(&FreeBody { velocity_world, ..resting })
    };
    let ball = BodyShape::Sphere { radius_m: 0.05 };
    let cuboid = BodyShape::Box { size_m: DVec3::new(0.1, 0.12, 0.14) };
    let bodies = [
        body(DVec3::new(-0.15, 0.01, 0.0), DVec3::new(0.5, 0.2, 0.1), 0.262, ball),
        body(DVec3::ZERO, DVec3::ZERO, 0.84, cuboid),
    ];
    let momentum =
        |rig: &Rig, body: Option<BodyId>| body.map_or(DVec3::NAN, |body| rig.velocity_world(body) * rig.mass_kg(body));
    let before = bodies.map(|body| momentum(&rig, body));
    rig.step_times(200);
    let after = bodies.map(|body| momentum(&rig, body));
    // What ball and box lose together, relative to what the ball gave away.
    let lost = (after[0] + after[1] - before[0] - before[1]).length() / before[0].distance(after[0]);
    let lost =
        Comparison::of("total momentum lost in a glancing collision, over the momentum exchanged", "", 0.0, lost);
    Ok(vec![lost.absolute(1e-12, "1e-12: the same impulse acts on both bodies, up to rounding")])
}
