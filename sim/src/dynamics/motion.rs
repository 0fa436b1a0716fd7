//! Where the links are, and how a step moves them.

use glam::{DQuat, DVec3};
use underbrush_recording::Pose;

use super::Tree;

impl Tree {
    /// Computes the poses of the links from the positions of the coordinates.
    pub fn place(&mut self) {
        for index in 1..self.links.len() {
            let link = &self.links[index];
            let joint = self.links[link.parent].pose_world * link.joint_parent;
            let (mut slide, mut turn) = (DVec3::ZERO, link.turn);
            for coordinate in &mut self.coordinates[link.coordinates.0..link.coordinates.1] {
                coordinate.axis_world = joint.orientation * coordinate.axis_joint;
                if !coordinate.turns {
                    slide += coordinate.axis_world * coordinate.position;
                } else if !link.several_turns {
                    turn = DQuat::from_axis_angle(coordinate.axis_joint, coordinate.position);
                }
            }
            self.links[index].pose_world = Pose::new(joint.position + slide, joint.orientation * turn);
        }
    }

    /// Moves the tree with the velocities at the end of the step ([`Tree::next`]).
    pub fn advance(&mut self, step_s: f64) {
        for (coordinate, next) in self.coordinates.iter_mut().zip(&self.scratch.next) {
            coordinate.velocity = *next;
            coordinate.position += step_s * *next;
        }
        for link in &mut self.links {
            if link.several_turns {
                let turning = self.coordinates[link.coordinates.0..link.coordinates.1].iter().filter(|own| own.turns);
                let turned: DVec3 = turning.map(|own| own.axis_joint * own.velocity).sum();
                link.turn = (DQuat::from_scaled_axis(turned * step_s) * link.turn).normalize();
            }
        }
        self.place();
    }
}
