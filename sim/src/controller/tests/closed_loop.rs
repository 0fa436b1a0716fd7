use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::super::{ControlStatus, Controller, ControllerKind, ModelPredictive, Preset};
use super::{Situation, middle, vector};
use crate::arm::Arm;
use crate::reach::ReachRules;

#[test]
fn reaches_goals_in_free_space() {
    // Tests that the end effector of an arm that follows its equilibrium angles arrives at goals that it can reach, no
    // faster than the preset's hand speed.
    let arm = Arm::cody().unwrap();
    for kind in [ControllerKind::Cody2013, ControllerKind::IjrrFoliage] {
        let (preset, rules) = (kind.preset(), ReachRules::published_with(kind));
        let mut controller = ModelPredictive::new(preset.clone(), &arm);
        let mut random = ChaCha8Rng::seed_from_u64(11);
        for _ in 0..10 {
            // A goal that the arm can reach from near this posture.
            let near: Vec<f64> = middle().iter().map(|angle| angle + random.random_range(-0.4..0.4)).collect();
            let goal = Situation::at(&arm, &near).end_effector().position;
            let mut angle = arm.start_posture_rad();
            let mut last = Situation::at(&arm, &angle).end_effector().position;
            let steps = (rules.time_out_s * preset.rate_hz) as usize;
            let reached = (0..steps).any(|_| {
                let mut situation = Situation::at(&arm, &angle);
                situation.goal_position_world = goal;
                let position = situation.end_effector().position;
                // The step is planned on the tangent, so its length is off by the square of half a degree.
                assert!(position.distance(last) < preset.end_effector_step_m * 1.02);
                last = position;
                let output = situation.step(&mut controller);
                assert_eq!(output.status, ControlStatus::Solved);
                angle = output.equilibrium_angle_rad;
                situation.distance() < rules.reached_distance_m
            });
            assert!(reached, "{} stops {} m from {goal}", preset.name, last.distance(goal));
        }
    }
}

/// A frictionless wall with a spring, pressed by one taxel of an arm at rest on its springs.
struct Wall {
    patch: usize,
    taxel: usize,
    /// A point of it, m, world frame.
    point: DVec3,
    /// Direction in which it pushes, unit.
    push: DVec3,
    stiffness: f64,
}

impl Wall {
    /// How deep the taxel is in the wall, m, and the gradient of this depth with respect to the joint angles.
    fn depth(&self, arm: &Arm, angle: &[f64]) -> (f64, DVector<f64>) {
        let links = arm.forward_kinematics(angle);
        let link = arm.skin.surfaces[self.patch].link;
        let position =
            links[link].transform_point(arm.skin.layout.patches[self.patch].taxels[self.taxel].position_link);
        let jacobian = DMatrix::from_column_slice(3, 7, arm.position_jacobian(&links, link, position).as_slice());
        ((self.point - position).dot(self.push), -jacobian.tr_mul(&vector(self.push)))
    }

    /// Moves the equilibrium angles from `from` to `to` in small steps and lets the arm come to rest after each: K (φ −
    /// q) + Jᵀ f = 0, by Newton's method from `angle`. Returns the force, N.
    fn settle(&self, arm: &Arm, from: &[f64], to: &[f64], angle: &mut [f64]) -> f64 {
        let spring = DVector::from_iterator(7, arm.joints.iter().map(|joint| joint.model_stiffness_nm_per_rad));
        let (from, to) = (DVector::from_column_slice(from), DVector::from_column_slice(to));
        for part in 1..=20 {
            let equilibrium = from.lerp(&to, f64::from(part) / 20.0);
            let rests = (0..100).any(|_| {
                let (depth, gradient) = self.depth(arm, angle);
                let pressed = if depth > 0.0 { self.stiffness } else { 0.0 };
                let offset = DVector::from_column_slice(angle) - &equilibrium;
                // The elastic energy's gradient and, without the curvature of the path, its second derivative.
                let slope = spring.component_mul(&offset) + &gradient * (pressed * depth);
                let curvature = DMatrix::from_diagonal(&spring) + &gradient * gradient.transpose() * pressed;
                let step = curvature.cholesky().unwrap().solve(&slope);
                for (value, change) in angle.iter_mut().zip(&step) {
                    *value -= change;
                }
                step.amax() < 1e-10
            });
            assert!(rests, "the arm finds no rest at the wall");
        }
        self.stiffness * self.depth(arm, angle).0.max(0.0)
    }
}

