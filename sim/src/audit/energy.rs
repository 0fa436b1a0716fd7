//! The energy balance of the arm, step by step.
//!
//! The stored energy is the kinetic energy of the links and the energy of the joints' springs. In a step of length Δt
//!
//! * the **actuators** move the rest angles of the springs from φ₀ to φ₁ at the joint angles q₀, which takes the work
//!   Σ ½ K ((φ₁ − q₀)² − (φ₀ − q₀)²);
//! * the **dampers** take Σ D u² Δt, where u = (q₁ − q₀)/Δt;
//! * the **contacts** take −Σ f · Δx, the mean force of the step times the displacement of the point of the link on
//!   which it acts. This includes losses by friction and contact damping, and what the objects store and lose;
//! * the **integrator** dissipates energy numerically. For one step h of the θ-method on M v̇ = −K x,
//!   ΔE = (½ − θ) (Δvᵀ M Δv + h² uᵀ K u).
//!
//! The rest is the residual: impacts within a step, and gyroscopic terms. Steps that begin or end with a joint at a
//! mechanical limit are left out, because no term accounts for the work of a stop.

use glam::DVec3;
use underbrush_recording::{FRAME_PERIOD_S, Pose};

use crate::arm::Arm;
use crate::simulation::{JointState, Simulation, StepReport};

/// One link at the end of a step.
#[derive(Clone, Copy, Debug)]
struct LinkState {
    pose: Pose,
    /// Velocity of its centre of mass, m/s, world frame.
    velocity_world: DVec3,
    /// Angular velocity, rad/s, world frame.
    angular_velocity_world: DVec3,
}

/// The arm at the end of a step.
#[derive(Clone, Debug, Default)]
struct ArmState {
    joints: Vec<JointState>,
    links: Vec<LinkState>,
    energy_j: f64,
    /// Whether a joint is at a mechanical limit.
    stopped: bool,
}

impl ArmState {
    fn read(&mut self, arm: &Arm, joints: &[JointState], link_pose_world: &[Pose]) {
        joints.clone_into(&mut self.joints);
        self.links.clear();
        let (mut angular_velocity, mut velocity, mut origin) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for (index, (link, pose)) in arm.links.iter().zip(link_pose_world).enumerate() {
            velocity += angular_velocity.cross(pose.position - origin);
            origin = pose.position;
            if index > 0 {
                let rate = joints.get(index - 1).map_or(0.0, |joint| joint.velocity_rad_per_s);
                angular_velocity += pose.transform_vector(arm.joints[index - 1].axis_child) * rate;
            }
            let to_center = pose.transform_vector(link.center_of_mass_link);
            self.links.push(LinkState {
                pose: *pose,
                velocity_world: velocity + angular_velocity.cross(to_center),
                angular_velocity_world: angular_velocity,
            });
        }
        let mut joints = arm.joints.iter().zip(&self.joints);
        let twice_j = joints.clone().map(|(joint, state)| {
            let stretch = state.rest_angle_rad - state.angle_rad;
            joint.stiffness_nm_per_rad * stretch * stretch + joint.armature_kg_m2 * state.velocity_rad_per_s.powi(2)
        });
        self.energy_j = 0.5 * twice_j.sum::<f64>()
            + self.kinetic_energy_j(arm, |_, link| (link.velocity_world, link.angular_velocity_world));
        self.stopped = joints.any(|(joint, state)| joint.is_at_stop(state.angle_rad));
    }

    /// Kinetic energy of the links, J, at the velocities (of the centre of mass, and angular) that `velocities`
    /// returns.
    fn kinetic_energy_j(&self, arm: &Arm, velocities: impl Fn(usize, &LinkState) -> (DVec3, DVec3)) -> f64 {
        let of_link = |(index, state): (usize, &LinkState)| {
            let (velocity, angular_velocity) = velocities(index, state);
            let angular_velocity_link = state.pose.inverse_transform_vector(angular_velocity);
            let link = &arm.links[index];
            0.5 * (link.mass_kg * velocity.length_squared()
                + angular_velocity_link.dot(link.inertia_link * angular_velocity_link))
        };
        self.links.iter().enumerate().map(of_link).sum()
    }
}

