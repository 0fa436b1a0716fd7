//! One step of the model-predictive controller with ten taxels in contact, and its quadratic program alone. The paper's robot
//! ran at 25 Hz, so a step of `cody-2013` may take 40 ms; `ijrr-foliage` runs at 100 Hz.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::hint::black_box;

use divan::Bencher;
use glam::DVec3;
use nalgebra::Matrix3xX;
use underbrush_recording::Pose;
use underbrush_sim::arm::Arm;
use underbrush_sim::controller::{ControlStatus, Controller, ControllerInput, ModelPredictive, Preset, TaxelContact};

/// Cody in its start posture, ten taxels of the forearm in contact, moving forward.
struct Situation {
    arm: Arm,
    angle_rad: Vec<f64>,
    end_effector: Pose,
    end_effector_jacobian: Matrix3xX<f64>,
    joint_velocity_rad_per_s: Vec<f64>,
    contacts: Vec<TaxelContact>,
}

impl Situation {
    /// Ten neighbouring taxels around the forearm, from 1.2 N to 3.9 N: some under the force limit of 3 N, some over
    /// it.
    fn new() -> Self {
        let arm = Arm::cody().expect("Cody's files are sound");
        let angle_rad = arm.start_posture_rad();
        let poses = arm.forward_kinematics(&angle_rad);
        let link = arm.link_index("forearm").expect("Cody has a forearm");
        let patch = arm.skin.layout.patch_index("forearm").expect("with skin");
        let forearm = &arm.skin.layout.patches[patch];
        let contacts = (0..10)
            .map(|number| {
                let index = 8 * 24 + number;
                let taxel = &forearm.taxels[index];
                TaxelContact {
                    patch,
                    taxel: index,
                    link,
                    position_world: poses[link].transform_point(taxel.position_link),
                    position_jacobian: arm.position_jacobian(
                        &poses,
                        link,
                        poses[link].transform_point(taxel.position_link),
                    ),
                    inward_normal_world: -poses[link].transform_vector(taxel.normal_link),
                    force_n: 1.2 + 0.3 * number as f64,
                    allowed_force_n: None,
                    verdict: None,
                }
            })
            .collect();
        let end_effector = arm.end_effector_pose(&poses);
        Situation {
            end_effector,
            end_effector_jacobian: arm.position_jacobian(&poses, arm.end_effector_link, end_effector.position),
            joint_velocity_rad_per_s: vec![0.0; angle_rad.len()],
            contacts,
            angle_rad,
            arm,
        }
    }

    fn input(&self) -> ControllerInput {
        ControllerInput {
            joint_angle_rad: self.angle_rad.clone(),
            joint_velocity_rad_per_s: self.joint_velocity_rad_per_s.clone(),
            equilibrium_angle_rad: self.angle_rad.clone(),
            end_effector_pose_world: self.end_effector,
            end_effector_jacobian: self.end_effector_jacobian.clone(),
            goal_position_world: self.end_effector.position + DVec3::X * 0.3,
            contacts: self.contacts.clone(),
        }
    }
}

const PRESETS: [fn() -> Preset; 2] = [Preset::cody_2013, Preset::ijrr_foliage];

fn controller(preset: usize, situation: &Situation) -> ModelPredictive {
    ModelPredictive::new(PRESETS[preset](), &situation.arm)
}

/// One control step with each preset.
#[divan::bench(args = [0, 1])]
fn step(bencher: Bencher, preset: usize) {
    let situation = Situation::new();
    let mut controller = controller(preset, &situation);
    let input = situation.input();
    assert_eq!(controller.control(&input).status, ControlStatus::Solved);
    bencher.bench_local(|| controller.control(black_box(&input)));
}

/// The quadratic program of that step.
#[divan::bench(args = [0, 1])]
fn quadratic_program(bencher: Bencher, preset: usize) {
    let situation = Situation::new();
    let mut controller = controller(preset, &situation);
    let input = situation.input();
    controller.control(&input);
    let program = controller.step_program(&input).expect("the model has a factor");
    assert!(program.solve().is_ok(), "the program has a minimum");
    bencher.bench_local(|| black_box(&program).solve());
}

fn main() {
    divan::main();
}
