//! What is drawn of a reach without simulating it again: the rigid bodies with their shapes, their poses at rest and
//! their motion, and what the controller believed to be in its way.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::Pose;

/// Stored positions are rounded to multiples of this, m. Choice: an eighth of a millimetre is invisible in a picture of
/// the arm, and rounding cuts the stored size to a quarter. A power of two, so that the values are exact in single
/// precision.
pub const POSITION_STEP_M: f64 = 1.0 / 8192.0;
/// Stored components of quaternions are rounded to multiples of this. Choice: the rounding then moves the end of a body
/// half a metre long about as far as its origin.
pub const ORIENTATION_STEP: f64 = 1.0 / 8192.0;

/// Largest error of a stored position, m: half a step along each axis.
pub const POSITION_TOLERANCE_M: f64 = 0.87 * POSITION_STEP_M;
/// Largest error of a stored orientation, rad: half a step in each of four components is one step of the quaternion,
/// and the rotation angle is twice the angle between quaternions.
pub const ORIENTATION_TOLERANCE_RAD: f64 = 2.01 * ORIENTATION_STEP;

/// The link or object that a body belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyOwner {
    /// The link of the arm with this name.
    Link(String),
    /// The object with this index in [`crate::Recording::objects`].
    Object(u16),
}

/// A convex collision shape, centred on its frame. Cylinders and capsules lie along z.
///
/// ```
/// use glam::DVec3;
/// use underbrush_recording::BodyShape;
///
/// assert_eq!(BodyShape::Capsule { radius_m: 0.04, length_m: 0.3 }.numbers(), [0.04, 0.3]);
/// assert_eq!(BodyShape::Box { size_m: DVec3::new(0.1, 0.2, 0.3) }.numbers().len(), 3);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyShape {
    /// Sphere.
    Sphere {
        /// Radius, m.
        radius_m: f64,
    },
    /// Cylinder.
    Cylinder {
        /// Radius, m.
        radius_m: f64,
        /// Length, m.
        length_m: f64,
    },
    /// Capsule.
    Capsule {
        /// Radius, m.
        radius_m: f64,
        /// Length of the cylindrical part, m.
        length_m: f64,
    },
    /// Box.
    Box {
        /// Full edge lengths, m.
        size_m: DVec3,
    },
    /// Convex hull of points.
    Hull {
        /// The points, m.
        points_m: Vec<DVec3>,
    },
}

impl BodyShape {
    /// All lengths and coordinates of the shape, m.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            BodyShape::Sphere { radius_m } => vec![*radius_m],
            BodyShape::Cylinder { radius_m, length_m } | BodyShape::Capsule { radius_m, length_m } => {
                vec![*radius_m, *length_m]
            }
            BodyShape::Box { size_m } => size_m.to_array().to_vec(),
            BodyShape::Hull { points_m } => points_m.iter().flat_map(|point| point.to_array()).collect(),
        }
    }
}

/// One collision shape of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyPart {
    /// The shape.
    pub shape: BodyShape,
    /// Pose of the shape's frame in the body's frame.
    pub pose_body: Pose,
}

/// The pose of a body from one frame on, rounded to [`POSITION_STEP_M`] and [`ORIENTATION_STEP`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackPoint {
    /// The first frame with this pose.
    pub frame: u32,
    /// Origin of the body, m, world frame.
    pub position_world_m: [f32; 3],
    /// Rotation from the body's to the world frame (quaternion x y z w), of unit length up to rounding.
    pub orientation_world: [f32; 4],
}

