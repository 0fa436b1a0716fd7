//! Cody's arm pressed with its forearm against one object.

use glam::DVec3;
use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::{FRAME_PERIOD_S, Pose};
use underbrush_sim::arm::Arm;
use underbrush_sim::clutter::{Clutter, PlacedObject};
use underbrush_sim::object::Object;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::skin::{ContactPoint, SkinPatch};
use underbrush_sim::world::World;

use crate::CheckError;

/// Steps of 5 ms in four substeps: half as long as scenes use unless they say otherwise.
pub const OPTIONS: PhysicsOptions = PhysicsOptions {
    step_s: 0.005,
    substeps: 4,
    gravity_m_per_s2: 9.81,
};

/// A leaf for the forearm to push.
pub const LEAF: Leaf = Leaf {
    height_m: 0.4,
    width_m: 0.03,
    flexural_rigidity_n_m2: 0.02,
    mass_per_area_kg_per_m2: 0.8,
    loss_factor: 0.2,
    root_stiffness_nm_per_rad: Some(2.0),
    segments: 5,
};

/// Where on the forearm's axis the object is touched, m, link frame: under its skin.
const PLACE_LINK: DVec3 = DVec3::new(0.0, 0.0, 0.10);
/// Radius of the forearm's collision shape, m.
pub const FOREARM_RADIUS_M: f64 = 0.04604;

/// The arm in its start posture, an object beside its forearm, and equilibrium angles that press one on the other.
pub struct PressedArm {
    /// The arm as the closed form describes it.
    pub arm: Arm,
    /// The engine.
    pub world: World,
    /// The one object.
    pub clutter: Clutter,
    /// The start posture, rad.
    pub posture_rad: Vec<f64>,
    /// Index of the forearm.
    pub forearm: usize,
    /// The pushing direction: horizontal, across the forearm, unit.
    pub across_world: DVec3,
    simulated: Arm,
}

impl PressedArm {
    /// `gap_m` from the forearm's surface to the object's middle, which stands with its foot `drop_m` under the
    /// forearm's axis and, if it is a leaf, faces the forearm. The engine gets the arm `simulated`, `arm` stays what the
    /// closed form describes.
    ///
    /// # Errors
    /// When the arm has no forearm.
    pub fn new(
        arm: Arm,
        simulated: Arm,
        object: Box<dyn Object>,
        gap_m: f64,
        drop_m: f64,
        options: PhysicsOptions,
    ) -> Result<Self, CheckError> {
        let posture_rad = arm.start_posture_rad();
        let poses = arm.forward_kinematics(&posture_rad);
        let forearm = arm
            .link_index("forearm")
            .ok_or_else(|| CheckError::Case("the arm has no forearm".into()))?;
        let place = poses[forearm].transform_point(PLACE_LINK);
        let along = poses[forearm].transform_vector(DVec3::Z);
        let across_world = DVec3::Z.cross(along).normalize();
        let foot_world = place + across_world * (FOREARM_RADIUS_M + gap_m) - DVec3::Z * drop_m;
        let objects = vec![PlacedObject {
            object,
            foot_world,
            yaw_rad: across_world.y.atan2(across_world.x),
        }];
        let clutter = Clutter {
            objects,
            goals: Vec::new(),
        };
        let world = World::new(&simulated, &posture_rad, &clutter, options, false);
        Ok(PressedArm {
            arm,
            world,
            clutter,
            posture_rad,
            forearm,
            across_world,
            simulated,
        })
    }

    /// Turns the object where it stands, before the arm has moved, rad.
    pub fn turn(&mut self, turn_rad: f64) {
        for placed in &mut self.clutter.objects {
            placed.yaw_rad += turn_rad;
        }
        let options = self.world.physics.options;
        self.world = World::new(&self.simulated, &self.posture_rad, &self.clutter, options, false);
    }

    /// Makes the friction of everything in the engine `factor` times what it was.
    pub fn scale_friction(&mut self, factor: f64) {
        for (_, collider) in self.world.physics.colliders.iter_mut() {
            collider.set_friction(factor * collider.friction());
        }
    }

    /// Equilibrium angles that would press with `force_n` across the forearm if nothing moved, rad.
    pub fn pressing_rad(&self, force_n: f64) -> Vec<f64> {
        let poses = self.arm.forward_kinematics(&self.posture_rad);
        let place = poses[self.forearm].transform_point(PLACE_LINK);
        let torque = self.jacobian(&poses, place).transpose() * Vector3::from(self.across_world.to_array()) * force_n;
        let springs = self.posture_rad.iter().zip(&self.arm.joints).zip(torque.iter());
        springs
            .map(|((angle, joint), torque)| angle + torque / joint.stiffness_nm_per_rad)
            .collect()
    }

