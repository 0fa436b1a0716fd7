//! Whether the joint torques of a data set and the forces of its contacts explain the motion of the arm.
//!
//! The generalized momentum p = M q̇ changes by dp/dt = τ + Σ Jᵀ f + ½ ∂(q̇ᵀ M q̇)/∂q (Lagrange). All terms are those of the
//! stored frames and of the arm files in the set. Nothing is simulated.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::DVector;
use serde::Serialize;
use underbrush_recording::disk::{Dataset, DatasetPlan, SceneText};
use underbrush_recording::{FRAME_PERIOD_S, Fault, Frame, InputError};
use underbrush_sim::audit::min_contact_torque_nm;
use underbrush_sim::{Arm, ReachPlan, Scene};

use crate::dataset::stored_arm;

/// Impulses are compared over this many frames, 0.1 s.
const WINDOW_FRAMES: usize = 10;

/// Largest sound `residual_share` of contacts that are strong enough to compare with. A frame's force is its mean, but the Jacobian is that at its end, and the joints' torques
/// are taken to change linearly within it: at 0.5 rad/s each may be wrong by half a percent, and by more in the frames of
/// impacts.
const BOUND: f64 = 0.02;

/// Angles by which the kinetic energy is differentiated, rad.
const DIFFERENCE_RAD: f64 = 1e-5;

/// The torques of the reaches of one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TorqueBalance {
    /// Windows of 0.1 s with contact that were compared. Windows in which a joint is at its end stop are left out, because
    /// the stop's torque is not stored.
    pub windows: u32,
    /// Sum over the windows of the norm of ∫ Σ Jᵀ f dt, N m s.
    pub contact_impulse_nm_s: f64,
    /// Sum over the windows of the norm of ∫ τ dt, N m s.
    pub joint_impulse_nm_s: f64,
    /// Sum of the norms of the impulse that is missing, as a share of these two.
    pub residual_share: f64,
    /// What the share should not exceed. It is larger if the contacts are mostly too weak to compare with, and `None` if
    /// it would be 1 or more, which says nothing.
    pub bound: Option<f64>,
}

/// Compares the torques of each scene of a data set.
///
/// # Errors
/// If the set cannot be read, has no contacts, or its scenes or arms cannot be read.
pub fn torque_balance(path: &Path) -> Result<BTreeMap<String, TorqueBalance>, Fault> {
    let dataset = Dataset::open(path)?;
    let arms = arms(&dataset)?;
    let mut found: BTreeMap<String, TorqueBalance> = BTreeMap::new();
    for (index, episode) in dataset.episodes().iter().enumerate() {
        let Some(arm) = arms.get(&episode.scene) else { continue };
        let recording = dataset.read_reach(index)?;
        let is_touched = |frame: &Frame| frame.contact_force_world.iter().any(|force| force.length() > 0.0);
        if recording.frames.iter().any(|frame| is_touched(frame) && frame.contact_points.is_empty()) {
            let (found, allowed) = ("a touch without contact points", "a data set with truth/contact_points");
            let remedy = "generate it without `recording.contact_points = false`";
            return Err(InputError::new(path, "truth/contact_points", found, allowed, remedy).into());
        }
        found.entry(episode.scene.clone()).or_default().observe(arm, &recording.frames);
    }
    Ok(found)
}

impl TorqueBalance {
    /// Adds the frames of a reach of this arm.
    fn observe(&mut self, arm: &Arm, frames: &[Frame]) {
        let sum_nm_s = |own: &Self| own.contact_impulse_nm_s + own.joint_impulse_nm_s;
        let mut missing_nm_s = self.residual_share * sum_nm_s(self);
        for window in frames.windows(WINDOW_FRAMES + 1).step_by(WINDOW_FRAMES) {
            if let Some([contact, joints, missing]) = impulses(arm, window) {
                self.windows += 1;
                self.contact_impulse_nm_s += contact.norm();
                self.joint_impulse_nm_s += joints.norm();
                missing_nm_s += missing.norm();
            }
        }
        let all_nm_s = sum_nm_s(self);
        let window_s = WINDOW_FRAMES as f64 * FRAME_PERIOD_S;
        let weak_nm_s = min_contact_torque_nm(arm) * window_s * f64::from(self.windows);
        // Without windows this is NaN, which `max` passes over.
        let bound = BOUND * (weak_nm_s / all_nm_s).max(1.0);
        self.bound = (bound < 1.0).then_some(bound);
        self.residual_share = if self.windows > 0 { missing_nm_s / all_nm_s } else { 0.0 };
    }
}

