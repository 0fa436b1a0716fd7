//! What ends a reach.

use serde::Serialize;

use crate::controller::ControllerKind;
use crate::scene::ProgressRule;

/// When an attempt at a goal ends, and how. These rules belong to the experiment, not to the controller; the published
/// experiments have different ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReachRules {
    /// A reach is aborted when the force between one link, with or without skin, and one object exceeds this, N.
    pub stop_force_n: f64,
    /// A goal is reached within this distance, m.
    pub reached_distance_m: f64,
    /// The arm is stuck when its end effector makes less progress than this, m, ...
    pub stuck_distance_m: f64,
    /// ... in a window of this length, s.
    pub stuck_window_s: f64,
    /// An attempt at a goal ends after this time, s.
    pub time_out_s: f64,
    /// What is progress.
    #[serde(skip_serializing_if = "ProgressRule::is_published")]
    pub progress: ProgressRule,
}

/// What an operator sees as progress, m/s. Choice: from half a metre away the eye sees a centimetre per second as
/// motion, and the slowest published hand speed is five times that.
const PROGRESS_M_PER_S: f64 = 0.01;

impl ReachRules {
    /// The rules of the experiments that a controller was published with. Sources \[1\] and \[2\] are those of
    /// [`crate::controller::Preset`].
    pub fn published_with(controller: ControllerKind) -> ReachRules {
        let of_the_robot = ReachRules {
            stop_force_n: 100.0,
            reached_distance_m: 0.01,
            stuck_distance_m: 1e-3,
            stuck_window_s: 10.0,
            time_out_s: 100.0,
            progress: ProgressRule::MeanPosition,
        };
        match controller {
            // \[2\], and \[1\] where its files say nothing.
            ControllerKind::Cody2013 | ControllerKind::Blind => of_the_robot,
            // It judges its own progress, and says so.
            ControllerKind::Mapped => ReachRules { progress: ProgressRule::Path, ..of_the_robot },
            // The robot of \[1\]. Its simulation stopped at 50 N and called 1.5 cm reached.
            ControllerKind::IjrrFoliage => ReachRules { stop_force_n: 15.0, reached_distance_m: 0.04, ..of_the_robot },
        }
    }

    /// These rules with an operator who gives up a goal when the arm has made no progress for `patience_s`.
    pub(super) fn watched_for(self, patience_s: f64) -> ReachRules {
        let moving_s = match self.progress {
            // The middles of the window's two halves are half a window apart.
            ProgressRule::MeanPosition => patience_s / 2.0,
            ProgressRule::Path => patience_s,
        };
        ReachRules { stuck_window_s: patience_s, stuck_distance_m: PROGRESS_M_PER_S * moving_s, ..self }
    }
}
