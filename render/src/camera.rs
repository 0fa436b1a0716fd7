//! Where a picture is taken from, how large it is, and why there is none.

use glam::{DVec3, Vec3};
use thiserror::Error;
use underbrush_recording::{Fault, math};
use underbrush_sim::scene::limits::{FIELD_DEG, PICTURE_PX};

/// Nothing nearer than this is seen, m.
pub const NEAREST_M: f32 = 0.02;

/// Angle between the upper and the lower edge of a picture without a camera, degrees. Choice: between those of the eye and of a
/// portrait, because such pictures are for readers. Cameras have a wider one (`SceneCamera::DEFAULT_FOV_DEG`).
const STANDARD_DEG: f64 = 32.0;

/// Why a picture cannot be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The size is not allowed.
    #[error("{} x {} pixels; allowed: {PICTURE_PX} in each direction; choose such a size", .0.width, .0.height)]
    Size(Size),
    /// The camera sees nothing, or it is not said which way is up.
    #[error(
        "camera: found {0}; allowed: numbers up to 1000 m, eye and target 1 mm apart, another direction for up than the line \
         between them, and a field of view of 1 to 150 degrees; move the camera"
    )]
    Camera(String),
    /// The camera is carried by a link that is not known.
    #[error("camera: found the link {link:?}; allowed: {links}; name one of them")]
    Link {
        /// The link.
        link: String,
        /// The links that are known.
        links: String,
    },
    /// There are no shapes, as in a robot's log or a table of trials, or no frames.
    #[error(
        "no shapes of an arm or no frames are known, so there is nothing to draw; a robot's log has no arm: look at it on the page \
         (underbrush replay --out)"
    )]
    NoBodies,
    /// The file cannot be encoded or written.
    #[error("the picture cannot be written: {0}")]
    Encoding(String),
}

impl From<RenderError> for Fault {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Encoding(_) => Fault::Run(error.to_string()),
            other => Fault::Usage(other.to_string()),
        }
    }
}

/// Width and height of a picture, pixels.
///
/// ```
/// use underbrush_render::Size;
///
/// assert!(Size { width: 320, height: 240 }.check().is_ok());
/// assert!(Size { width: 320, height: 2 }.check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Width.
    pub width: usize,
    /// Height.
    pub height: usize,
}

impl Size {
    /// Demands 64 to 1280 pixels in each direction.
    ///
    /// # Errors
    /// [`RenderError::Size`].
    pub fn check(self) -> Result<Self, RenderError> {
        let fits = [self.width, self.height].iter().all(|side| PICTURE_PX.hold(*side as f64));
        if fits { Ok(self) } else { Err(RenderError::Size(self)) }
    }

    /// Width over height.
    pub fn aspect(self) -> f64 {
        self.width as f64 / self.height as f64
    }
}

/// A pinhole camera.
///
/// ```
/// use glam::DVec3;
/// use underbrush_render::Camera;
///
/// // From the front, the two ends of a trunk fit into the picture.
/// let camera = Camera::around(&[DVec3::ZERO, DVec3::Z], DVec3::X, 4.0 / 3.0);
/// assert!(camera.eye_world.x > 1.0);
/// assert!(camera.target_world.distance(0.5 * DVec3::Z) < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is, m, world frame.
    pub eye_world: DVec3,
    /// A point in the middle of the picture, m, world frame.
    pub target_world: DVec3,
    /// A direction that is up in the picture, world frame.
    pub up_world: DVec3,
    /// The angle between the upper and the lower edge of the picture, degrees.
    pub vertical_fov_deg: f64,
}

/// A camera for a picture of some size: its axes, and the distance of the picture from the eye in points.
pub struct View {
    pub eye: Vec3,
    pub right: Vec3,
    pub down: Vec3,
    pub forward: Vec3,
    pub focal: f32,
    pub middle: [f32; 2],
}