/// One rigid body: a link of the arm, or a part of an object that moves as one piece.
///
/// ```
/// use glam::DVec3;
/// use underbrush_recording::{Body, BodyOwner, BodyPart, BodyShape, Pose};
/// use underbrush_recording::body::POSITION_TOLERANCE_M;
///
/// let ball = BodyPart { shape: BodyShape::Sphere { radius_m: 0.05 }, pose_body: Pose::IDENTITY };
/// let rest_pose_world = Pose::from_position(DVec3::Z);
/// let mut body = Body { owner: BodyOwner::Object(0), parts: vec![ball], rest_pose_world, track: Vec::new() };
/// // It rolls in frame 2 and then stays.
/// for frame in 0..5 {
///     let position = if frame < 2 { DVec3::Z } else { DVec3::new(0.01, 0.0, 1.0) };
///     body.observe(frame, &Pose::from_position(position));
/// }
/// assert_eq!(body.track.len(), 1);
/// assert_eq!(body.pose_world(1).position, DVec3::Z);
/// assert!((body.pose_world(4).position.x - 0.01).abs() < POSITION_TOLERANCE_M);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// The link or object that it belongs to.
    pub owner: BodyOwner,
    /// Its collision shapes.
    pub parts: Vec<BodyPart>,
    /// Pose before the reach begins: the pose of an object as built, or of a link in the arm's start posture.
    pub rest_pose_world: Pose,
    /// Its motion: each pose holds until the next point.
    #[serde(skip)]
    pub track: Vec<TrackPoint>,
}

impl TrackPoint {
    /// Rounds a pose. Of the two quaternions of a rotation it takes the one nearer to `near`, so that the numbers do
    /// not jump while a body rotates steadily.
    fn new(frame: u32, pose: &Pose, near: DQuat) -> Self {
        // Adding 0 turns −0 into 0.
        let round = |number: f64, step: f64| ((number / step).round() * step + 0.0) as f32;
        let sign = if pose.orientation.dot(near) < 0.0 { -1.0 } else { 1.0 };
        TrackPoint {
            frame,
            position_world_m: pose.position.to_array().map(|number| round(number, POSITION_STEP_M)),
            orientation_world: pose.orientation.to_array().map(|number| round(sign * number, ORIENTATION_STEP)),
        }
    }

    /// The pose, with a quaternion of unit length.
    pub fn pose(&self) -> Pose {
        Pose::new(DVec3::from_array(self.position_world_m.map(f64::from)), self.quaternion().normalize())
    }

    fn quaternion(&self) -> DQuat {
        DQuat::from_array(self.orientation_world.map(f64::from))
    }
}

impl Body {
    /// Records the pose in a frame; call it for each frame in order. A pose equal to the last one is not stored again.
    pub fn observe(&mut self, frame: u32, pose: &Pose) {
        let last = self.track.last().copied();
        let last = last.unwrap_or_else(|| TrackPoint::new(0, &self.rest_pose_world, self.rest_pose_world.orientation));
        let point = TrackPoint::new(frame, pose, last.quaternion());
        if point != (TrackPoint { frame, ..last }) {
            self.track.push(point);
        }
    }

    /// The pose of the body in a frame, within [`POSITION_TOLERANCE_M`] and [`ORIENTATION_TOLERANCE_RAD`].
    pub fn pose_world(&self, frame: u32) -> Pose {
        let points = self.track.partition_point(|point| point.frame <= frame);
        points.checked_sub(1).map_or(self.rest_pose_world, |last| self.track[last].pose())
    }
}

/// What an obstacle on a controller's map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObstacleKind {
    /// Something that gives way and stopped the arm nevertheless. It is forgotten with the goal.
    Yielding,
    /// Something that stopped the arm and may or may not be fixed.
    Doubtful,
    /// Something fixed.
    Fixed,
}

impl ObstacleKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Yielding, Self::Doubtful, Self::Fixed];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Yielding => "yielding",
            Self::Doubtful => "doubtful",
            Self::Fixed => "fixed",
        }
    }
}

/// An upright obstacle on a controller's map, as it stood there from one frame to another. An obstacle that changes has
/// several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MappedObstacle {
    /// What it was taken for.
    pub kind: ObstacleKind,
    /// The upper end of its upright axis, m, world frame. The obstacle reaches down to the ground.
    pub top_world: DVec3,
    /// Radius, m.
    pub radius_m: f64,
    /// Standard deviation of its place along the direction in which it is known worst, m.
    pub deviation_m: f64,
    /// First frame.
    pub first_frame: u32,
    /// Last frame.
    pub last_frame: u32,
}
