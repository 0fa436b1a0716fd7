//! Rules for the bodies of a recording and their tracks.

use super::violation::{Violation, finite, require, require_unit};
use crate::Recording;
use crate::body::{BodyOwner, ORIENTATION_STEP};

/// Tolerance for the length of a quaternion: the rounding of tracks.
const QUATERNION_TOLERANCE: f64 = 2.0 * ORIENTATION_STEP;

/// Checks that objects are known, quaternions have unit length, and the frames of tracks increase.
pub(super) fn check_bodies(recording: &Recording) -> Result<(), Violation> {
    for (index, body) in recording.bodies.iter().enumerate() {
        let field = |name: &str| format!("bodies[{index}].{name}");
        if let BodyOwner::Object(object) = body.owner {
            let known = usize::from(object) < recording.objects.len();
            require(known, || field("owner"), || format!("object {object}"), "the index of an object")?;
        }
        let poses = body.parts.iter().map(|part| part.pose_body).chain([body.rest_pose_world]);
        for pose in poses {
            finite(pose.numbers(), || field("parts and rest_pose_world"))?;
            require_unit(pose.orientation.length(), QUATERNION_TOLERANCE, || field("parts and rest_pose_world"))?;
        }
        for part in &body.parts {
            finite(part.shape.numbers(), || field("parts"))?;
        }
        let mut next = 0;
        for point in &body.track {
            let known = point.frame >= next && (point.frame as usize) < recording.frames.len();
            let found = || point.frame.to_string();
            require(known, || field("track"), found, "the index of a later frame than that of the previous point")?;
            next = point.frame + 1;
            let numbers = point.position_world_m.into_iter().chain(point.orientation_world);
            finite(numbers.map(f64::from), || field("track"))?;
            let squares = point.orientation_world.map(|number| f64::from(number).powi(2));
            require_unit(squares.iter().sum::<f64>().sqrt(), QUATERNION_TOLERANCE, || field("track"))?;
        }
    }
    Ok(())
}
