//! The skin: patches of taxels on links, the surfaces under them, and the elastic layer they lie in.

use glam::DVec3;
use serde::Deserialize;
use underbrush_recording::SkinLayout;

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

/// What a patch's taxels are made of; [`crate::sensor`] says what follows from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
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
