//! The free step: mass matrix, forces, and the velocities that follow.

use glam::{DMat3, DVec3};
use underbrush_recording::math;

use super::spatial::{Inertia, Spatial};
use super::{Coordinate, Link, Scratch, Tree};
use crate::object::structure::Drag;
use crate::physics::Theta;

/// If a link turns by more than this in a step, rad, the forces that follow from the speed of the links change its velocity by more
/// than the velocity itself, and step by step the tree would fly apart. A leaf that two others pinch may be flung so fast; in
/// 600 reaches among leaves none was, and 0.7 rad was the most in 160 others.
const MOST_TURN_RAD: f64 = 1.0;

/// If no link has a larger ω² Δt than this, 1/s, the forces that follow from the speed of the links are those at the start of the
/// step, and otherwise those at u_θ. Forces at the start make energy, in proportion to ω² Δt: a free box gains 0.2 % a second at this
/// limit, which is 2 rad/s in steps of 5 ms. That is little beside what friction and air take from it.
const MOST_GAIN_PER_S: f64 = 0.02;

impl Coordinate {
    /// Stiffness of the spring with its relaxing branch, and the force of both, N/m and N or N m/rad and N m.
    pub(super) fn spring(&self) -> (f64, f64) {
        let own = self.spring.stiffness * (self.spring.rest - self.position);
        match self.spring.maxwell {
            None => (self.spring.stiffness, own),
            Some(branch) => {
                (self.spring.stiffness + branch.stiffness, own + branch.stiffness * (self.dashpot - self.position))
            }
        }
    }

    /// Moves the rest position of a spring that is loaded beyond its yield moment, so that it holds just that.
    pub(super) fn yield_if_overloaded(&mut self) {
        if let Some(limit) = self.spring.yield_moment {
            let give = limit / self.spring.stiffness;
            self.spring.rest = self.spring.rest.clamp(self.position - give, self.position + give);
        }
    }

    /// Relaxes the branch over a step: exact for a displacement z that is constant over it, dz/dt = (x − z)/τ.
    fn relax(&mut self, step_s: f64) {
        if let Some(branch) = self.spring.maxwell {
            let share = -math::exp_m1(-step_s / branch.relaxation_time_s);
            self.dashpot += (self.position - self.dashpot) * share;
        }
    }
}

impl Tree {
    /// Begins a step of `step_s`. With θ = ½ the tree is moved ahead to its middle with its present velocities.
    pub fn begin(&mut self, step_s: f64, theta: Theta) {
        let ahead_s = if theta == Theta::MIDPOINT { 0.5 * step_s } else { 0.0 };
        (self.scratch.step_s, self.scratch.theta, self.scratch.ahead_s) = (step_s, theta, ahead_s);
        if ahead_s > 0.0 {
            self.displace(|coordinate, _| ahead_s * coordinate.velocity);
        }
        self.coordinates.iter_mut().for_each(|coordinate| coordinate.relax(step_s));
    }

    /// Finds the velocities u_θ of the step that has begun if nothing touches the tree ([`Tree::next`]), and its mass
    /// matrix. Gravity, m/s², acts downwards. The forces of [`Tree::push`] act in this step.
    pub fn prepare(&mut self, gravity_m_per_s2: f64) {
        let gravity_m_per_s2 = if self.weighs { gravity_m_per_s2 } else { 0.0 };
        let fastest_rad_per_s = self.sum_forces(gravity_m_per_s2);
        self.find_next();
        if fastest_rad_per_s.powi(2) * self.scratch.step_s > MOST_GAIN_PER_S {
            self.swap_velocities();
            self.sum_forces(gravity_m_per_s2);
            self.swap_velocities();
            self.find_next();
        }
        let Scratch { axes, velocities, next, .. } = &mut self.scratch;
        for (index, link) in self.links.iter().enumerate().skip(1) {
            velocities[index] = velocities[link.parent];
            for at in link.coordinates.0..link.coordinates.1 {
                velocities[index].add_scaled(&axes[at], next[at]);
            }
        }
    }

    /// The point that moments are about, m, world frame: the first link that moves.
    pub(super) fn about(&self) -> DVec3 {
        self.links.get(1).map_or(DVec3::ZERO, |link| link.pose_world.position)
    }

    /// Exchanges the velocities at the start of the step with u_θ.
    fn swap_velocities(&mut self) {
        for (own, next) in self.coordinates.iter_mut().zip(&mut self.scratch.next) {
            std::mem::swap(&mut own.velocity, next);
        }
    }

    /// Finds u_θ and the mass matrix from the forces that were summed.
    fn find_next(&mut self) {
        self.sum_masses();
        self.factorize();
        let mut acceleration = std::mem::take(&mut self.scratch.acceleration);
        self.solve(&mut acceleration);
        let reach_s = self.reach_s();
        let next = self.coordinates.iter().zip(&acceleration).map(|(own, rate)| own.velocity + reach_s * rate);
        self.scratch.next.clear();
        self.scratch.next.extend(next);
        self.scratch.acceleration = acceleration;
    }

    /// θ Δt, s: the time from the start of the step to where forces are taken.
    fn reach_s(&self) -> f64 {
        self.scratch.theta.value() * self.scratch.step_s
    }

    /// Computes the velocities, bias accelerations and bias forces of the links. Links that turn too fast for the step have the bias
    /// of [`MOST_TURN_RAD`]. Returns the largest angular speed of a link, rad/s.
    pub(super) fn sum_forces(&mut self, gravity_m_per_s2: f64) -> f64 {
        let fastest_rad_per_s = self.sum_forces_with(1.0, gravity_m_per_s2);
        let turn_rad = fastest_rad_per_s * self.scratch.step_s;
        if turn_rad > MOST_TURN_RAD {
            let share = MOST_TURN_RAD / turn_rad;
            self.sum_forces_with(share * share, gravity_m_per_s2);
        }
        fastest_rad_per_s
    }

