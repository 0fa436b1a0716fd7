//! Physical rules for a recording: time advances at the frame rate, and the contacts on a patch add up to its force.

use glam::DVec3;

use super::violation::{Violation, require};
use crate::{Frame, Recording};

/// Relative tolerance for the frame rate. Choice: ten times the error of a computer's clock, and far less than the
/// error of a wrong rate.
const RATE_TOLERANCE: f64 = 1e-3;

/// Relative tolerance for a sum of forces: rounding of some ten of them to single precision.
const SUM_TOLERANCE: f64 = 1e-6;

/// `timestamp` is computed from index and rate, so the frames' times may jitter but must stay on that grid. A frame
/// that a driver has dropped must be filled in.
pub(super) fn check_times(recording: &Recording) -> Result<(), Violation> {
    let start_s = recording.frames.first().map_or(0.0, |frame| frame.time_s);
    let mut before_s = f64::NEG_INFINITY;
    for (index, frame) in recording.frames.iter().enumerate() {
        let field = || format!("frames[{index}].time_s");
        let found = || format!("{} s", frame.time_s);
        let later = frame.time_s > before_s;
        require(later, field, found, "a later time than that of the previous frame")?;
        let frames_since_start = (frame.time_s - start_s) * recording.rate_hz;
        let on_grid = (frames_since_start - index as f64).abs() < 0.5 + RATE_TOLERANCE * index as f64;
        let allowed = "within half a frame of the first frame's time + index / rate";
        require(on_grid, field, found, allowed)?;
        before_s = frame.time_s;
    }
    for (index, goal) in recording.goals.iter().enumerate() {
        let field = || format!("goals[{index}].end_time_s");
        let found = || format!("{} s", goal.end_time_s);
        require(goal.start_time_s <= goal.end_time_s, field, found, "the start time or later")?;
    }
    Ok(())
}

/// The contacts of a patch add up to the patch's force. A recording may come without contacts, as one of a robot does.
pub(super) fn check_contact_forces(frame: &Frame, field: impl Fn(&str) -> String) -> Result<(), Violation> {
    if frame.contact_points.is_empty() {
        return Ok(());
    }
    for (patch, force) in frame.contact_force_world.iter().enumerate() {
        let on_patch = || frame.contact_points.iter().filter(|point| point.patch.map(usize::from) == Some(patch));
        let sum: DVec3 = on_patch().map(|point| point.force_world.as_dvec3()).sum();
        let largest_n = on_patch().map(|point| point.force_world.as_dvec3().length()).fold(0.0, f64::max);
        let apart_n = (sum - *force).length();
        let found = || format!("{apart_n} N away from the sum of the patch's contact points");
        let field = || field(&format!("contact_force_world[{patch}]"));
        let allowed = "the sum of the contact points on the patch";
        require(apart_n <= SUM_TOLERANCE * largest_n, field, found, allowed)?;
    }
    Ok(())
}
