//! Forward kinematics and Jacobians of the chain (Craig, *Introduction to Robotics*, chapters 3 and 5).

use glam::{DQuat, DVec3};
use nalgebra::Matrix3xX;
use underbrush_recording::Pose;

use super::Arm;

impl Arm {
    /// Poses of all links in the world frame at the given joint angles; missing angles count as 0.
    pub fn forward_kinematics(&self, joint_angle_rad: &[f64]) -> Vec<Pose> {
        let mut pose = Pose::IDENTITY;
        let mut link_poses = Vec::with_capacity(self.links.len());
        link_poses.push(pose);
        for (index, joint) in self.joints.iter().enumerate() {
            let angle = joint_angle_rad.get(index).copied().unwrap_or(0.0);
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

    fn jacobian(&self, link_poses: &[Pose], link: usize, column: impl Fn(DVec3, DVec3) -> DVec3) -> Matrix3xX<f64> {
        let mut jacobian = Matrix3xX::zeros(self.joints.len());
        for ((joint, pose), mut entries) in
            self.joints.iter().zip(&link_poses[1..]).zip(jacobian.column_iter_mut()).take(link)
        {
            let value = column(pose.orientation * joint.axis_child, pose.position);
            entries.copy_from_slice(&value.to_array());
        }
        jacobian
    }
}