/// Sums over the steps so far in which no joint is at a mechanical limit, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergySums {
    /// Work of the actuators.
    pub actuators_j: f64,
    /// Sum of the absolute values of the actuators' work in each step: the scale of the residual.
    pub exchanged_j: f64,
    /// Increase of kinetic and spring energy.
    pub stored_j: f64,
    /// Taken by the joints' dampers.
    pub dampers_j: f64,
    /// Work done on the contacts: friction, contact damping, objects.
    pub contacts_j: f64,
    /// Dissipated by the integrator itself, an estimate.
    pub integrator_j: f64,
}

impl EnergySums {
    /// The part that the balance leaves unexplained, J.
    pub fn residual_j(&self) -> f64 {
        self.actuators_j - self.stored_j - self.dampers_j - self.contacts_j - self.integrator_j
    }
}

/// The balance of one arm.
#[derive(Clone, Debug, Default)]
pub struct EnergyBalance {
    last: ArmState,
    now: ArmState,
    /// The sums so far.
    pub sums: EnergySums,
}

impl EnergyBalance {
    /// The balance of a simulation's arm from now on.
    pub fn new(simulation: &Simulation) -> Self {
        let report = simulation.report();
        let mut balance = EnergyBalance::default();
        balance.now.read(simulation.arm(), &report.joints, &report.link_pose_world);
        balance
    }

    /// Observes an engine step with its contacts.
    pub fn observe_step(&mut self, step: &StepReport) {
        let arm = step.arm;
        std::mem::swap(&mut self.last, &mut self.now);
        self.now.read(arm, step.joints, step.link_pose_world);
        if self.last.stopped || self.now.stopped {
            return;
        }
        let step_s = step.physics.step_s;
        let damps = step.theta.value() - 0.5;
        let sums = &mut self.sums;
        let mut work_j = 0.0;
        let states = self.last.joints.iter().zip(&self.now.joints);
        for (joint, (last, now)) in arm.joints.iter().zip(states) {
            let stretch = |rest: f64| (rest - last.angle_rad).powi(2);
            work_j += 0.5 * joint.stiffness_nm_per_rad * (stretch(now.rest_angle_rad) - stretch(last.rest_angle_rad));
            let moved_rad = now.angle_rad - last.angle_rad;
            sums.dampers_j += joint.damping_nm_s_per_rad * moved_rad * moved_rad / step_s;
            let faster = now.velocity_rad_per_s - last.velocity_rad_per_s;
            sums.integrator_j +=
                damps * (joint.stiffness_nm_per_rad * moved_rad * moved_rad + joint.armature_kg_m2 * faster * faster);
        }
        sums.stored_j += self.now.energy_j - self.last.energy_j;
        sums.actuators_j += work_j;
        sums.exchanged_j += work_j.abs();
        let last = &self.last;
        let change = |index: usize, link: &LinkState| {
            let before = &last.links[index];
            (link.velocity_world - before.velocity_world, link.angular_velocity_world - before.angular_velocity_world)
        };
        // Twice the kinetic energy is vᵀ M v.
        sums.integrator_j += 2.0 * damps * self.now.kinetic_energy_j(arm, change);
        for contact in step.contacts {
            let place = |state: &ArmState| state.links[contact.link].pose.transform_point(contact.position_link);
            let mean_force_world = contact.force_world * (FRAME_PERIOD_S / step_s);
            sums.contacts_j -= mean_force_world.dot(place(&self.now) - place(last));
            let mean_moment_world = contact.moment_world * (FRAME_PERIOD_S / step_s);
            let spin = |state: &ArmState| state.links[contact.link].angular_velocity_world;
            sums.contacts_j -= 0.5 * step_s * mean_moment_world.dot(spin(last) + spin(&self.now));
        }
    }
}
