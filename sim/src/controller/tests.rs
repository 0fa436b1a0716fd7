//! Tests of the controllers: the program alone, single steps in random situations, and closed loops with a
//! quasi-static arm.

use glam::DVec3;
use nalgebra::Matrix3xX;
use underbrush_recording::Pose;

use super::{Controller, ControllerInput, ControllerOutput, TaxelContact};
use crate::arm::Arm;

mod closed_loop;
mod contact_limits;
mod quadratic_program;
mod single_step;

/// An arm at one instant, with everything that a controller needs.
struct Situation<'a> {
    arm: &'a Arm,
    angle: Vec<f64>,
    equilibrium: Vec<f64>,
    contacts: Vec<TaxelContact>,
    goal_position_world: DVec3,
    links: Vec<Pose>,
}

impl<'a> Situation<'a> {
    /// An arm at rest at its equilibrium angles, without contact, with its goal at its end effector.
    fn at(arm: &'a Arm, angle: &[f64]) -> Self {
        let links = arm.forward_kinematics(angle);
        let goal_position_world = arm.end_effector_pose(&links).position;
        Situation {
            arm,
            angle: angle.to_vec(),
            equilibrium: angle.to_vec(),
            contacts: Vec::new(),
            goal_position_world,
            links,
        }
    }

    fn end_effector(&self) -> Pose {
        self.arm.end_effector_pose(&self.links)
    }

    fn end_effector_jacobian(&self) -> Matrix3xX<f64> {
        self.arm.position_jacobian(&self.links, self.arm.end_effector_link, self.end_effector().position)
    }

    /// Presses on one taxel.
    fn press(&mut self, patch: usize, index: usize, force_n: f64) {
        let link = self.arm.skin.surfaces[patch].link;
        let taxel = self.arm.skin.layout.patches[patch].taxels[index];
        let pose = self.links[link];
        let position_world = pose.transform_point(taxel.position_link);
        let position_jacobian = self.arm.position_jacobian(&self.links, link, position_world);
        let inward_normal_world = -(pose.orientation * taxel.normal_link);
        self.contacts.push(TaxelContact {
            patch,
            taxel: index,
            link,
            position_world,
            position_jacobian,
            inward_normal_world,
            force_n,
            allowed_force_n: None,
            verdict: None,
        });
    }

    fn step(&self, controller: &mut dyn Controller) -> ControllerOutput {
        controller.control(&ControllerInput {
            joint_angle_rad: self.angle.clone(),
            joint_velocity_rad_per_s: vec![0.0; self.angle.len()],
            equilibrium_angle_rad: self.equilibrium.clone(),
            end_effector_pose_world: self.end_effector(),
            end_effector_jacobian: self.end_effector_jacobian(),
            goal_position_world: self.goal_position_world,
            contacts: self.contacts.clone(),
        })
    }

    fn distance(&self) -> f64 {
        self.goal_position_world.distance(self.end_effector().position)
    }
}

/// A posture with all joints away from their limits.
const MIDDLE_DEG: [f64; 7] = [20.0, 20.0, -30.0, 70.0, 10.0, 5.0, -5.0];

fn middle() -> Vec<f64> {
    MIDDLE_DEG.map(f64::to_radians).to_vec()
}

fn vector(v: DVec3) -> nalgebra::Vector3<f64> {
    nalgebra::Vector3::new(v.x, v.y, v.z)
}
