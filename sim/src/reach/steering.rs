//! The controller within a reach: when it is called, its input, and its answers.

use glam::DVec3;
use underbrush_recording::{FRAME_PERIOD_S, Frame, TaxelReading};

use super::ReachError;
use super::plan::ReachPlan;
use crate::controller::{ContactVerdict, ControlStatus, Controller, ControllerInput, Intent, TaxelContact, Touched};
use crate::{PlacedObject, Simulation};

/// A controller and the equilibrium angles that it has set.
pub(crate) struct Steering {
    pub(crate) controller: Box<dyn Controller>,
    /// Whether the controller is told the true categories.
    has_true_verdicts: bool,
    /// Equilibrium angles φ, rad.
    pub(crate) equilibrium_rad: Vec<f64>,
    /// What the controller said that it is about to do.
    pub(super) intent: Intent,
}

impl Steering {
    /// The plan's controller at the start of a reach, with the equilibrium angles of the arm's start posture.
    pub(crate) fn new(plan: &ReachPlan) -> Self {
        Steering {
            controller: plan.controller.make(&plan.arm),
            has_true_verdicts: plan.has_true_verdicts,
            equilibrium_rad: plan.arm.start_posture_rad(),
            intent: Intent::default(),
        }
    }

    /// Shows the present frame to the controller, calls it if it is due, and applies the equilibrium angles that it returns.
    /// Returns how it obtained them, if it was called.
    ///
    /// # Errors
    /// [`ReachError::EquilibriumAngles`] and [`ReachError::NoAngle`].
    pub(crate) fn control(
        &mut self,
        simulation: &Simulation,
        frame: &Frame,
        goal_position_world: DVec3,
    ) -> Result<Option<ControlStatus>, ReachError> {
        // The controller sees what a robot knows of the frame.
        self.controller.observe(&frame.sensed());
        let (arm, report) = (simulation.arm(), simulation.report());
        if !is_due(report.frame, self.controller.rate_hz()) {
            return Ok(None);
        }
        let joint_angle_rad = report.joint_angle_rad();
        // A robot knows its pose from its encoders, so the controller gets the poses that follow from the joint angles.
        let link_poses = arm.forward_kinematics(&joint_angle_rad);
        let end_effector_pose_world = arm.end_effector_pose(&link_poses);
        let sensed = report.tactile.taxels.iter().filter(|taxel| taxel.sensed_force_n > 0.0);
        let contact = |reading: &TaxelReading| {
            let patch = usize::from(reading.patch);
            let index = usize::from(reading.taxel);
            let taxel = &arm.skin.layout.patches[patch].taxels[index];
            let link = arm.skin.surfaces[patch].link;
            let position_world = link_poses[link].transform_point(taxel.position_link);
            TaxelContact {
                patch,
                taxel: index,
                link,
                position_world,
                position_jacobian: arm.position_jacobian(&link_poses, link, position_world),
                inward_normal_world: -link_poses[link].transform_vector(taxel.normal_link),
                force_n: reading.sensed_force_n,
                allowed_force_n: None,
                verdict: self.has_true_verdicts.then(|| true_verdict(reading, &simulation.clutter().objects)),
            }
        };
        let contacts = sensed.map(contact).collect();
        let end_effector_jacobian =
            arm.position_jacobian(&link_poses, arm.end_effector_link, end_effector_pose_world.position);
        let output = self.controller.control(&ControllerInput {
            joint_angle_rad,
            joint_velocity_rad_per_s: report.joint_velocity_rad_per_s(),
            equilibrium_angle_rad: self.equilibrium_rad.clone(),
            end_effector_pose_world,
            end_effector_jacobian,
            goal_position_world,
            contacts,
        });
        let controller = || self.controller.name().to_owned();
        let (found, expected) = (output.equilibrium_angle_rad.len(), arm.joints.len());
        if found != expected {
            return Err(ReachError::EquilibriumAngles { controller: controller(), found, expected });
        }
        let mut angles = output.equilibrium_angle_rad.iter().enumerate();
        if let Some((joint, found)) = angles.find(|(_, angle)| !angle.is_finite()) {
            return Err(ReachError::NoAngle { controller: controller(), joint, found: *found });
        }
        self.equilibrium_rad = output.equilibrium_angle_rad;
        self.intent = output.intent;
        Ok(Some(output.status))
    }
}

/// What truly touches a taxel.
fn true_verdict(reading: &TaxelReading, objects: &[PlacedObject]) -> ContactVerdict {
    let object = reading.object.filter(|_| reading.true_normal_force_n > 0.0);
    let object = object.and_then(|object| objects.get(usize::from(object)));
    let touched = object.map_or(Touched::Nothing, |placed| Touched::Category(placed.category.name().into()));
    ContactVerdict { touched, probability: 1.0 }
}

/// Whether a controller of this rate is due in a frame: in the first one, and whenever a new control period has begun
/// since the frame before.
fn is_due(frame: u32, rate_hz: f64) -> bool {
    let periods = |frame: u32| (f64::from(frame) * rate_hz * FRAME_PERIOD_S).floor();
    frame == 0 || periods(frame) > periods(frame - 1)
}

#[cfg(test)]
mod tests {
    use super::is_due;

    /// Tests in which frames controllers of several rates are called, also if the period is not a whole number of
    /// frames: at most once per frame.
    #[test]
    fn controllers_are_called_at_their_rate() {
        let due = |rate_hz: f64| -> Vec<u32> { (0..12).filter(|frame| is_due(*frame, rate_hz)).collect() };
        assert_eq!(due(25.0), [0, 4, 8]);
        assert_eq!(due(40.0), [0, 3, 5, 8, 10]);
        assert_eq!(due(100.0), (0..12).collect::<Vec<_>>());
        assert_eq!(due(1000.0), (0..12).collect::<Vec<_>>());
    }
}
