//! Controllers: from joint angles, skin and goal to new equilibrium angles, once a control period.

use glam::{DQuat, DVec3};
use nalgebra::Matrix3xX;
use underbrush_recording::Pose;

use crate::arm::Arm;

pub mod blind;
pub mod model_predictive;
pub mod preset;
pub mod quadratic_program;

pub use blind::Blind;
pub use model_predictive::ModelPredictive;
pub use preset::Preset;

/// What a controller knows at one instant. n is the number of joints; Jacobians are 3 × n in the world frame.
#[derive(Clone, Debug)]
pub struct ControllerInput<'a> {
    /// Joint angles q, rad, n.
    pub joint_angle_rad: &'a [f64],
    /// Equilibrium angles φ, rad, n.
    pub equilibrium_angle_rad: &'a [f64],
    /// Pose of the tip.
    pub tip_pose_world: Pose,
    /// Jacobian of the tip's velocity, m/rad.
    pub tip_position_jacobian: &'a Matrix3xX<f64>,
    /// Jacobian of the tip's angular velocity.
    pub tip_angular_jacobian: &'a Matrix3xX<f64>,
    /// Where the tip is to go.
    pub goal: Goal,
    /// Every taxel that senses a force.
    pub contacts: &'a [TaxelContact],
}

/// Where the tip is to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Position, m, world frame.
    pub position_world: DVec3,
    /// Orientation of the tip frame, where it matters.
    pub orientation_world: Option<DQuat>,
}

/// One taxel that senses a force.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelContact {
    /// Jacobian of the velocity of the taxel's centre, m/rad, 3 × n, world frame; zero for joints distal of its link.
    pub position_jacobian: Matrix3xX<f64>,
    /// The taxel's inward unit normal, world frame: the direction of the force on the arm.
    pub inward_normal_world: DVec3,
    /// Sensed force along it, N.
    pub force_n: f64,
}

/// What a controller answers.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerOutput {
    /// New equilibrium angles φ, rad, n.
    pub equilibrium_angle_rad: Vec<f64>,
    /// How they came about.
    pub status: ControlStatus,
}

/// How the answer of a controller came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ControlStatus {
    /// The program was solved.
    Solved,
    /// No change of φ keeps all bounds: φ stays.
    Infeasible,
    /// The program could not be solved (a number that is none, or rounding): φ stays.
    Failed,
}

/// A controller of an arm.
pub trait Controller: Send + Sync {
    /// Name in scene files and recordings.
    fn name(&self) -> &str;

    /// Its rate, and what ends a reach under it.
    fn preset(&self) -> &Preset;

    /// New equilibrium angles; to be called once a period 1/rate. Every slice of the input has one entry a joint.
    fn control(&self, input: &ControllerInput<'_>) -> ControllerOutput;
}

/// Names of all controllers.
pub const NAMES: [&str; 3] = [
    ControllerKind::Cody2013.name(),
    ControllerKind::IjrrFoliage.name(),
    ControllerKind::Blind.name(),
];

/// The controllers that there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerKind {
    /// The model-predictive controller with the parameters of [`Preset::cody_2013`].
    Cody2013,
    /// The same with those of [`Preset::ijrr_foliage`].
    IjrrFoliage,
    /// The first as it would move if it felt nothing.
    Blind,
}

impl ControllerKind {
    /// All of them, in the order of [`NAMES`].
    pub const ALL: [ControllerKind; 3] = [
        ControllerKind::Cody2013,
        ControllerKind::IjrrFoliage,
        ControllerKind::Blind,
    ];

    /// Name in scene files and recordings.
    pub const fn name(self) -> &'static str {
        match self {
            ControllerKind::Cody2013 => "cody-2013",
            ControllerKind::IjrrFoliage => "ijrr-foliage",
            ControllerKind::Blind => "blind",
        }
    }

    /// The controller called so, if there is one.
    pub fn from_name(name: &str) -> Option<ControllerKind> {
        ControllerKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The controller for an arm, at so many times the hand speed of its preset.
    pub fn controller(self, arm: &Arm, hand_speed_scale: f64) -> Box<dyn Controller> {
        let scaled = |preset: Preset| preset.at_hand_speed(hand_speed_scale);
        match self {
            ControllerKind::Cody2013 => Box::new(ModelPredictive::new(scaled(Preset::cody_2013()), arm)),
            ControllerKind::IjrrFoliage => Box::new(ModelPredictive::new(scaled(Preset::ijrr_foliage()), arm)),
            ControllerKind::Blind => Box::new(Blind::new(scaled(Preset::cody_2013()), arm)),
        }
    }
}

#[cfg(test)]
mod tests;
