//! Contacts as the solver found them: where each shape of the arm presses on a shape of an object, and how hard.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// The contact of a patch of skin, or of the bare part of a link, with a body of an object or another link, over a frame.
/// Two links that touch have one each.
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
    /// Mean moment on the link about the position, Nm, world frame: the friction of a patch that turns.
    pub moment_world: Vec3,
    /// Mean velocity of the link's surface against the other, in the tangent plane, m/s, world frame.
    pub slip_world: Vec3,
    /// Largest overlap of the undeformed shapes, m: how far skin and object together give way.
    pub depth_m: f32,
    /// Largest area that presses, m².
    pub area_m2: f32,
}

/// Numbers in a row of the column for a single recording.
#[cfg(feature = "disk")]
pub(crate) const NUMBERS: usize = 21;

#[cfg(feature = "disk")]
impl ContactPoint {
    /// All fields as numbers, in their order; a missing patch or object is −1.
    pub(crate) fn numbers(&self) -> [f32; NUMBERS] {
        let [position, normal, force, moment, slip] =
            [self.position_world, self.normal_world, self.force_world, self.moment_world, self.slip_world]
                .map(|vector| vector.to_array());
        let [patch, object] = [self.patch, self.object].map(|index| index.map_or(-1.0, f32::from));
        let mut numbers = [0.0; NUMBERS];
        numbers[..4].copy_from_slice(&[self.link.into(), patch, object, self.body.into()]);
        numbers[4..19].copy_from_slice([position, normal, force, moment, slip].as_flattened());
        numbers[19..].copy_from_slice(&[self.depth_m, self.area_m2]);
        numbers
    }

    /// The contact with these numbers; `None` if an index is not a whole number of its range.
    pub(crate) fn from_numbers(numbers: &[f32; NUMBERS]) -> Option<Self> {
        let index = |number: f32| (f32::from(number as u16) == number).then_some(number as u16);
        let optional = |number: f32| if number == -1.0 { Some(None) } else { index(number).map(Some) };
        let vector = |first: usize| Vec3::from_slice(&numbers[first..]);
        Some(ContactPoint {
            link: index(numbers[0])?,
            patch: optional(numbers[1])?,
            object: optional(numbers[2])?,
            body: index(numbers[3])?,
            position_world: vector(4),
            normal_world: vector(7),
            force_world: vector(10),
            moment_world: vector(13),
            slip_world: vector(16),
            depth_m: numbers[19],
            area_m2: numbers[20],
        })
    }
}