impl Camera {
    /// From this direction, the nearest place from which all points fit into a picture with this ratio of width to height.
    pub fn around(points_world: &[DVec3], direction: DVec3, aspect: f64) -> Self {
        let back = direction.normalize_or(DVec3::X);
        let right = DVec3::Z.cross(back).normalize_or(DVec3::X);
        let up = back.cross(right);
        let half = 0.5 * STANDARD_DEG.to_radians();
        // Leaves a margin of a twentieth.
        let tangent = 0.95 * math::sin(half) / math::cos(half);
        let (mut target, mut distance_m) = (points_world.iter().sum::<DVec3>() / points_world.len() as f64, 1.0);
        // Each turn moves the middle of what is seen into the middle of the picture.
        for _ in 0..12 {
            let seen = points_world.iter().map(|point| *point - target);
            let seen = seen.map(|at| DVec3::new(at.dot(right), at.dot(up), at.dot(back)));
            let needed = |at: DVec3| at.z + (at.x.abs() / aspect).max(at.y.abs()) / tangent;
            distance_m = seen.clone().map(needed).fold(0.1, f64::max);
            let (low, high) = bounds(seen.map(|at| at / (distance_m - at.z).max(0.05)));
            let off = (low + high) / 2.0 * distance_m;
            target += right * off.x + up * off.y;
        }
        let eye_world = target + back * distance_m;
        Camera { eye_world, target_world: target, up_world: DVec3::Z, vertical_fov_deg: STANDARD_DEG }
    }

    /// The axes of the camera, for a picture with this many points for each pixel along each axis.
    ///
    /// # Errors
    /// [`RenderError::Size`] and [`RenderError::Camera`].
    pub(crate) fn view(&self, size: Size, samples: usize) -> Result<View, RenderError> {
        size.check()?;
        let [width, height] = [size.width, size.height].map(|pixels| (samples * pixels) as f64);
        let line = self.target_world - self.eye_world;
        let across = line.normalize_or_zero().cross(self.up_world.normalize_or_zero());
        let near = [self.eye_world, self.target_world, self.up_world].iter().all(|at| at.abs().max_element() <= 1e3);
        let good = near && line.length() > 1e-3 && across.length() > 1e-6;
        if !good || !FIELD_DEG.hold(self.vertical_fov_deg) {
            let Camera { eye_world, target_world, up_world, vertical_fov_deg } = self;
            return Err(RenderError::Camera(format!(
                "eye {eye_world}, target {target_world}, up {up_world} and a field of view of {vertical_fov_deg} degrees"
            )));
        }
        let (forward, right) = (line.normalize(), across.normalize());
        let half = 0.5 * self.vertical_fov_deg.to_radians();
        Ok(View {
            eye: self.eye_world.as_vec3(),
            right: right.as_vec3(),
            down: forward.cross(right).as_vec3(),
            forward: forward.as_vec3(),
            focal: (0.5 * height * math::cos(half) / math::sin(half)) as f32,
            middle: [0.5 * width as f32, 0.5 * height as f32],
        })
    }
}

impl View {
    /// A point in the camera's frame: to the right, down and forward, m.
    pub fn seen(&self, point: Vec3) -> Vec3 {
        let from = point - self.eye;
        Vec3::new(from.dot(self.right), from.dot(self.down), from.dot(self.forward))
    }

    /// Where a point before the camera is in the picture; z is the inverse of its depth.
    pub fn project(&self, seen: Vec3) -> Vec3 {
        let inverse = 1.0 / seen.z;
        let scale = self.focal * inverse;
        Vec3::new(self.middle[0] + seen.x * scale, self.middle[1] + seen.y * scale, inverse)
    }

    /// The point that is here in the picture, in the world frame.
    pub fn place(&self, at: [f32; 2], inverse: f32) -> Vec3 {
        let [x, y] = [0, 1].map(|axis| (at[axis] - self.middle[axis]) / self.focal);
        self.eye + (self.forward + self.right * x + self.down * y) / inverse
    }
}

/// The smallest and the largest coordinates of some points.
pub fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}