/// The arm of each scene, with the stiffness that the scene asks for.
///
/// # Errors
/// If a scene or an arm is bad, or an arm has other joints than the frames.
fn arms(dataset: &Dataset) -> Result<BTreeMap<String, Arm>, InputError> {
    let DatasetPlan { provenance, joint_names, .. } = dataset.plan();
    let arm = |scene: &SceneText| {
        let files = provenance.arms.get(scene.arm).map(|arm| arm.files.as_slice()).unwrap_or_default();
        let arm = stored_arm(files)?;
        let plan = ReachPlan::with_arm(Scene::parse(&scene.file.name, scene.file.text.clone())?, Some(arm), None, 0)?;
        let own: Vec<&str> = plan.arm.joints.iter().map(|joint| joint.name.as_str()).collect();
        if own != *joint_names {
            let (path, field) = (dataset.dir().join("meta/provenance.json"), format!("arms[{}]", scene.arm));
            let allowed = format!("those of the frames: {}", joint_names.join(", "));
            let remedy = "give a data set that `underbrush generate` made";
            return Err(InputError::new(path, field, format!("the joints {}", own.join(", ")), allowed, remedy));
        }
        Ok((scene.name.clone(), plan.arm))
    };
    provenance.scenes.iter().map(arm).collect()
}

/// The impulses of contacts and joints in a window, and the part of the change of momentum that nothing explains, N m s.
/// `None` if nothing is touched or a joint is at a stop.
fn impulses(arm: &Arm, window: &[Frame]) -> Option<[DVector<f64>; 3]> {
    let is_at_stop =
        |frame: &Frame| arm.joints.iter().zip(&frame.joint_angle_rad).any(|(joint, angle)| joint.is_at_stop(*angle));
    let (first, last) = (window.first()?, window.last()?);
    if window[1..].iter().all(|frame| frame.contact_points.is_empty()) || window.iter().any(is_at_stop) {
        return None;
    }
    let zeros = || DVector::zeros(arm.joints.len());
    let (mut contact, mut joints, mut slope) = (zeros(), zeros(), zeros());
    for (before, frame) in window.iter().zip(&window[1..]) {
        // A frame's contact forces are means over it.
        contact += contact_torque_nm(arm, frame);
        joints += mean_joint_torque_nm(arm, before, frame);
        slope += (energy_slope_nm(arm, before) + energy_slope_nm(arm, frame)) * 0.5;
    }
    let explained = (&contact + &joints + slope) * FRAME_PERIOD_S;
    let missing = momentum_nm_s(arm, last) - momentum_nm_s(arm, first) - explained;
    Some([contact * FRAME_PERIOD_S, joints * FRAME_PERIOD_S, missing])
}

/// The mean torques of the joints' springs and dampers over a frame, N m. The springs' rest angles change at its beginning;
/// they follow from the torques at its end.
fn mean_joint_torque_nm(arm: &Arm, before: &Frame, frame: &Frame) -> DVector<f64> {
    DVector::from_fn(arm.joints.len(), |at, _| {
        let (stiffness, damping) = (arm.joints[at].stiffness_nm_per_rad, arm.joints[at].damping_nm_s_per_rad);
        let turned_rad = frame.joint_angle_rad[at] - before.joint_angle_rad[at];
        let gained = frame.joint_velocity_rad_per_s[at] - before.joint_velocity_rad_per_s[at];
        frame.joint_torque_nm[at] + 0.5 * (stiffness * turned_rad + damping * gained)
    })
}

/// M q̇, N m s.
fn momentum_nm_s(arm: &Arm, frame: &Frame) -> DVector<f64> {
    let poses = arm.forward_kinematics(&frame.joint_angle_rad);
    arm.mass_matrix(&poses) * DVector::from_column_slice(&frame.joint_velocity_rad_per_s)
}

