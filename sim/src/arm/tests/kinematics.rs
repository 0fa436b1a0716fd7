use glam::{DMat3, DMat4, DVec3};
use nalgebra::Matrix4;
use underbrush_recording::Pose;

use super::super::Arm;
use super::random_postures;

/// Modified Denavit-Hartenberg parameters of the arm as its authors give them: a (m), alpha (deg), d (m), offset (deg).
pub(super) const MODIFIED_DH: [[f64; 4]; 7] = [
    [0.0, 90.0, 0.18493, -90.0],
    [0.0, 90.0, 0.0, 90.0],
    [0.03175, 90.0, 0.27795, 90.0],
    [-0.00635, 90.0, 0.0, 0.0],
    [0.0, -90.0, 0.27853, 0.0],
    [0.0, 90.0, 0.0, 90.0],
    [0.0, 90.0, 0.0, 90.0],
];

/// Frames 1 to 7 of the table at joint angles q: Rot_x(alpha) Trans_x(a) Rot_z(q + offset) Trans_z(d), multiplied from
/// the base on (Craig, *Introduction to Robotics*, equation 3.6).
pub(super) fn modified_dh_frames(joint_angle_rad: &[f64]) -> Vec<Matrix4<f64>> {
    let mut frame = Matrix4::identity();
    MODIFIED_DH
        .iter()
        .zip(joint_angle_rad)
        .map(|([a, alpha, d, offset], angle)| {
            let (sin_alpha, cos_alpha) = alpha.to_radians().sin_cos();
            let (sin_theta, cos_theta) = (angle + offset.to_radians()).sin_cos();
            #[rustfmt::skip]
            let step = Matrix4::new(
                cos_theta, -sin_theta, 0.0, *a,
                sin_theta * cos_alpha, cos_theta * cos_alpha, -sin_alpha, -sin_alpha * d,
                sin_theta * sin_alpha, cos_theta * sin_alpha, cos_alpha, cos_alpha * d,
                0.0, 0.0, 0.0, 1.0,
            );
            frame *= step;
            frame
        })
        .collect()
}

pub(crate) fn matrix(pose: &Pose) -> Matrix4<f64> {
    Matrix4::from_column_slice(&DMat4::from_rotation_translation(pose.orientation, pose.position).to_cols_array())
}

#[test]
fn chain_is_that_of_the_modified_dh_table() {
    // Tests joint order, axes, signs and offsets of the URDF: every link frame moves with its DH frame, from which it
    // differs by a constant.
    let arm = Arm::cody().unwrap();
    let at_zero = arm.forward_kinematics(&[0.0; 7]);
    let constants: Vec<Matrix4<f64>> = modified_dh_frames(&[0.0; 7])
        .iter()
        .zip(&at_zero[1..])
        .map(|(dh, link)| dh.try_inverse().unwrap() * matrix(link))
        .collect();
    for posture in random_postures(&arm, 1000) {
        let links = arm.forward_kinematics(&posture);
        for ((dh, constant), link) in modified_dh_frames(&posture).iter().zip(&constants).zip(&links[1..]) {
            let difference = (dh * constant - matrix(link)).amax();
            assert!(difference < 1e-14, "off by {difference:e} at {posture:?}");
        }
    }
}

#[test]
fn zero_posture_hangs_straight_down() {
    // Tests the constants that the test above leaves open: link frames parallel to the base, each at its joint.
    let arm = Arm::cody().unwrap();
    let links = arm.forward_kinematics(&[0.0; 7]);
    let elbow = DVec3::new(0.00635, -0.18493 - 0.03175, -0.27795);
    let wrist = elbow - DVec3::Z * 0.27853;
    let shoulder = DVec3::Y * -0.18493;
    let expected = [DVec3::ZERO, DVec3::ZERO, shoulder, shoulder - DVec3::Y * 0.03175, elbow, wrist, wrist, wrist];
    for (link, origin) in links.iter().zip(expected) {
        assert!(link.position.distance(origin) < 1e-15);
        assert!((DMat3::from_quat(link.orientation) - DMat3::IDENTITY).abs_diff_eq(DMat3::ZERO, 1e-15));
    }
    assert!(arm.end_effector_pose(&links).position.distance(wrist - DVec3::Z * 0.27) < 1e-15);
}

#[test]
fn positive_angles_swing_forward_outward_and_bend() {
    // Tests the signs of the axes by the motions that a person would see.
    let arm = Arm::cody().unwrap();
    let end_effector = |joint: usize| {
        let mut posture = [0.0; 7];
        posture[joint] = 0.5;
        arm.end_effector_pose(&arm.forward_kinematics(&posture)).position
    };
    let rest = arm.end_effector_pose(&arm.forward_kinematics(&[0.0; 7])).position;
    assert!(end_effector(0).x > rest.x + 0.1, "flexion swings forward");
    assert!(end_effector(1).y < rest.y - 0.1, "abduction of a right arm swings to the right");
    assert!(end_effector(3).x > rest.x + 0.1, "the elbow bends forward");
    assert!(end_effector(5).x > rest.x + 0.1, "the wrist pitches forward");
}

#[test]
fn jacobians_are_the_derivatives_of_the_poses() {
    // Tests position and angular Jacobians of a point on every link against central differences.
    let arm = Arm::cody().unwrap();
    let step = 1e-6;
    for (round, posture) in random_postures(&arm, 1000).into_iter().enumerate() {
        let links = arm.forward_kinematics(&posture);
        let link = round % arm.links.len();
        let point_link = DVec3::new(0.03, -0.05, 0.02 * (round % 7) as f64);
        let position = arm.position_jacobian(&links, link, links[link].transform_point(point_link));
        let angular = arm.angular_jacobian(&links, link);
        for joint in 0..7 {
            let shifted = |by: f64| {
                let mut posture = posture.clone();
                posture[joint] += by;
                arm.forward_kinematics(&posture)[link]
            };
            let (ahead, behind) = (shifted(step), shifted(-step));
            let velocity = (ahead.transform_point(point_link) - behind.transform_point(point_link)) / (2.0 * step);
            let rotation_rate = (ahead.orientation * behind.orientation.inverse()).to_scaled_axis() / (2.0 * step);
            for row in 0..3 {
                // Truncation is of the order step² and rounding of 1e-16/step = 1e-10.
                assert!((position[(row, joint)] - velocity[row]).abs() < 2e-9);
                assert!((angular[(row, joint)] - rotation_rate[row]).abs() < 2e-9);
            }
            if joint >= link {
                assert_eq!(position.column(joint).amax(), 0.0, "joint {joint} cannot move link {link}");
            }
        }
    }
}
