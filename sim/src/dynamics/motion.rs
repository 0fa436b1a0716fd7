//! Where the links are, how a step moves them, and which rule it needs.

use glam::{DQuat, DVec3};
use underbrush_recording::Pose;

use super::{Coordinate, Tree};
use crate::object::structure::Spring;
use crate::physics::Theta;

impl Tree {
    /// Computes the poses of the links from the positions of the coordinates.
    pub fn place(&mut self) {
        for index in 1..self.links.len() {
            let link = &self.links[index];
            let joint = self.links[link.parent].pose_world * link.joint_parent;
            let (mut slide, mut turn) = (DVec3::ZERO, link.turn);
            for coordinate in &mut self.coordinates[link.coordinates.0..link.coordinates.1] {
                let axis_joint = coordinate.axis_joint;
                // Each of two rotations turns the axis of the next one.
                let turned = if link.is_ball { axis_joint } else { turn * axis_joint };
                coordinate.axis_world = joint.orientation * turned;
                if !coordinate.turns {
                    slide += coordinate.axis_world * coordinate.position;
                } else if !link.is_ball {
                    turn *= DQuat::from_axis_angle(axis_joint, coordinate.position);
                }
            }
            self.links[index].pose_world = Pose::new(joint.position + slide, joint.orientation * turn);
        }
    }

    /// Moves the tree to the end of the step with the velocities u_θ ([`Tree::next`]), and sets its velocities to those there.
    pub fn advance(&mut self) {
        let next = std::mem::take(&mut self.scratch.next);
        let (step_s, ahead_s, theta) = (self.scratch.step_s, self.scratch.ahead_s, self.scratch.theta.value());
        self.displace(|coordinate, at| step_s * next[at] - ahead_s * coordinate.velocity);
        for (coordinate, next) in self.coordinates.iter_mut().zip(&next) {
            coordinate.velocity += (next - coordinate.velocity) / theta;
            coordinate.yield_if_overloaded();
        }
        self.scratch.next = next;
        self.pushes.fill(0.0);
    }

    /// Lets roots slide that are pulled harder than the foam holds, and returns the first that is pulled out whole. Nothing
    /// holds that one any more.
    pub fn pull_roots(&mut self) -> Option<usize> {
        for (link, grip) in &self.grips {
            let (first, end) = self.links[*link].coordinates;
            // The third axis is along the root, which slides out and not farther in.
            let upright = &mut self.coordinates[first + 2];
            let left = (1.0 - upright.spring.rest / grip.depth_m).min(1.0);
            if left > 0.0 {
                let give = grip.force_n * left / upright.spring.stiffness;
                upright.spring.rest = upright.spring.rest.max(upright.position - give);
                continue;
            }
            for coordinate in &mut self.coordinates[first..end] {
                coordinate.spring = Spring::default();
            }
            let link = *link;
            self.grips.retain(|(own, _)| *own != link);
            return Some(link);
        }
        None
    }

    /// Whether a link is another one, or is carried by it.
    pub fn is_carried_by(&self, mut link: usize, carrier: usize) -> bool {
        while link > carrier {
            link = self.links[link].parent;
        }
        link == carrier
    }

    /// Moves the coordinates by what `change` returns for each and its index, m or rad, and places the links.
    pub fn displace(&mut self, change: impl Fn(&Coordinate, usize) -> f64) {
        for link in self.links.iter_mut().filter(|link| link.is_ball) {
            let (first, end) = link.coordinates;
            let turning = self.coordinates[first..end].iter().zip(first..).filter(|(own, _)| own.turns);
            let turned: DVec3 = turning.map(|(own, at)| own.axis_joint * change(own, at)).sum();
            link.turn = (DQuat::from_scaled_axis(turned) * link.turn).normalize();
        }
        for (at, coordinate) in self.coordinates.iter_mut().enumerate() {
            coordinate.position += change(coordinate, at);
        }
        self.place();
    }

    /// The rule that the tree's own springs and dampers need in a step of `step_s`, each with the inertia that it moves.
    pub fn own_theta(&mut self, step_s: f64) -> Theta {
        if self.inertia.is_empty() {
            self.scratch.step_s = 0.0;
            self.sum_forces(0.0);
            self.sum_masses();
            let size = self.coordinates.len();
            self.inertia.extend((0..size).map(|at| self.scratch.mass[at * (size + 1)]));
        }
        let phases = self.coordinates.iter().zip(&self.inertia).map(|(own, inertia)| {
            let by_spring = step_s * (own.spring().0 / inertia).sqrt();
            // The midpoint rule rings where a damper alone would stop the motion within half a step.
            by_spring.max(0.5 * step_s * own.spring.damping / inertia)
        });
        Theta::of_phase(phases.fold(0.0, f64::max), Theta::DAMPED)
    }

    /// The rule of the step that has begun.
    pub fn theta(&self) -> Theta {
        self.scratch.theta
    }

    /// Gives the step that has begun a rule that damps more. [`Tree::prepare`] must follow.
    pub fn set_theta(&mut self, theta: Theta) {
        self.scratch.theta = theta;
    }

    /// How long the tree moved ahead with its velocities when the step began, s.
    pub fn ahead_s(&self) -> f64 {
        self.scratch.ahead_s
    }

    /// How much faster the link's point at `point_world` moves along `direction_world` under a unit impulse there, 1/kg.
    pub fn mobility(&mut self, link: usize, point_world: DVec3, direction_world: DVec3) -> f64 {
        let mut motion = std::mem::take(&mut self.scratch.motion);
        motion.clear();
        motion.resize(self.coordinates.len(), 0.0);
        for (at, [linear, _]) in self.motions(link, point_world) {
            motion[at] = linear.dot(direction_world);
        }
        // J M⁻¹ Jᵀ with M = LᵀL is the square of L⁻ᵀ Jᵀ.
        self.solve_upper(&mut motion);
        let mobility = motion.iter().map(|value| value * value).sum();
        self.scratch.motion = motion;
        mobility
    }
}