    /// The same with this share of the bias. Returns the largest angular speed of a link, rad/s.
    fn sum_forces_with(&mut self, share: f64, gravity_m_per_s2: f64) -> f64 {
        let mut fastest = 0.0_f64;
        let about = self.about();
        let Scratch { axes, velocities, accelerations, forces, inertias, step_s, .. } = &mut self.scratch;
        axes.clear();
        velocities.clear();
        accelerations.clear();
        forces.clear();
        inertias.clear();
        for link in &self.links {
            // The ground is its own parent, and has none of either.
            let of_parent = |list: &[Spatial]| list.get(link.parent).copied().unwrap_or_default();
            let (mut velocity, mut acceleration) = (of_parent(velocities), of_parent(accelerations));
            let carried = velocity;
            let is_ball = link.is_ball;
            let point = link.pose_world.position - about;
            // The velocity of the joint's point, which prismatic coordinates move.
            let mut at_point = carried.linear + carried.angular.cross(point);
            for coordinate in &self.coordinates[link.coordinates.0..link.coordinates.1] {
                let Coordinate { axis_world: axis, velocity: speed, turns, .. } = *coordinate;
                // The axis turns with the parent, and with the rotations before it.
                let turned = if is_ball { carried.angular } else { velocity.angular }.cross(axis);
                let (unit, change) = if turns {
                    let unit = Spatial { angular: axis, linear: point.cross(axis) };
                    (unit, Spatial { angular: turned, linear: at_point.cross(axis) + point.cross(turned) })
                } else {
                    at_point += axis * speed;
                    (Spatial { angular: DVec3::ZERO, linear: axis }, Spatial { angular: DVec3::ZERO, linear: turned })
                };
                velocity.add_scaled(&unit, speed);
                acceleration.add_scaled(&change, share * speed);
                axes.push(unit);
            }
            let center = link.pose_world.transform_point(link.center_of_mass_link) - about;
            let rotation = DMat3::from_quat(link.pose_world.orientation);
            let inertia = rotation * link.inertia_link * rotation.transpose();
            let Spatial { angular, linear } = velocity;
            let at_center = linear + angular.cross(center);
            let of_center = acceleration.linear + acceleration.angular.cross(center) + share * angular.cross(at_center);
            let force = (of_center + DVec3::Z * gravity_m_per_s2) * link.mass_kg;
            let spin = inertia * acceleration.angular + share * angular.cross(inertia * angular);
            fastest = fastest.max(angular.length());
            // Forces are those that the motion asks for, so the air's count negative.
            let force = force - link.drag.map_or(DVec3::ZERO, |drag| drag_world(&drag, link, at_center, *step_s));
            forces.push(Spatial { angular: center.cross(force) + spin, linear: force });
            inertias.push(Inertia::new(link.mass_kg, center, inertia));
            velocities.push(velocity);
            accelerations.push(acceleration);
        }
        fastest
    }

    /// The mass matrix of the step, and the generalized forces in place of the accelerations.
    pub(super) fn sum_masses(&mut self) {
        let size = self.coordinates.len();
        let (reach_s, ahead_s) = (self.reach_s(), self.scratch.ahead_s);
        let Scratch { axes, forces, inertias, mass, acceleration, .. } = &mut self.scratch;
        mass.clear();
        mass.resize(size * size, 0.0);
        acceleration.clear();
        acceleration.resize(size, 0.0);
        for (index, link) in self.links.iter().enumerate().skip(1).rev() {
            for at in link.coordinates.0..link.coordinates.1 {
                let coordinate = &self.coordinates[at];
                let (stiffness, spring) = coordinate.spring();
                let momentum = inertias[index].times(&axes[at]);
                for column in std::iter::successors(Some(at), |at| self.coordinates[*at].before) {
                    mass[at * size + column] = axes[column].dot(&momentum);
                }
                let damping = coordinate.spring.damping;
                mass[at * size + at] += coordinate.spring.armature + reach_s * (damping + reach_s * stiffness);
                // The spring's force is that where the tree was moved ahead to.
                acceleration[at] = self.pushes[at] + spring
                    - axes[at].dot(&forces[index])
                    - ((reach_s - ahead_s) * stiffness + damping) * coordinate.velocity;
            }
            let (force, inertia) = (forces[index], inertias[index]);
            forces[link.parent].add(&force);
            inertias[link.parent].add(&inertia);
        }
    }
}

/// Half the density of air, kg/m³, times the coefficient of drag of a plate of finite length that meets the air
/// flat (1.2; Hoerner, *Fluid-Dynamic Drag*, 1965, chapter 3).
const HALF_DENSITY_TIMES_DRAG_KG_PER_M3: f64 = 0.5 * 1.2 * 1.2;

/// The air's force on a plate whose centre moves with this velocity, N, world frame. Only the velocity along its normal
/// counts. The air stops the plate within a step at most: film that is flung would otherwise be thrown back ever faster.
fn drag_world(drag: &Drag, link: &Link, velocity_world: DVec3, step_s: f64) -> DVec3 {
    let normal_world = link.pose_world.transform_vector(drag.normal_body);
    let speed = velocity_world.dot(normal_world);
    let most_n = link.mass_kg / step_s * speed.abs();
    let force_n = -HALF_DENSITY_TIMES_DRAG_KG_PER_M3 * drag.area_m2 * speed * speed.abs();
    normal_world * force_n.max(-most_n).min(most_n)
}