/// ½ ∂(q̇ᵀ M q̇)/∂q, N m, by central differences.
fn energy_slope_nm(arm: &Arm, frame: &Frame) -> DVector<f64> {
    let velocity = DVector::from_column_slice(&frame.joint_velocity_rad_per_s);
    let energy_j = |joint: usize, change_rad: f64| {
        let mut angle_rad = frame.joint_angle_rad.clone();
        angle_rad[joint] += change_rad;
        0.5 * velocity.dot(&(arm.mass_matrix(&arm.forward_kinematics(&angle_rad)) * &velocity))
    };
    let slope =
        |joint, _| (energy_j(joint, DIFFERENCE_RAD) - energy_j(joint, -DIFFERENCE_RAD)) / (2.0 * DIFFERENCE_RAD);
    DVector::from_fn(arm.joints.len(), slope)
}

/// The torques of a frame's contacts on the joints, N m.
fn contact_torque_nm(arm: &Arm, frame: &Frame) -> DVector<f64> {
    let poses = arm.forward_kinematics(&frame.joint_angle_rad);
    let mut torque_nm = DVector::zeros(arm.joints.len());
    for point in &frame.contact_points {
        let wrench = [point.position_world, point.force_world, point.moment_world].map(|part| part.as_dvec3());
        arm.add_torque_nm(&poses, point.link.into(), wrench, torque_nm.as_mut_slice());
    }
    torque_nm
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

    use super::*;

    /// Tests that a reach in which an arm hardly touches anything is sound, and is not if the stored forces were 50 % too large.
    #[test]
    fn weak_contacts_balance() {
        let plan = ReachPlan::new(Scene::open("soft-rolls").unwrap(), None, 10001).unwrap();
        let mut frames = plan.run(0, &mut |_| {}).unwrap().frames;
        let balance = |frames: &[Frame]| {
            let mut balance = TorqueBalance::default();
            balance.observe(&plan.arm, frames);
            balance
        };
        let sound = balance(&frames);
        let bound = sound.bound.unwrap();
        assert!(bound > BOUND && sound.residual_share < bound, "{sound:?}");
        for point in frames.iter_mut().flat_map(|frame| &mut frame.contact_points) {
            point.force_world *= 1.5;
        }
        let wrong = balance(&frames);
        assert!(wrong.residual_share > wrong.bound.unwrap(), "{wrong:?}");
    }

    /// Tests that an arm at rest on which no more than a millinewton presses has no bound, which would be above 1.
    #[test]
    fn contacts_that_are_too_weak_have_no_bound() {
        let plan = ReachPlan::new(Scene::open("trunk").unwrap(), None, 11).unwrap();
        let frames = plan.run(0, &mut |_| {}).unwrap().frames;
        let mut point = frames.iter().find_map(|frame| frame.contact_points.first().copied()).unwrap();
        point.force_world = point.normal_world * 1e-3;
        point.moment_world *= 0.0;
        let mut still = frames[0].clone();
        still.joint_velocity_rad_per_s.fill(0.0);
        still.joint_torque_nm.fill(0.0);
        still.contact_points = vec![point];
        let mut balance = TorqueBalance::default();
        balance.observe(&plan.arm, &vec![still; WINDOW_FRAMES + 1]);
        assert_eq!((balance.windows, balance.bound), (1, None), "{balance:?}");
    }

    /// Tests that the torques of a reach balance, and that they do not if the stored forces were 30 % too large.
    #[test]
    fn wrong_forces_do_not_balance() {
        let plan = ReachPlan::new(Scene::open("trunk").unwrap(), None, 11).unwrap();
        let mut recording = plan.run(0, &mut |_| {}).unwrap();
        let balance = |frames: &[Frame]| {
            let mut balance = TorqueBalance::default();
            balance.observe(&plan.arm, frames);
            balance
        };
        let sound = balance(&recording.frames);
        assert!(sound.windows > 20 && sound.residual_share < 0.5 * BOUND, "{sound:?}");
        for point in recording.frames.iter_mut().flat_map(|frame| &mut frame.contact_points) {
            point.force_world *= 1.3;
        }
        let wrong = balance(&recording.frames);
        assert!(wrong.residual_share > 2.0 * BOUND, "{wrong:?}");
    }
}
