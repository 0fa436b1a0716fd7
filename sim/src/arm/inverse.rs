//! Inverse kinematics: joint angles that bring the end effector to a point.

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

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
