//! Tests of the audit against closed forms.

use super::*;
use crate::sensor::{Sensor, SensorOptions};
use crate::simulation::Setup;
use crate::{Clutter, PhysicsOptions};

/// Cody's arm with nothing around it.
fn free_arm(step_s: f64) -> Simulation {
    let arm = Arm::cody().unwrap();
    Simulation::new(Setup {
        sensor: Sensor::new(&SensorOptions::off(), &arm.skin, 0, "test", 0),
        arm,
        clutter: Clutter::default(),
        physics: PhysicsOptions { step_s, gravity_m_per_s2: 9.81 },
        dormancy: false,
    })
}

/// Tests the energy balance of the free arm after a step δ of its actuators: they do the work Σ ½ K δ², and once the
/// arm is at rest again, the dampers have taken all of it and the integrator nothing. The unexplained part is that of the
/// gyroscopic forces, which are those at the start of a step: it is of the first order.
#[test]
fn a_step_of_the_actuators_ends_in_the_dampers() {
    let mut found = Vec::new();
    for step_s in [0.005, 0.001, 0.00025] {
        let mut simulation = free_arm(step_s);
        let arm = simulation.arm().clone();
        let mut balance = EnergyBalance::new(&simulation);
        let shift = 0.05;
        let goal: Vec<f64> = arm.start_posture_rad().iter().map(|angle| angle + shift).collect();
        for _ in 0..800 {
            simulation.step_observed(&goal, &mut |step| balance.observe_step(step));
        }
        let sums = balance.sums;
        let stiffness: f64 = arm.joints.iter().map(|joint| joint.stiffness_nm_per_rad).sum();
        let work = 0.5 * stiffness * shift * shift;
        assert!((sums.actuators_j / work - 1.0).abs() < 1e-9, "{} J of {work} J", sums.actuators_j);
        assert!(sums.stored_j.abs() < 1e-3 * work, "{} J left", sums.stored_j);
        assert_eq!(sums.contacts_j, 0.0);
        assert!(sums.dampers_j > 0.0 && sums.integrator_j == 0.0);
        found.push(sums.residual_j() / work);
    }
    let [coarse, middle, fine] = found[..] else { panic!("three steps") };
    assert!(coarse.abs() < 1e-3 && fine.abs() < 0.5 * middle.abs(), "{found:?}");
}

/// Tests that every bound belongs to a known figure, and that every figure has one except the jump within a step: a
/// link that meets a trunk is stopped within one step.
#[test]
fn every_figure_has_its_bound() {
    let layout = Arm::cody().unwrap().skin.layout;
    let bounded: Vec<&str> = bounds(&layout).map(|bound| bound.field.name).collect();
    let unbounded: Vec<&str> =
        Audit::FIELDS.iter().map(|field| field.name).filter(|name| !bounded.contains(name)).collect();
    assert_eq!(unbounded, ["largest_step_force_jump_n"]);
    assert!(bounds(&layout).all(|bound| bound.max >= 0.0 && !bound.reason.is_empty()));
}

/// Tests that the bound of the moment and the smallest torque that is compared follow the arm. For Cody they are about
/// 4 cm, the spacing of the flipper's sparsest taxels, and 0.7 N m. A skin larger by a fifth raises the first by a
/// fifth, and dampers twice as strong double the second.
#[test]
fn bounds_follow_the_arm_and_its_skin() {
    let moment_m = |arm: &Arm| {
        let mut bounds = bounds(&arm.skin.layout);
        bounds.find(|bound| bound.field.name == "largest_moment_residual_m").unwrap().max - DEEPEST_M
    };
    let cody = Arm::cody().unwrap();
    assert!((moment_m(&cody) - 0.04).abs() < 0.005, "{}", moment_m(&cody));
    assert!((min_contact_torque_nm(&cody) - 0.7).abs() < 0.02);
    let mut larger = cody.clone();
    for taxel in larger.skin.layout.patches.iter_mut().flat_map(|patch| &mut patch.taxels) {
        taxel.position_link *= 1.2;
    }
    for joint in &mut larger.joints {
        joint.damping_nm_s_per_rad *= 2.0;
    }
    assert!((moment_m(&larger) / moment_m(&cody) - 1.2).abs() < 1e-12);
    let ratio = min_contact_torque_nm(&larger) / min_contact_torque_nm(&cody);
    assert!((ratio - 2.0).abs() < 1e-12);
    // The forearm's taxels alone are much closer to each other.
    let mut forearm = cody.clone();
    forearm.skin.layout.patches.truncate(1);
    assert!(moment_m(&forearm) < 0.015, "{}", moment_m(&forearm));
}

/// Tests that a figure that was NaN once stays NaN and is beyond its bound: those of the engine's steps, of the frames
/// and of the energy.
#[test]
fn nan_is_beyond_its_bound() {
    let mut simulation = free_arm(0.005);
    let posture = simulation.arm().start_posture_rad();
    let mut auditor = Auditor::new(&simulation);
    for wrong in [f64::NAN, 0.0] {
        simulation.step_observed(&posture, &mut |step| {
            let mut joints = step.joints.to_vec();
            joints[0].angle_rad += wrong;
            let step = StepReport { joints: &joints, contact_residual: wrong, missed_overlap_m: wrong, ..*step };
            auditor.observe_step(&step);
        });
        let mut report = simulation.report().clone();
        report.tactile.force_residual = wrong;
        report.tactile.moment_residual_m = wrong;
        auditor.observe_frame(simulation.arm(), &report);
    }
    let audit = auditor.audit();
    let beyond = bounds(&simulation.arm().skin.layout).filter(|bound| exceeds((bound.field.get)(&audit), bound.max));
    let beyond: Vec<&str> = beyond.map(|bound| bound.field.name).collect();
    let expected = [
        "largest_force_residual",
        "largest_moment_residual_m",
        "energy_residual",
        "integrator_energy_share",
        "largest_contact_residual",
        "overlap_without_patch_m",
    ];
    assert_eq!(beyond, expected);
}

/// Tests the jump of a force: the largest change of the summed and scaled force on one link, and NaN if a force is NaN.
#[test]
fn jumps_are_changes_of_a_links_force() {
    let contact = |link: usize, force: f64| StepContact {
        link,
        object: Some(0),
        body: 0,
        position_link: DVec3::ZERO,
        inward_world: DVec3::X,
        force_world: DVec3::X * force,
        moment_world: DVec3::ZERO,
        penetration_m: 0.0,
        radius_m: 0.0,
        area_m2: 1e-5,
        slip_world: DVec3::ZERO,
    };
    let mut jump = Jump::new(3);
    assert_eq!(jump.observe(&[contact(1, 2.0), contact(1, 1.0)], 2.0), 6.0);
    assert_eq!(jump.observe(&[contact(1, 2.0), contact(2, 0.5)], 2.0), 2.0);
    assert_eq!(jump.observe(&[], 2.0), 4.0);
    assert!(jump.observe(&[contact(1, f64::NAN)], 2.0).is_nan());
}
