//! What the replay page shows but recordings do not contain.

use underbrush_experiments::audit;
use underbrush_recording::Recording;
use underbrush_render::{RenderError, Stage};
use underbrush_replay::ReplayContext;
use underbrush_sim::controller::ControllerKind;

/// Largest size of a page with reaches inside, bytes. Choice: browsers refuse texts of more than about 500 MB, and
/// nobody sends that.
pub const MAX_PAGE_BYTES: usize = 400_000_000;

/// The force limits of the controllers that ship, and the bounds of the audit.
pub fn known() -> ReplayContext {
    ReplayContext { force_limit_n, audit_warnings: audit::exceeded_bounds }
}

/// The stage of a recording, which knows the force limit of its controller.
///
/// # Errors
/// As [`Stage::of`].
pub fn stage(recording: &Recording) -> Result<Stage<'_>, RenderError> {
    Stage::of(recording, force_limit_n(&recording.controller))
}

/// The force limit of a controller that ships.
fn force_limit_n(controller: &str) -> Option<f64> {
    let kind = ControllerKind::from_name(controller).ok()?;
    Some(kind.preset().force_limit_n)
}