/// The forearm hangs forward of the vertical, in front of a wall.
const POSTURE_DEG: [f64; 7] = [10.0, 15.0, -20.0, 40.0, 10.0, 5.0, -5.0];

/// Forces over `steps` control steps against a wall, from an arm whose equilibrium angles lie `ahead` radians further
/// in flexion than where it touches, with a goal `goal_ahead` metres from where the end effector is then.
fn push(
    arm: &Arm,
    controller: &mut dyn Controller,
    stiffness: f64,
    ahead: f64,
    goal_ahead: f64,
    steps: usize,
) -> Vec<f64> {
    // A wall in front of the taxel that faces forward most, in the middle of the sleeve.
    let start = POSTURE_DEG.map(f64::to_radians).to_vec();
    let situation = Situation::at(arm, &start);
    let link = arm.skin.surfaces[0].link;
    let pose = situation.links[link];
    let taxels = &arm.skin.layout.patches[0].taxels;
    let forward = |index: &usize| (pose.orientation * taxels[*index].normal_link).x;
    let taxel = (168..192).max_by(|a, b| forward(a).total_cmp(&forward(b))).unwrap();
    let outward = pose.orientation * taxels[taxel].normal_link;
    let wall =
        Wall { patch: 0, taxel, point: pose.transform_point(taxels[taxel].position_link), push: -outward, stiffness };
    let goal = situation.end_effector().position + outward * goal_ahead;
    let mut equilibrium = start.clone();
    equilibrium[0] += ahead;
    let mut angle = start;
    let mut forces = Vec::new();
    let mut last = angle.clone();
    for _ in 0..=steps {
        let force = wall.settle(arm, &last, &equilibrium, &mut angle);
        last.clone_from(&equilibrium);
        forces.push(force);
        let mut situation = Situation::at(arm, &angle);
        situation.equilibrium = equilibrium;
        situation.goal_position_world = goal;
        if force > 0.0 {
            situation.press(0, taxel, force);
            situation.contacts[0].inward_normal_world = wall.push;
        }
        equilibrium = situation.step(controller).equilibrium_angle_rad;
    }
    forces
}

#[test]
fn forces_over_the_limit_fall_below_it() {
    // Tests that a contact pressed above the limit is relieved, both with the assumed stiffness and with a higher one.
    let arm = Arm::cody().unwrap();
    for preset in [Preset::cody_2013(), Preset::ijrr_foliage()] {
        let mut controller = ModelPredictive::new(preset.clone(), &arm);
        for stiffness in [preset.contact_stiffness_n_per_m, 5000.0] {
            let ahead = if stiffness < 100.0 { 0.40 } else { 0.25 };
            let forces = push(&arm, &mut controller, stiffness, ahead, 0.0, 300);
            assert!(forces[0] > preset.force_limit_n, "the push must start above the limit: {} N", forces[0]);
            let last = forces[forces.len() - 1];
            assert!(last <= preset.force_limit_n * 1.001, "{}: {last} N at {stiffness} N/m", preset.name);
        }
    }
}

#[test]
fn goals_behind_a_wall_are_pushed_for_within_the_limit() {
    // Tests the controller's purpose: on the way to a goal behind a wall of the assumed stiffness, the force approaches
    // the limit but does not exceed it, while a controller without skin pushes harder.
    let arm = Arm::cody().unwrap();
    for preset in [Preset::cody_2013(), Preset::ijrr_foliage()] {
        let stiffness = preset.contact_stiffness_n_per_m;
        let largest = |forces: Vec<f64>| forces.into_iter().fold(0.0, f64::max);
        let felt = largest(push(&arm, &mut ModelPredictive::new(preset.clone(), &arm), stiffness, 0.0, 0.4, 1500));
        let limit = preset.force_limit_n;
        assert!((0.5 * limit..1.02 * limit).contains(&felt), "{}: {felt} N", preset.name);
        let blind = Preset { ignored_force_n: f64::INFINITY, ..preset.clone() };
        let unfelt = largest(push(&arm, &mut ModelPredictive::new(blind, &arm), stiffness, 0.0, 0.4, 1500));
        assert!(unfelt > 1.3 * limit, "{}: {unfelt} N without skin", preset.name);
    }
}
