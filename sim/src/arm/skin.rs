//! The skin: patches of taxels on links, the surfaces under them, and the elastic layer they lie in.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{SkinLayout, Taxel};

/// All tactile skin of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Where the taxels are; a patch's frame is that of its link.
    pub layout: SkinLayout,
    /// The surface under each patch, in the layout's order.
    pub surfaces: Vec<PatchSurface>,
    /// Stiffness of the elastic layer per volume, N/m³: pressure over indentation.
    pub stiffness_n_per_m3: f64,
}

/// The surface under one patch, and what senses there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchSurface {
    /// The link that carries the patch, index in [`crate::arm::Arm::links`].
    pub link: usize,
    /// Its form.
    pub form: SurfaceForm,
    /// What its taxels are made of.
    pub technology: Technology,
}

/// The sensing technology of a patch. The scene file's `[sensor]` section has a model for each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Technology {
    /// Capacitors under a continuous cover, as on Cody's forearm.
    #[default]
    Capacitive,
    /// Separate pieces of piezoresistive fabric, as on Cody's flipper.
    Fabric,
}

/// The form of the surface under a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceForm {
    /// A cylinder, with square taxels bent onto it.
    Cylinder {
        /// A point on the axis, m, link frame.
        axis_point_link: DVec3,
        /// Direction of the axis, unit, link frame: a taxel's first tangent.
        axis_link: DVec3,
        /// Radius, m.
        radius_m: f64,
    },
    /// Flat square taxels.
    Points,
}

/// A piece of a taxel's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position, m, link frame.
    pub position_link: DVec3,
    /// Outward unit normal, link frame.
    pub normal_link: DVec3,
    /// Area, m².
    pub area_m2: f64,
}

impl Skin {
    /// The middles of the `per_side` × `per_side` equal pieces of a taxel, on the true surface, sorted along the
    /// first tangent, then the second. Empty where there is no such taxel.
    pub fn surface_points(&self, patch: usize, taxel: usize, per_side: usize) -> Vec<SurfacePoint> {
        let surface = self.surfaces.get(patch);
        let taxel = self.layout.patches.get(patch).and_then(|patch| patch.taxels.get(taxel));
        let (Some(surface), Some(taxel)) = (surface, taxel) else {
            return Vec::new();
        };
        let second_tangent = taxel.normal_link.cross(taxel.tangent_link);
        let side = taxel.area_m2.sqrt();
        let offset = |index: usize| side * ((index as f64 + 0.5) / per_side as f64 - 0.5);
        let area_m2 = taxel.area_m2 / (per_side * per_side) as f64;
        let mut points = Vec::with_capacity(per_side * per_side);
        for along in (0..per_side).map(offset) {
            for across in (0..per_side).map(offset) {
                points.push(match surface.form {
                    SurfaceForm::Cylinder { radius_m, .. } => {
                        // Arc length across: the taxel is bent, not stretched.
                        let (sin, cos) = (across / radius_m).sin_cos();
                        let normal_link = taxel.normal_link * cos + second_tangent * sin;
                        let center = taxel.position_link - taxel.normal_link * radius_m;
                        let position_link = center + taxel.tangent_link * along + normal_link * radius_m;
                        SurfacePoint {
                            position_link,
                            normal_link,
                            area_m2,
                        }
                    }
                    SurfaceForm::Points => SurfacePoint {
                        position_link: taxel.position_link + taxel.tangent_link * along + second_tangent * across,
                        normal_link: taxel.normal_link,
                        area_m2,
                    },
                });
            }
        }
        points
    }
}

/// A place can be pressed where its normal and the contact's differ by less than 60°: there even with friction
/// (cos 60° > μ sin 60° for μ up to 0.57) it is pressed and not pulled.
pub const FACING_COSINE: f64 = 0.5;

/// Beyond this a contact is on bare link, however far apart the taxels of a patch are, m. Choice: skins have taxels a few
/// centimetres apart at most; what lies farther apart are sensors by themselves.
const LONGEST_REACH_M: f64 = 0.05;

/// Largest distance of a contact point from the nearest taxel's centre that still is on this patch, m.
///
/// Contacts as far from the nearest taxel's centre as neighbouring centres are from each other still lie on the skin: the
/// cover reaches over the gaps between taxels and a little beyond the outermost. A taxel's own corners always are skin, also
/// where it has no neighbour.
pub fn reach_m(taxels: &[Taxel]) -> f64 {
    let nearest = |index: usize| {
        let others = taxels.iter().enumerate().filter(|(other, _)| *other != index);
        others
            .map(|(_, other)| other.position_link.distance(taxels[index].position_link))
            .fold(f64::INFINITY, f64::min)
    };
    let corner_m = taxels
        .iter()
        .map(|taxel| (taxel.area_m2 / 2.0).sqrt())
        .fold(0.0, f64::max);
    (0..taxels.len())
        .map(nearest)
        .filter(|distance| distance.is_finite())
        .fold(0.0, f64::max)
        .min(LONGEST_REACH_M)
        .max(corner_m)
}
