//! One sample of arm and skin at 100 Hz, with its ground truth.

use std::ops::Mul;

use glam::{DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Period of the skin's readings and of frames, s (100 Hz).
pub const FRAME_PERIOD_S: f64 = 0.01;

/// A rigid pose, in the frame that the field's name ends with.
///
/// ```
/// use glam::{DQuat, DVec3};
/// use underbrush_recording::Pose;
///
/// // A link that is turned by 90° about z, half a metre ahead.
/// let link = Pose::new(DVec3::X * 0.5, DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2));
/// let tip_world = link.transform_point(DVec3::X * 0.1);
/// assert!(tip_world.distance(DVec3::new(0.5, 0.1, 0.0)) < 1e-12);
/// assert!(link.inverse_transform_point(tip_world).distance(DVec3::X * 0.1) < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin, m.
    pub position: DVec3,
    /// Rotation from the local frame (unit quaternion, x y z w).
    pub orientation: DQuat,
}

// The simulation spends a noticeable part of its time here, in another crate, so these are inlined there.
impl Pose {
    /// The pose of a frame in itself.
    pub const IDENTITY: Pose = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };

    /// A pose with this origin and rotation.
    #[inline]
    pub fn new(position: DVec3, orientation: DQuat) -> Self {
        Pose { position, orientation }
    }

    /// A pose that is not rotated.
    #[inline]
    pub fn from_position(position: DVec3) -> Self {
        Pose::new(position, DQuat::IDENTITY)
    }

    /// A rotation about the origin.
    #[inline]
    pub fn from_orientation(orientation: DQuat) -> Self {
        Pose::new(DVec3::ZERO, orientation)
    }

    /// The pose with the first seven of these numbers, as [`Pose::numbers`] gives them.
    pub fn from_numbers(numbers: &[f64]) -> Self {
        Pose::new(DVec3::from_slice(numbers), DQuat::from_slice(&numbers[3..]))
    }

    /// Position x, y, z, m, and orientation x, y, z, w.
    pub fn numbers(&self) -> [f64; 7] {
        let ([x, y, z], [i, j, k, w]) = (self.position.to_array(), self.orientation.to_array());
        [x, y, z, i, j, k, w]
    }

    /// The pose of the outer frame in the local one.
    #[inline]
    pub fn inverse(&self) -> Self {
        let orientation = self.orientation.inverse();
        Pose::new(orientation * (-self.position), orientation)
    }

    /// Maps a point from the local frame to the outer one, m.
    #[inline]
    pub fn transform_point(&self, point_local: DVec3) -> DVec3 {
        self.orientation * point_local + self.position
    }

    /// Maps a vector from the local frame to the outer one.
    #[inline]
    pub fn transform_vector(&self, vector_local: DVec3) -> DVec3 {
        self.orientation * vector_local
    }

    /// Maps a point from the outer frame to the local one, m.
    #[inline]
    pub fn inverse_transform_point(&self, point: DVec3) -> DVec3 {
        self.orientation.inverse() * (point - self.position)
    }

    /// Maps a vector from the outer frame to the local one.
    #[inline]
    pub fn inverse_transform_vector(&self, vector: DVec3) -> DVec3 {
        self.orientation.inverse() * vector
    }
}

/// How far the length of a given quaternion may be from 1. Choice: enough for one written with three digits.
const QUATERNION_TOLERANCE: f64 = 2e-3;
/// A quaternion nearer to length 1 than this is not normalized, so that frames of a recording that are given again have the
/// same scores, bit for bit, as its file.
const QUATERNION_ROUNDING: f64 = 1e-9;

/// A quaternion x, y, z, w that someone gives, normalized if it was rounded; `None` if its length is not 1.
///
/// ```
/// use underbrush_recording::unit_quaternion;
///
/// assert!((unit_quaternion([0.0, 0.0, 0.707, 0.707]).unwrap().length() - 1.0).abs() < 1e-15);
/// assert_eq!(unit_quaternion([0.0, 0.0, 1.0, 1.0]), None);
/// ```
pub fn unit_quaternion(numbers: [f64; 4]) -> Option<DQuat> {
    let quaternion = DQuat::from_array(numbers);
    let error = (quaternion.length() - 1.0).abs();
    // It is infinite if the length overflows, and then no number is within the tolerance.
    (error <= QUATERNION_TOLERANCE)
        .then(|| if error <= QUATERNION_ROUNDING { quaternion } else { quaternion.normalize() })
}

/// `outer * inner` is the pose, in the outer frame, of a frame whose pose in the local frame is `inner`.
impl Mul for Pose {
    type Output = Pose;

    #[inline]
    fn mul(self, inner: Pose) -> Pose {
        Pose::new(self.position + self.orientation * inner.position, self.orientation * inner.orientation)
    }
}

/// Force on one taxel in one frame, true and sensed. A frame leaves out taxels for which everything is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TaxelReading {
    /// Index of the patch in the layout.
    pub patch: u16,
    /// Index of the taxel in its patch.
    pub taxel: u16,
    /// Ground truth: force along the inward normal, before the sensor, N; never negative.
    pub true_normal_force_n: f64,
    /// Ground truth: force on the taxel along its two tangents (`tangent`, `normal × tangent`), N.
    pub true_shear_force_n: [f64; 2],
    /// The sensor's reading of the normal force, N. Files keep it in single precision, and the simulated sensors report it so.
    pub sensed_force_n: f64,
    /// Ground truth: index in [`crate::reach::Recording::objects`] of the object that presses hardest on this taxel.
    /// `None` if nothing touches it, as when a reading comes from noise, crosstalk or creep.
    pub object: Option<u16>,
}

