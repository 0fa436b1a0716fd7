//! Controllers: from joint state, skin and goal to new equilibrium angles, once per control period.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use nalgebra::Matrix3xX;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Frame, MappedObstacle, Pose};

mod kind;
pub mod mapped;
pub mod model_predictive;
pub mod preset;
pub mod quadratic_program;

pub use kind::{ControllerKind, UnknownController};
pub use mapped::Mapped;
pub use model_predictive::ModelPredictive;
pub use preset::Preset;

/// The input of a controller at one instant. There are n joints; Jacobians are 3 × n in the world frame.
#[derive(Clone, Debug)]
pub struct ControllerInput {
    /// Joint angles q, rad, n.
    pub joint_angle_rad: Vec<f64>,
    /// Joint velocities dq/dt, rad/s, n.
    pub joint_velocity_rad_per_s: Vec<f64>,
    /// Equilibrium angles φ, rad, n.
    pub equilibrium_angle_rad: Vec<f64>,
    /// Pose of the end effector.
    pub end_effector_pose_world: Pose,
    /// Jacobian of the end effector's position, m/rad.
    pub end_effector_jacobian: Matrix3xX<f64>,
    /// Goal of the end effector, m, world frame.
    pub goal_position_world: DVec3,
    /// Every taxel that senses a force.
    pub contacts: Vec<TaxelContact>,
}

/// One taxel that senses a force.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelContact {
    /// Index of the patch in the skin's layout.
    pub patch: usize,
    /// Index of the taxel in its patch.
    pub taxel: usize,
    /// The link that carries it, index in [`crate::arm::Arm::links`].
    pub link: usize,
    /// The taxel's centre, m, world frame.
    pub position_world: DVec3,
    /// Jacobian of the velocity of the taxel's centre, m/rad, 3 × n, world frame; zero for joints distal of its link.
    pub position_jacobian: Matrix3xX<f64>,
    /// The taxel's inward unit normal, world frame: the direction of the force on the arm.
    pub inward_normal_world: DVec3,
    /// Sensed force along it, N.
    pub force_n: f64,
    /// Force that this contact should not exceed, N, if it differs from the controller's own limit for all contacts.
    pub allowed_force_n: Option<f64>,
    /// What touches the taxel, if something judges it.
    pub verdict: Option<ContactVerdict>,
}

/// What touches a taxel.
///
/// ```
/// use underbrush_sim::controller::Touched;
///
/// assert_eq!(Touched::Category("leaf".into()).name(), "leaf");
/// assert_eq!(Touched::Unknown.name(), "unknown");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Touched {
    /// Nothing: a spurious reading.
    Nothing,
    /// An object of the category with this name.
    Category(Arc<str>),
    /// An object of a known category, but it is not yet certain which.
    Uncertain,
    /// An object unlike all known categories.
    Unknown,
}

impl Touched {
    /// Its name: `nothing`, a category, `uncertain` or `unknown`.
    pub fn name(&self) -> &str {
        match self {
            Touched::Nothing => "nothing",
            Touched::Category(name) => name,
            Touched::Uncertain => "uncertain",
            Touched::Unknown => "unknown",
        }
    }
}

/// A judgement of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactVerdict {
    /// What touches the taxel.
    pub touched: Touched,
    /// How probable that is; of an uncertain verdict, the probability of the likeliest category.
    pub probability: f64,
}

/// How hard the arm may press on which objects, N. The controller's own limit holds for everything else.
///
/// ```
/// use underbrush_sim::controller::AllowedForces;
///
/// let allowed = AllowedForces::default();
/// assert!(allowed.categories_n["trunk"] < allowed.categories_n["leaf"]);
/// assert_eq!(allowed.unknown_n, None);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedForces {
    /// The limits by the name of a category, N.
    pub categories_n: BTreeMap<String, f64>,
    /// The limit on objects unlike all known categories, N, if they have one.
    pub unknown_n: Option<f64>,
}

impl Default for AllowedForces {
    /// 6 N on leaves, twice the 3 N of `cody-2013`. A leaf bends away before a taxel feels as much (5.4 N at most in 14
    /// mixed reaches), so this limit hardly ever holds the arm back. 1.5 N on trunks, half of the
    /// limit of `cody-2013`. This limit must be above 1 N, the force at which the controller begins to take a reading
    /// for a contact, because the force of a contact over its limit may not rise at all.
    fn default() -> Self {
        AllowedForces { categories_n: [("leaf".to_owned(), 6.0), ("trunk".to_owned(), 1.5)].into(), unknown_n: None }
    }
}

impl AllowedForces {
    /// Gives a contact its verdict, and the limit that the verdict gives, if it gives one; false if nothing touches the taxel.
    pub fn apply(&self, contact: &mut TaxelContact, verdict: Option<ContactVerdict>) -> bool {
        let limit_n = match verdict.as_ref().map(|verdict| &verdict.touched) {
            Some(Touched::Nothing) => return false,
            Some(Touched::Category(name)) => self.categories_n.get(&**name).copied(),
            Some(Touched::Unknown) => self.unknown_n,
            Some(Touched::Uncertain) | None => None,
        };
        contact.allowed_force_n = limit_n.or(contact.allowed_force_n);
        contact.verdict = verdict;
        true
    }
}

/// A controller's answer.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerOutput {
    /// New equilibrium angles φ, rad, n.
    pub equilibrium_angle_rad: Vec<f64>,
    /// How they were obtained.
    pub status: ControlStatus,
    /// What the controller is about to do.
    pub intent: Intent,
}

/// What a controller is about to do. The reach cannot see it from the motion of the end effector.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Intent {
    /// To go on to the goal. An end effector that makes no progress is stuck.
    #[default]
    Onward,
    /// To turn round, back off or plan, or to go on by its own rules of progress: the end effector need not make progress meanwhile.
    TurningRound,
    /// To give the goal up, for this reason, which is recorded.
    GivenUp(String),
}

/// How a controller obtained its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ControlStatus {
    /// The optimization was solved.
    Solved,
    /// No change of φ satisfies all bounds: φ stays where the step started.
    Infeasible,
    /// The optimization failed numerically (NaN in the input, or rounding): φ stays where the step started.
    Failed,
}

/// A controller of an arm. It may keep state; every reach gets a controller of its own.
pub trait Controller: Send {
    /// Name in recordings.
    fn name(&self) -> &str;

    /// How often [`Controller::control`] is to be called, Hz. It is called at most once per frame.
    fn rate_hz(&self) -> f64;

    /// Receives a frame. This is called once in every frame, before [`Controller::control`] and also if no control is
    /// due. The frame's equilibrium angles are those that were in force until this frame. It holds what a robot knows and
    /// no ground truth ([`Frame::sensed`]).
    fn observe(&mut self, _frame: &Frame) {}

    /// The obstacles on its map, if it keeps one. The recording sets their first and last frames.
    fn map(&self) -> Vec<MappedObstacle> {
        Vec::new()
    }

    /// Computes new equilibrium angles. Every list of angles has one entry per joint.
    fn control(&mut self, input: &ControllerInput) -> ControllerOutput;
}

#[cfg(test)]
mod tests;
