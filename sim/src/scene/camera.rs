//! Cameras of a scene: from where pictures of its reaches are taken.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::limits::short;

use super::limits;
use crate::range::{PLACE_M, Within};
use crate::sensor::OptionFault;

/// A camera of a scene (`[[cameras]]`). It stands still, with its places in the world frame, or a link carries it, and they are in
/// the link's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneCamera {
    /// Its name, which no other camera of the scene has. Data sets with pictures have a feature `observation.images.NAME`.
    pub name: String,
    /// The link that carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// Where it is, m.
    #[schemars(with = "[f64; 3]", transform = Within(PLACE_M))]
    pub eye_m: DVec3,
    /// A point in the middle of its pictures, m.
    #[schemars(with = "[f64; 3]", transform = Within(PLACE_M))]
    pub target_m: DVec3,
    /// A direction that is up in its pictures.
    #[serde(default = "default_up")]
    #[schemars(with = "[f64; 3]", transform = Within(PLACE_M))]
    pub up: DVec3,
    /// Angle between the upper and the lower edge of its pictures, degrees.
    #[serde(default = "default_field_deg")]
    #[schemars(transform = Within(limits::FIELD_DEG))]
    pub vertical_fov_deg: f64,
    /// Width and height of its pictures, pixels.
    #[serde(default = "default_size_px")]
    #[schemars(transform = Within(limits::PICTURE_PX))]
    pub size_px: [usize; 2],
}

fn default_up() -> DVec3 {
    DVec3::Z
}

fn default_field_deg() -> f64 {
    SceneCamera::DEFAULT_FOV_DEG
}

/// The size that small policies are trained on.
fn default_size_px() -> [usize; 2] {
    [320, 240]
}

impl SceneCamera {
    /// The vertical angle of a camera for which no other is given, degrees. That of common webcams and depth cameras is 40 to 45
    /// degrees.
    pub const DEFAULT_FOV_DEG: f64 = 40.0;

    /// What is wrong with its numbers or its name: key, what was found, and what is allowed.
    pub fn fault(&self) -> Option<OptionFault> {
        let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if self.name.is_empty() || !self.name.chars().all(is_letter) {
            return Some(("name".into(), format!("{:?}", self.name), "letters, digits, - and _".into()));
        }
        for (key, place) in [("eye_m", self.eye_m), ("target_m", self.target_m), ("up", self.up)] {
            if let Some(number) = place.to_array().into_iter().find(|number| !PLACE_M.hold(*number)) {
                return Some((key.into(), short(number), format!("numbers from {PLACE_M}")));
            }
        }
        let line = self.target_m - self.eye_m;
        if line.length() < 1e-3 {
            return Some(("target_m".into(), self.target_m.to_string(), "a place at least 1 mm from eye_m".into()));
        }
        if line.normalize().cross(self.up.normalize_or_zero()).length() < 1e-6 {
            let allowed = "another direction than the line between eye_m and target_m".into();
            return Some(("up".into(), self.up.to_string(), allowed));
        }
        if !limits::FIELD_DEG.hold(self.vertical_fov_deg) {
            return Some(("vertical_fov_deg".into(), short(self.vertical_fov_deg), limits::FIELD_DEG.to_string()));
        }
        let side = self.size_px.into_iter().find(|side| !limits::PICTURE_PX.hold(*side as f64))?;
        Some(("size_px".into(), side.to_string(), limits::PICTURE_PX.to_string()))
    }
}
