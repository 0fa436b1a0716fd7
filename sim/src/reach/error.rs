//! Why a reach has no recording.

use underbrush_recording::InputError;

/// Why a reach has no recording. How a reach ends, for example with an arm that is stuck, is data and not an error.
#[derive(Debug, thiserror::Error)]
pub enum ReachError {
    /// The scene is impossible for this draw.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The caller stopped the reach.
    #[error("the reach was stopped before its end")]
    Stopped,
    /// The controller returned the wrong number of equilibrium angles.
    #[error(
        "the controller {controller} returned {found} equilibrium angles for an arm with {expected} joints; return one \
         angle per joint"
    )]
    EquilibriumAngles {
        /// Name of the controller.
        controller: String,
        /// Number of angles that it returned.
        found: usize,
        /// Number of joints.
        expected: usize,
    },
    /// A controller returned an angle that is no finite number.
    #[error(
        "the controller {controller} returned the equilibrium angle {found} for joint {joint}; return finite angles, rad"
    )]
    NoAngle {
        /// Name of the controller.
        controller: String,
        /// Number of the joint, from 0.
        joint: usize,
        /// The angle.
        found: f64,
    },
}
