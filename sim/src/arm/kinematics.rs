//! Forward kinematics and Jacobians of the chain (Craig, *Introduction to Robotics*, chapters 3 and 5), and inverse
//! kinematics: joint angles that bring the end effector to a point.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3xX, Vector3};
use underbrush_recording::Pose;

use super::Arm;

/// Distance from the point at which the end effector has arrived, m. Choice: a twentieth of a finger's breadth.
const ARRIVED_M: f64 = 1e-3;
/// Iterations. From half a metre away it takes about ten.
const ITERATIONS: usize = 40;
/// The end effector is moved at most this far in an iteration, m, because the Jacobian holds only near by.
const STRIDE_M: f64 = 0.15;
/// Damping, m: about a tenth of a lever arm, which bounds the step where the arm is stretched out.
const DAMPING_M: f64 = 0.05;

impl Arm {
    /// Poses of all links in the world frame at the given joint angles; missing angles count as 0.
    pub fn forward_kinematics(&self, joint_angle_rad: &[f64]) -> Vec<Pose> {
        let mut pose = Pose::IDENTITY;
        let mut link_poses = Vec::with_capacity(self.links.len());
        link_poses.push(pose);
        for (joint, angle) in self.joints.iter().zip(joint_angle_rad.iter().copied().chain(std::iter::repeat(0.0))) {
            let rotation = Pose::from_orientation(DQuat::from_axis_angle(joint.axis_child, angle));
            pose = pose * joint.origin_parent * rotation;
            link_poses.push(pose);
        }
        link_poses
    }

    /// Pose of the end effector in the world frame, from the poses of all links.
    pub fn end_effector_pose(&self, link_poses: &[Pose]) -> Pose {
        link_poses[self.end_effector_link] * self.end_effector_pose_link
    }

    /// Jacobian of the velocity of a point on a link, 3 × joints, m/rad, world frame: column j is
    /// axis_j × (point − origin_j), and zero for joints distal of the link.
    pub fn position_jacobian(&self, link_poses: &[Pose], link: usize, point_world: DVec3) -> Matrix3xX<f64> {
        self.jacobian(link_poses, link, |axis, origin| axis.cross(point_world - origin))
    }

    /// Jacobian of the angular velocity of a link, 3 × joints, world frame: column j is axis_j, and zero for joints
    /// distal of the link.
    pub fn angular_jacobian(&self, link_poses: &[Pose], link: usize) -> Matrix3xX<f64> {
        self.jacobian(link_poses, link, |axis, _| axis)
    }

    /// Adds the torques Jᵀ f that a force and a moment on a link exert on the joints, N m. `torque_nm` has one entry for each
    /// joint; joints distal of the link get none.
    pub fn add_torque_nm(
        &self,
        link_poses: &[Pose],
        link: usize,
        [point_world, force_world, moment_world]: [DVec3; 3],
        torque_nm: &mut [f64],
    ) {
        // Joint j carries link j + 1.
        for ((joint, pose), torque) in self.joints.iter().zip(&link_poses[1..]).zip(torque_nm).take(link) {
            let axis = pose.transform_vector(joint.axis_child);
            *torque += axis.dot((point_world - pose.position).cross(force_world) + moment_world);
        }
    }

    /// Mass matrix M of the joints, kg m², with the armatures on its diagonal: ½ q̇ᵀ M q̇ is the kinetic energy.
    pub fn mass_matrix(&self, link_poses: &[Pose]) -> DMatrix<f64> {
        let armatures = self.joints.iter().map(|joint| joint.armature_kg_m2);
        let mut sum = DMatrix::from_diagonal(&DVector::from_iterator(self.joints.len(), armatures));
        for (index, (link, pose)) in self.links.iter().zip(link_poses).enumerate() {
            let linear = self.position_jacobian(link_poses, index, pose.transform_point(link.center_of_mass_link));
            let angular = self.angular_jacobian(link_poses, index);
            let axes = DMat3::from_quat(pose.orientation);
            let inertia = Matrix3::from_column_slice(&(axes * link.inertia_link * axes.transpose()).to_cols_array());
            sum += linear.transpose() * &linear * link.mass_kg + angular.transpose() * inertia * angular;
        }
        sum
    }

