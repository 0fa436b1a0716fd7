//! The bodies of a reach and how they move, as plain Python objects.

use serde::Serialize;
use underbrush_recording::Body;

/// A body with its motion, which the recording's own JSON leaves out.
#[derive(Serialize)]
pub struct MovingBody<'a> {
    #[serde(flatten)]
    body: &'a Body,
    /// Frames in which it has moved.
    moved_frames: Vec<u32>,
    /// Its poses from each of these frames on: x y z in m, quaternion x y z w, world frame.
    poses_world: Vec<[f64; 7]>,
}

impl<'a> MovingBody<'a> {
    /// A body of a recording.
    pub fn of(body: &'a Body) -> Self {
        let pose = |pose: underbrush_recording::Pose| {
            let ([x, y, z], [qx, qy, qz, qw]) = (pose.position.to_array(), pose.orientation.to_array());
            [x, y, z, qx, qy, qz, qw]
        };
        MovingBody {
            body,
            moved_frames: body.track.iter().map(|point| point.frame).collect(),
            poses_world: body.track.iter().map(|point| pose(point.pose())).collect(),
        }
    }
}
