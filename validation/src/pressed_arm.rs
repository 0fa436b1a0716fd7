//! Cody's arm pressed with its forearm against one object.

use glam::DVec3;
use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};
use underbrush_recording::{Category, FRAME_PERIOD_S, Pose, TaxelReading};
use underbrush_sim::object::blade::SHEET_TORSION_OVER_BENDING;
use underbrush_sim::object::foam_roll::FoamRoll;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::object::trunk::Trunk;
use underbrush_sim::object::{FRICTION, Object};
use underbrush_sim::sensor::{Sensor, SensorOptions};
use underbrush_sim::simulation::{FrameReport, Setup, Simulation};
use underbrush_sim::{Arm, Clutter, PhysicsOptions, PlacedObject};

use crate::Fault;

pub const GRAVITY_M_PER_S2: f64 = 9.81;
/// The physics options of scenes that do not set any.
pub const OPTIONS: PhysicsOptions = PhysicsOptions { step_s: 0.005, gravity_m_per_s2: GRAVITY_M_PER_S2 };

/// A leaf for the forearm to push.
pub const LEAF: Leaf = Leaf {
    height_m: 0.4,
    width_m: 0.03,
    flexural_rigidity_n_m2: 0.02,
    torsion_over_bending: SHEET_TORSION_OVER_BENDING,
    mass_per_area_kg_per_m2: 0.8,
    loss_factor: 0.2,
    yield_moment_nm: None,
    grip: None,
    root_stiffness_nm_per_rad: Some(2.0),
    segments: 5,
};

/// A roll of soft foam, of which half relaxes.
pub const ROLL: FoamRoll = FoamRoll {
    diameter_m: 0.12,
    height_m: 0.5,
    modulus_pa: 1e5,
    relaxing_share: 0.5,
    relaxation_time_s: 2.0,
    density_kg_per_m3: 30.0,
};

/// Where on the forearm's axis the object is touched unless a check says otherwise, m, link frame. The place is under
/// the forearm's skin.
const PLACE_LINK: DVec3 = DVec3::new(0.0, 0.0, 0.10);
/// Contacts that slip more slowly than this may stick, m/s.
pub const SLIDING_M_PER_S: f64 = 5e-3;
/// Radius of the forearm's collision shape, m.
pub const FOREARM_RADIUS_M: f64 = 0.04604;

/// An object beside the forearm.
pub struct Beside {
    /// The object. If it is a leaf, it faces the forearm.
    pub object: Box<dyn Object>,
    /// From the forearm's surface to the middle of the object, m.
    pub gap_m: f64,
    /// From the forearm's axis down to the object's foot, m.
    pub drop_m: f64,
    /// How much nearer to the elbow than usual the object is touched, m.
    pub along_m: f64,
}

impl Beside {
    /// An object that faces the forearm.
    pub fn facing(object: Box<dyn Object>, gap_m: f64, drop_m: f64) -> Self {
        Beside { object, gap_m, drop_m, along_m: 0.0 }
    }

    /// A thin trunk, close to the forearm.
    pub fn trunk() -> Self {
        Beside::facing(Box::new(Trunk { diameter_m: 0.03, height_m: 0.6 }), 0.017, 0.3)
    }
}

/// The arm in its start posture, an object beside its forearm, and equilibrium angles that press one on the other.
pub struct PressedArm {
    /// The arm as the closed form describes it.
    pub arm: Arm,
    /// The simulation, with the arm that is simulated.
    pub simulation: Simulation,
    /// The start posture, rad.
    pub posture_rad: Vec<f64>,
    /// Index of the forearm.
    pub forearm: usize,
    /// Where on the forearm's axis the object is touched, m, link frame.
    pub place_link: DVec3,
    /// The pushing direction: horizontal, across the forearm, unit.
    pub across_world: DVec3,
}

impl PressedArm {
    /// The arm beside an object. `change` is made to the simulated arm alone. The skin's sensor is perfect.
    ///
    /// # Errors
    /// When the arm has no forearm.
    pub fn new(beside: Beside, options: PhysicsOptions, change: impl FnOnce(&mut Arm)) -> Result<Self, Fault> {
        let arm = Arm::cody()?;
        let mut simulated = arm.clone();
        change(&mut simulated);
        let posture_rad = arm.start_posture_rad();
        let poses = arm.forward_kinematics(&posture_rad);
        let forearm = arm.link_index("forearm").ok_or_else(|| Fault::Run("the arm has no forearm".into()))?;
        let place_link = PLACE_LINK + DVec3::Z * beside.along_m;
        let place = poses[forearm].transform_point(place_link);
        let along = poses[forearm].transform_vector(DVec3::Z);
        let across_world = DVec3::Z.cross(along).normalize();
        let placed = PlacedObject {
            object: beside.object,
            // The physics does not depend on it.
            category: Category::TRUNK,
            foot_world: place + across_world * (FOREARM_RADIUS_M + beside.gap_m) - DVec3::Z * beside.drop_m,
            yaw_rad: across_world.y.atan2(across_world.x),
            drawn: Vec::new(),
            stands_on: None,
        };
        let clutter = Clutter { objects: vec![placed], ..Clutter::default() };
        let simulation = simulation(simulated, clutter, options);
        Ok(PressedArm { arm, simulation, posture_rad, forearm, place_link, across_world })
    }

    /// The report of the last frame.
    pub fn report(&self) -> &FrameReport {
        self.simulation.report()
    }

