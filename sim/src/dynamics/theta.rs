//! Which rule the step of a tree needs.

use glam::DVec3;

use super::Tree;
use crate::physics::Theta;

impl Tree {
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