/// A contact of one frame, as the solver found it. A patch of skin, or the bare part of a link, touches a body of an
/// object or another link. Two links that touch each other have one contact each.
///
/// The forces of all contacts of a frame add up to the mean over its 10 ms, so the torques on the joints are
/// τ = Σ Jᵀ f. Values are in single precision, as they are stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactPoint {
    /// The link, index in [`crate::Recording::bodies`].
    pub link: u16,
    /// The patch of skin that is touched; `None` for a part of the link without skin.
    pub patch: Option<u16>,
    /// The object, index in [`crate::Recording::objects`]; `None` for the arm itself.
    pub object: Option<u16>,
    /// The body of the object, or the other link, index in [`crate::Recording::bodies`].
    pub body: u16,
    /// Centre of the force, m, world frame, with the link where it is at the end of the frame.
    pub position_world: Vec3,
    /// Direction of the normal forces on the link, unit, world frame.
    pub normal_world: Vec3,
    /// Mean force on the link over the frame, with friction, N, world frame.
    pub force_world: Vec3,
    /// Mean moment on the link about the position, N m, world frame: the friction of a patch that turns.
    pub moment_world: Vec3,
    /// Mean velocity of the link's surface against the other, in the tangent plane, m/s, world frame.
    pub slip_world: Vec3,
    /// Largest overlap of the undeformed shapes, m: how far skin and object together give way.
    pub depth_m: f32,
    /// Largest area that presses, m².
    pub area_m2: f32,
}

/// One sample of a reach.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Time since the start of the reach, s.
    pub time_s: f64,
    /// Joint angles, rad, one per joint.
    pub joint_angle_rad: Vec<f64>,
    /// Joint velocities, rad/s.
    pub joint_velocity_rad_per_s: Vec<f64>,
    /// Equilibrium angles φ of the joint springs, rad.
    pub equilibrium_angle_rad: Vec<f64>,
    /// Joint torques K(φ − q) − D·q̇, N m, without gravity compensation.
    pub joint_torque_nm: Vec<f64>,
    /// Pose of the end effector.
    #[serde(alias = "tip_pose_world")]
    pub end_effector_pose_world: Pose,
    /// Current goal of the end effector, m, world frame.
    pub goal_position_world: DVec3,
    /// Index of that goal in the reach, from 0.
    pub goal_index: u16,
    /// Pose of the link under each patch, in the layout's order.
    pub patch_pose_world: Vec<Pose>,
    /// Ground truth: sum of the solver's contact forces on each patch, N, world frame, in the layout's order.
    pub contact_force_world: Vec<DVec3>,
    /// Taxels with a true or a sensed force, sorted by patch, then taxel.
    pub taxels: Vec<TaxelReading>,
    /// Ground truth: the contacts of the frame's steps, bare links included.
    pub contact_points: Vec<ContactPoint>,
}

impl Frame {
    /// A frame in which everything is zero and no taxel has a force, of an arm with this number of patches. It has no
    /// joints.
    ///
    /// ```
    /// use underbrush_recording::Frame;
    ///
    /// // A frame of a robot that says only when it was and what its skin of two patches feels.
    /// let frame = Frame { time_s: 0.01, ..Frame::blank(2) };
    /// assert!(frame.taxels.is_empty() && frame.patch_pose_world.len() == 2);
    /// ```
    pub fn blank(patches: usize) -> Self {
        Frame {
            patch_pose_world: vec![Pose::IDENTITY; patches],
            contact_force_world: vec![DVec3::ZERO; patches],
            ..Frame::default()
        }
    }

    /// What a robot knows of this frame: the same without ground truth, and without the taxels that sense nothing.
    ///
    /// ```
    /// use underbrush_recording::{Frame, TaxelReading};
    ///
    /// let pressed = TaxelReading { true_normal_force_n: 1.0, sensed_force_n: 0.9, object: Some(3), ..TaxelReading::default() };
    /// let unfelt = TaxelReading { taxel: 1, sensed_force_n: 0.0, ..pressed };
    /// let frame = Frame { taxels: vec![pressed, unfelt], ..Frame::blank(1) };
    /// let sensed = TaxelReading { sensed_force_n: 0.9, ..TaxelReading::default() };
    /// assert_eq!(frame.sensed(), Frame { taxels: vec![sensed], ..Frame::blank(1) });
    /// ```
    pub fn sensed(&self) -> Frame {
        let felt = self.taxels.iter().filter(|reading| reading.sensed_force_n != 0.0);
        let sensed = |&TaxelReading { patch, taxel, sensed_force_n, .. }: &TaxelReading| TaxelReading {
            patch,
            taxel,
            sensed_force_n,
            ..TaxelReading::default()
        };
        // Every field is named, so that a new one cannot show the truth by chance.
        Frame {
            time_s: self.time_s,
            joint_angle_rad: self.joint_angle_rad.clone(),
            joint_velocity_rad_per_s: self.joint_velocity_rad_per_s.clone(),
            equilibrium_angle_rad: self.equilibrium_angle_rad.clone(),
            joint_torque_nm: self.joint_torque_nm.clone(),
            end_effector_pose_world: self.end_effector_pose_world,
            goal_position_world: self.goal_position_world,
            goal_index: self.goal_index,
            patch_pose_world: self.patch_pose_world.clone(),
            contact_force_world: vec![DVec3::ZERO; self.contact_force_world.len()],
            taxels: felt.map(sensed).collect(),
            contact_points: Vec::new(),
        }
    }
}