    /// Equilibrium angles that would press with `force_n` across the forearm if nothing moved, rad.
    pub fn pressing_rad(&self, force_n: f64) -> Vec<f64> {
        let poses = self.arm.forward_kinematics(&self.posture_rad);
        let place = poses[self.forearm].transform_point(self.place_link);
        let torque = self.jacobian(&poses, place).transpose() * Vector3::from(self.across_world.to_array()) * force_n;
        let springs = self.posture_rad.iter().zip(&self.arm.joints).zip(torque.iter());
        springs.map(|((angle, joint), torque)| angle + torque / joint.stiffness_nm_per_rad).collect()
    }

    /// Equilibrium angles that move the place on the forearm by `distance_m` across it and nowhere else if nothing is
    /// in the way, with the least energy of the springs, rad.
    pub fn moving_rad(&self, distance_m: f64) -> Vec<f64> {
        let mut moved = self.posture_rad.clone();
        let start = self.arm.forward_kinematics(&moved)[self.forearm].transform_point(self.place_link);
        let goal = start + self.across_world * distance_m;
        // Newton's method. The distance is short, so three steps would be enough.
        for _ in 0..6 {
            let poses = self.arm.forward_kinematics(&moved);
            let place = poses[self.forearm].transform_point(self.place_link);
            let jacobian = self.jacobian(&poses, place);
            let softness = self.arm.joints.iter().map(|joint| 1.0 / joint.stiffness_nm_per_rad);
            let softness = DMatrix::from_diagonal(&DVector::from_iterator(moved.len(), softness));
            let back = &softness * jacobian.transpose();
            let missing = Vector3::from((goal - place).to_array());
            let Some(force) = (&jacobian * &back).lu().solve(&missing) else { return moved };
            let step = back * force;
            moved.iter_mut().zip(step.iter()).for_each(|(angle, step)| *angle += step);
        }
        moved
    }

    /// Holds equilibrium angles for some time.
    pub fn hold(&mut self, equilibrium_rad: &[f64], seconds: f64) {
        for _ in 0..(seconds / FRAME_PERIOD_S).round() as usize {
            self.simulation.step(equilibrium_rad);
        }
    }

    /// Jacobian of a point on the forearm, world frame.
    pub fn jacobian(&self, poses: &[Pose], point_world: DVec3) -> Matrix3xX<f64> {
        self.arm.position_jacobian(poses, self.forearm, point_world)
    }

    /// The taxels of the forearm that feel something.
    pub fn forearm_taxels(&self) -> impl Iterator<Item = &TaxelReading> + Clone {
        let readings = self.report().tactile.taxels.iter();
        readings.filter(move |reading| self.arm.skin.surfaces[usize::from(reading.patch)].link == self.forearm)
    }

    /// Velocity of a point of a link, m/s, world frame.
    pub fn velocity_world(&self, link: usize, point_link: DVec3) -> DVec3 {
        let poses = &self.report().link_pose_world;
        let point = poses[link].transform_point(point_link);
        let velocity = DVector::from_vec(self.report().joint_velocity_rad_per_s());
        let velocity = self.arm.position_jacobian(poses, link, point) * velocity;
        DVec3::new(velocity.x, velocity.y, velocity.z)
    }

    /// The sum of the normal forces of all contacts, N, and the normal force at the forearm's last contact, N, that
    /// would balance the joints' springs and dampers: K (φ − q) − D q̇ + Jᵀ (n − μ t) N = 0 in least squares, with the
    /// friction against the slip t. `None` unless this contact slips.
    pub fn normal_force_n(&self, equilibrium_rad: &[f64], friction: f64) -> Option<(f64, f64)> {
        let report = self.report();
        let contact = report.contacts.iter().rfind(|contact| contact.link == self.forearm)?;
        let poses = &report.link_pose_world;
        let slip = self.velocity_world(self.forearm, contact.position_link);
        let along = slip.reject_from_normalized(contact.inward_world);
        if along.length() < SLIDING_M_PER_S {
            return None;
        }
        let along = along.normalize();
        let point = poses[self.forearm].transform_point(contact.position_link);
        let direction = contact.inward_world - along * friction;
        let per_newton = self.jacobian(poses, point).transpose() * Vector3::from(direction.to_array());
        let states = report.joint_angle_rad().into_iter().zip(report.joint_velocity_rad_per_s());
        let torques = self.arm.joints.iter().zip(equilibrium_rad).zip(states);
        let torque = torques.map(|((joint, rest), (angle, velocity))| {
            joint.stiffness_nm_per_rad * (rest - angle) - joint.damping_nm_s_per_rad * velocity
        });
        let torque = DVector::from_iterator(self.arm.joints.len(), torque);
        let pressing = report.contacts.iter().map(|contact| contact.force_world.dot(contact.inward_world));
        Some((pressing.sum(), -per_newton.dot(&torque) / per_newton.norm_squared()))
    }
}

/// An arm among objects, all of which are simulated in every step, however far away. The skin's sensor is perfect.
pub fn simulation(arm: Arm, clutter: Clutter, physics: PhysicsOptions) -> Simulation {
    let sensor = Sensor::new(&SensorOptions::off(), &arm.skin, 0, "validate", 0);
    Simulation::new(Setup { arm, clutter, sensor, physics, dormancy: false })
}

/// Makes the coefficient of friction between an arm and an object so many times as large.
pub fn scale_friction(arm: &mut Arm, ratio: f64) {
    arm.friction = 2.0 * (friction_of(arm) * ratio) - FRICTION;
}

/// Makes the springs of an arm's joints so many times as stiff.
pub fn scale_stiffness(arm: &mut Arm, ratio: f64) {
    arm.joints.iter_mut().for_each(|joint| joint.stiffness_nm_per_rad *= ratio);
}

/// The coefficient of friction between an arm and an object: the mean of both surfaces' coefficients.
pub fn friction_of(arm: &Arm) -> f64 {
    0.5 * (arm.friction + FRICTION)
}

#[cfg(test)]
mod tests;
