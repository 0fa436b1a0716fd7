//! What the caller knows besides the recordings.

use underbrush_recording::{Audit, SkinLayout};

/// Facts that the caller knows and the recordings do not hold.
#[derive(Clone, Copy)]
pub struct ReplayContext {
    /// The force limit of a taxel, N, by the controller's name.
    pub force_limit_n: fn(&str) -> Option<f64>,
    /// The bounds of the audit that a reach with this skin exceeds, each as a sentence.
    pub audit_warnings: fn(&Audit, &SkinLayout) -> Vec<String>,
}