    /// The rate at which the joints' damping D slows their slowest motion in a posture, 1/s: the smallest eigenvalue of
    /// M⁻¹ D. Zero if a motion is not damped.
    pub fn damping_rate_per_s(&self, posture_rad: &[f64]) -> f64 {
        let damping = self.joints.iter().map(|joint| joint.damping_nm_s_per_rad);
        let mut rates = DMatrix::from_diagonal(&DVector::from_iterator(self.joints.len(), damping));
        // M = L Lᵀ, and L⁻¹ D L⁻ᵀ has the same eigenvalues.
        let Some(root) = self.mass_matrix(&self.forward_kinematics(posture_rad)).cholesky() else { return 0.0 };
        root.l_dirty().solve_lower_triangular_mut(&mut rates);
        rates.transpose_mut();
        root.l_dirty().solve_lower_triangular_mut(&mut rates);
        rates.symmetric_eigenvalues().min()
    }

    /// Joint angles within the controller's limits at which the end effector is at `point_world` (m), to 1 mm. `None` if
    /// none is found from the angles `start_rad`; there may be others. Damped least squares (Wampler 1986), without the
    /// joints that are at a limit and would be pushed beyond it.
    pub fn posture_at(&self, point_world: DVec3, start_rad: &[f64]) -> Option<Vec<f64>> {
        let start = self.joints.iter().zip(start_rad);
        let mut angles: Vec<f64> = start.map(|(joint, angle)| joint.within_limits(*angle)).collect();
        for _ in 0..ITERATIONS {
            let poses = self.forward_kinematics(&angles);
            let end_effector_world = self.end_effector_pose(&poses).position;
            let missing = point_world - end_effector_world;
            if missing.length() <= ARRIVED_M {
                return Some(angles);
            }
            let toward = Vector3::from(missing.clamp_length_max(STRIDE_M).to_array());
            let mut jacobian = self.position_jacobian(&poses, self.end_effector_link, end_effector_world);
            for ((mut column, angle), joint) in jacobian.column_iter_mut().zip(&angles).zip(&self.joints) {
                let wanted = column.dot(&toward);
                let [low, high] = &joint.controller_limits_rad;
                if (wanted > 0.0 && angle >= high) || (wanted < 0.0 && angle <= low) {
                    column.fill(0.0);
                }
            }
            let damped = &jacobian * jacobian.transpose() + Matrix3::from_diagonal_element(DAMPING_M * DAMPING_M);
            let change = jacobian.transpose() * damped.cholesky()?.solve(&toward);
            for ((angle, change), joint) in angles.iter_mut().zip(change.iter()).zip(&self.joints) {
                *angle = joint.within_limits(*angle + change);
            }
        }
        None
    }

    fn jacobian(&self, link_poses: &[Pose], link: usize, column: impl Fn(DVec3, DVec3) -> DVec3) -> Matrix3xX<f64> {
        let mut jacobian = Matrix3xX::zeros(self.joints.len());
        let carrying = self.joints.iter().zip(&link_poses[1..]).take(link);
        for ((joint, pose), mut entries) in carrying.zip(jacobian.column_iter_mut()) {
            entries.copy_from_slice(&column(pose.orientation * joint.axis_child, pose.position).to_array());
        }
        jacobian
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Tests that at least 97 % of 400 points that the end effector can reach are found from one of five other postures, with
    /// angles within the limits that do reach them.
    #[test]
    fn reachable_points_are_found() {
        let arm = Arm::cody().unwrap();
        let within = |shares: &[f64; 7]| -> Vec<f64> {
            let limits = arm.joints.iter().map(|joint| joint.controller_limits_rad);
            limits.zip(shares).map(|([low, high], share)| low + (high - low) * share).collect()
        };
        let starts = [0.5, 0.25, 0.75, 0.9].map(|share| within(&[share; 7]));
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut count = 0;
        for _ in 0..400 {
            let posture = within(&[(); 7].map(|()| random.random::<f64>()));
            let point = arm.end_effector_pose(&arm.forward_kinematics(&posture)).position;
            let mut starts = [arm.start_posture_rad()].into_iter().chain(starts.clone());
            let Some(found) = starts.find_map(|start| arm.posture_at(point, &start)) else { continue };
            count += 1;
            let reached = arm.end_effector_pose(&arm.forward_kinematics(&found)).position;
            assert!(reached.distance(point) <= ARRIVED_M);
            for (angle, joint) in found.iter().zip(&arm.joints) {
                let [low, high] = joint.controller_limits_rad;
                assert!((low..=high).contains(angle));
            }
        }
        assert!(count >= 388, "{count} of 400");
    }
}