    /// Equilibrium angles that move the place on the forearm by `distance_m` across it and nowhere else if nothing is in
    /// the way, with the least energy of the springs, rad.
    pub fn moving_rad(&self, distance_m: f64) -> Vec<f64> {
        let mut moved = self.posture_rad.clone();
        let start = self.arm.forward_kinematics(&moved)[self.forearm].transform_point(PLACE_LINK);
        let goal = start + self.across_world * distance_m;
        // Newton's method: the way is short, three steps would do.
        for _ in 0..6 {
            let poses = self.arm.forward_kinematics(&moved);
            let place = poses[self.forearm].transform_point(PLACE_LINK);
            let jacobian = self.jacobian(&poses, place);
            let softness = self.arm.joints.iter().map(|joint| 1.0 / joint.stiffness_nm_per_rad);
            let softness = DMatrix::from_diagonal(&DVector::from_iterator(moved.len(), softness));
            let back = &softness * jacobian.transpose();
            let missing = Vector3::from((goal - place).to_array());
            let Some(force) = (&jacobian * &back).lu().solve(&missing) else {
                return moved;
            };
            let step = back * force;
            moved
                .iter_mut()
                .zip(step.iter())
                .for_each(|(angle, step)| *angle += step);
        }
        moved
    }

    /// Holds equilibrium angles for some time.
    pub fn hold(&mut self, equilibrium_rad: &[f64], seconds: f64) {
        for _ in 0..(seconds / FRAME_PERIOD_S).round() as usize {
            self.world
                .advance_frame(&self.simulated, equilibrium_rad, &self.clutter);
        }
    }

    /// Holds for a frame the equilibrium angles that lie `share` of the way from the start posture to `goal_rad`.
    pub fn hold_part_way(&mut self, goal_rad: &[f64], share: f64) {
        let angle = |(start, goal): (&f64, &f64)| start + share * (goal - start);
        let equilibrium: Vec<f64> = self.posture_rad.iter().zip(goal_rad).map(angle).collect();
        self.hold(&equilibrium, FRAME_PERIOD_S);
    }

    /// Jacobian of a point on the forearm, world frame.
    pub fn jacobian(&self, poses: &[Pose], point_world: DVec3) -> Matrix3xX<f64> {
        self.arm.position_jacobian(poses, self.forearm, point_world)
    }

    /// Joint angles, rad.
    pub fn angles_rad(&self) -> Vec<f64> {
        self.world.arm.joint_angle_rad(&self.world.physics)
    }

    /// The contacts on each patch of skin, by the shape that makes them.
    pub fn touched<'a>(
        &self,
        patches: &'a [SkinPatch],
    ) -> impl Iterator<Item = (&'a SkinPatch, Vec<ContactPoint>, ColliderHandle)> {
        let mut groups: Vec<(usize, ColliderHandle, Vec<ContactPoint>)> = Vec::new();
        for contact in self.world.contacts() {
            let pose = self.world.link_pose(contact.link);
            let point = contact.in_link_frame(&pose);
            let covers = |patch: &SkinPatch| patch.link == contact.link && patch.covers(&point);
            let Some(patch) = patches.iter().position(covers) else {
                continue;
            };
            let group = groups
                .iter_mut()
                .find(|group| group.0 == patch && group.1 == contact.collider);
            match group {
                Some(group) => group.2.push(point),
                None => groups.push((patch, contact.collider, vec![point])),
            }
        }
        let named = groups.into_iter();
        named.map(|(patch, collider, points)| (&patches[patch], points, collider))
    }

    /// Velocity of a point of a link, m/s, world frame.
    pub fn velocity_world(&self, link: usize, point_link: DVec3) -> DVec3 {
        let body = &self.world.physics.bodies[self.world.arm.links[link]];
        body.velocity_at_point(body.position().transform_point(point_link))
    }

    /// Sum of the contact forces on the arm, N, world frame.
    pub fn contact_force_world(&self) -> DVec3 {
        self.world.contacts().iter().map(|contact| contact.force_world).sum()
    }

    /// Σ Jᵀ f of the contacts, Nm, one per joint.
    pub fn contact_torque_nm(&self) -> DVector<f64> {
        let poses = self.arm.forward_kinematics(&self.angles_rad());
        let mut torque = DVector::zeros(self.arm.joints.len());
        for contact in self.world.contacts() {
            let point = poses[contact.link].transform_point(contact.position_link);
            let jacobian = self.arm.position_jacobian(&poses, contact.link, point);
            torque += jacobian.transpose() * Vector3::from(contact.force_world.to_array());
        }
        torque
    }
}
