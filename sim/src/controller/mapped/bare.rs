//! Contacts of parts without skin, from the torques of the joints.
//!
//! Gravity is compensated, so the torque K (φ − q) − D q̇ − M q̈ balances the contacts of the arm. What the skin's
//! contacts do not explain is explained by one force along the normal of the bare surface where it fits best
//! (De Luca and Mattone, ICRA 2005, give the residual; the search over the surface is a choice).

use glam::DVec3;
use nalgebra::{DVector, Vector3};
use underbrush_recording::{ObstacleKind, Pose, math};

use super::arm_shapes::ArmShapes;
use super::map::Touch;
use crate::{Arm, ControllerInput};

/// Torques below this are friction and what is not known of the acceleration, N m: 3 N at a third of a metre.
const LEAST_NM: f64 = 1.0;
/// A force explains the torques if what is left of them is below this share.
const UNEXPLAINED: f64 = 0.4;
/// Stations along a shape, and directions around it.
const STATIONS: usize = 5;
const DIRECTIONS: usize = 8;
/// A point this close to a taxel's centre is under the skin, m: the pitch of the skin that ships.
const UNDER_SKIN_M: f64 = 0.02;

/// Points of an arm's bare surface with their outward normals, by link, in its frame.
#[derive(Clone, Debug)]
pub(super) struct BareSurface {
    points: Vec<(usize, DVec3, DVec3)>,
}

impl BareSurface {
    pub(super) fn new(arm: &Arm, shapes: &ArmShapes) -> Self {
        let patches = || arm.skin.layout.patches.iter().zip(&arm.skin.surfaces);
        let is_bare = |link: usize, point: DVec3| {
            let taxels = patches().filter(|(_, own)| own.link == link).flat_map(|(patch, _)| &patch.taxels);
            taxels.into_iter().all(|taxel| taxel.position_link.distance(point) > UNDER_SKIN_M)
        };
        let mut points = Vec::new();
        for (link, capsule) in shapes.capsules_link() {
            let (side, other) = (capsule.end - capsule.start).normalize_or(DVec3::Z).any_orthonormal_pair();
            for station in 0..STATIONS {
                let middle = capsule.start.lerp(capsule.end, (station as f64 + 0.5) / STATIONS as f64);
                for direction in 0..DIRECTIONS {
                    let angle_rad = std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64;
                    let normal = side * math::cos(angle_rad) + other * math::sin(angle_rad);
                    let point = middle + normal * capsule.radius_m;
                    if is_bare(link, point) {
                        points.push((link, point, normal));
                    }
                }
            }
        }
        BareSurface { points }
    }

    /// The force on the bare surface that explains the torques that the skin's contacts do not explain, N, and where it
    /// acts; with it, how fast a change of the joint angles moves that place into what presses, m/rad each. `acceleration`
    /// is that of the joints, rad/s².
    pub(super) fn touch(
        &self,
        arm: &Arm,
        link_poses: &[Pose],
        input: &ControllerInput,
        acceleration: &DVector<f64>,
        time_s: f64,
    ) -> Option<(f64, Touch, DVector<f64>)> {
        let vector = |vector: DVec3| Vector3::from(vector.to_array());
        let joints = arm.joints.iter().enumerate().map(|(index, joint)| {
            let spring_nm =
                joint.stiffness_nm_per_rad * (input.equilibrium_angle_rad[index] - input.joint_angle_rad[index]);
            spring_nm.clamp(-joint.torque_limit_nm, joint.torque_limit_nm)
                - joint.damping_nm_s_per_rad * input.joint_velocity_rad_per_s[index]
        });
        let mut torque = DVector::from_iterator(arm.joints.len(), joints);
        for contact in &input.contacts {
            torque += contact.position_jacobian.tr_mul(&vector(contact.inward_normal_world)) * contact.force_n;
        }
        // Where inertia may explain the torques, nothing is known of a contact. To subtract it costs Cody goals (29 instead of 32 of
        // 40 in `gate`, seed 520).
        let torque_nm = torque.norm();
        let inertial_nm = || (arm.mass_matrix(link_poses) * acceleration).norm();
        if torque_nm < LEAST_NM || torque_nm < LEAST_NM + inertial_nm() {
            return None;
        }
        let fit = |(link, point, normal): &(usize, DVec3, DVec3)| {
            let (pose, normal_world) = (&link_poses[*link], link_poses[*link].transform_vector(*normal));
            let position_world = pose.transform_point(*point);
            let into = arm.position_jacobian(link_poses, *link, position_world).tr_mul(&vector(normal_world));
            let force_n = into.dot(&torque) / into.norm_squared().max(f64::MIN_POSITIVE);
            let touch =
                Touch { position_world, outward_normal_world: normal_world, kind: ObstacleKind::Doubtful, time_s };
            let left = (&torque - &into * force_n).norm() / torque.norm();
            (left, force_n, touch, DVector::from_column_slice(into.as_slice()))
        };
        let fits = self.points.iter().map(fit).filter(|(left, force_n, ..)| *force_n > 0.0 && *left < UNEXPLAINED);
        fits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, force_n, touch, into)| (force_n, touch, into))
    }
}
