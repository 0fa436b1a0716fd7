//! The skin: patches of taxels on links, the surfaces under them, and the elastic layer that covers them.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Patch, SkinLayout, Taxel, math};

/// All tactile skin of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Positions of the taxels, m, each patch in the frame of its link.
    pub layout: SkinLayout,
    /// The surface under each patch, in the layout's order.
    pub surfaces: Vec<PatchSurface>,
    /// Stiffness of the elastic layer per volume, N/m³: pressure divided by indentation, at small indentations.
    pub stiffness_n_per_m3: f64,
    /// Thickness of the layer, m: the pressure grows without bound as it is pressed flat. `None` for pressure that is always
    /// proportional to the indentation.
    pub thickness_m: Option<f64>,
    /// Loss time of the layer, s: its pressure under an indentation h is p(h) + τ dp/dt.
    pub loss_time_s: f64,
}

/// The surface under one patch, and its sensor technology.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchSurface {
    /// The link that carries the patch, index in [`crate::arm::Arm::links`].
    pub link: usize,
    /// Radius of the cylinder onto which its square taxels are bent, m; its axis is the first tangent of every taxel. `None` for
    /// flat taxels.
    pub radius_m: Option<f64>,
    /// Technology of its taxels.
    pub technology: Technology,
    /// The share of the pressure on the gaps between taxels that the cover passes on to them. At 1 all of it is felt, as if
    /// the taxels had no gaps.
    pub gap_share: f64,
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

/// A piece of a taxel's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The taxel, index in its patch.
    pub taxel: usize,
    /// Position, m, link frame.
    pub position_link: DVec3,
    /// Outward unit normal, link frame.
    pub normal_link: DVec3,
    /// Area, m².
    pub area_m2: f64,
    /// The share of its pressure that the taxel feels: 1, or the patch's `gap_share` in a gap.
    pub felt_share: f64,
}

impl Skin {
    /// Divides taxel `number` of a patch into `per_side` × `per_side` equal pieces and returns their centres on the true
    /// surface, sorted along the first tangent, then the second. Empty if there is no such taxel. If gaps are felt less than
    /// the taxels, a piece is added on each side, up to the middle of the gap.
    pub fn surface_points(&self, patch: usize, number: usize, per_side: usize) -> Vec<SurfacePoint> {
        let surface = self.surfaces.get(patch);
        let taxel = self.layout.patches.get(patch).and_then(|patch| patch.taxels.get(number));
        let (Some(surface), Some(taxel)) = (surface, taxel) else { return Vec::new() };
        let second_tangent = taxel.normal_link.cross(taxel.tangent_link);
        let side_m = taxel.area_m2.sqrt();
        let gaps = self.gaps_m(patch, number, side_m).filter(|_| surface.gap_share < 1.0);
        let [rows, columns] = [0, 1].map(|axis| strips(side_m, per_side, gaps.map(|gaps| gaps[axis])));
        let mut points = Vec::with_capacity(rows.len() * columns.len());
        for (along, length_m, row_in_gap) in &rows {
            for (across, width_m, column_in_gap) in &columns {
                // A quarter of a quarter is exact.
                let area_m2 = taxel.area_m2 * (length_m / side_m) * (width_m / side_m);
                let felt_share = if *row_in_gap || *column_in_gap { surface.gap_share } else { 1.0 };
                let (position_link, normal_link) = match surface.radius_m {
                    Some(radius_m) => {
                        // `across` is an arc length, because the taxel is bent and not stretched.
                        let (sin, cos) = math::sin_cos(across / radius_m);
                        let normal_link = taxel.normal_link * cos + second_tangent * sin;
                        let center = taxel.position_link - taxel.normal_link * radius_m;
                        (center + taxel.tangent_link * along + normal_link * radius_m, normal_link)
                    }
                    None => {
                        let position_link = taxel.position_link + taxel.tangent_link * along + second_tangent * across;
                        (position_link, taxel.normal_link)
                    }
                };
                points.push(SurfacePoint { taxel: number, position_link, normal_link, area_m2, felt_share });
            }
        }
        points
    }

    /// Half the gaps to the neighbours of a taxel whose side is `side_m`, m: before and after it along its first tangent, then
    /// along its second. `None` for taxels that are not on a cylinder. At an edge of the patch it is the gap on the other side.
    fn gaps_m(&self, patch: usize, taxel: usize, side_m: f64) -> Option<[[f64; 2]; 2]> {
        let radius_m = self.surfaces[patch].radius_m?;
        let Patch { grid, taxels, .. } = &self.layout.patches[patch];
        let half_m = |other: usize| {
            let (own, other) = (&taxels[taxel], &taxels[other]);
            let along = (other.position_link - own.position_link).dot(own.tangent_link).abs();
            let around = radius_m * own.normal_link.angle_between(other.normal_link);
            ((along.max(around) - side_m) / 2.0).max(0.0)
        };
        let [above, below, left, right] = (*grid)?.neighbours(taxel).map(|other| other.map(half_m));
        let sides = |before: Option<f64>, after: Option<f64>| {
            [before.or(after).unwrap_or(0.0), after.or(before).unwrap_or(0.0)]
        };
        Some([sides(above, below), sides(left, right)])
    }
}

/// The pieces of a side of a taxel: the middle of each, its length, and whether it is in a gap, whose halves before and after the
/// taxel are added if they are given.
fn strips(side_m: f64, per_side: usize, gaps_m: Option<[f64; 2]>) -> Vec<(f64, f64, bool)> {
    let length_m = side_m / per_side as f64;
    let own = (0..per_side).map(|index| (side_m * ((index as f64 + 0.5) / per_side as f64 - 0.5), length_m, false));
    let gap = |at: usize, side: f64| gaps_m.map(|gaps_m| (side * (side_m + gaps_m[at]) / 2.0, gaps_m[at], true));
    gap(0, -1.0).into_iter().chain(own).chain(gap(1, 1.0)).collect()
}

/// A place on the skin can be pressed by a contact if their normals differ by less than 60°: even with friction it is
/// then pressed and not pulled (cos 60° > μ sin 60° for μ up to 0.57).
pub const FACING_COSINE: f64 = 0.5;

/// A contact farther than this from every taxel is on the bare link, however far apart the taxels are, m. Choice: the
/// taxels of a skin are a few centimetres apart at most; farther apart they are separate sensors.
const MAX_REACH_M: f64 = 0.05;

/// Largest distance from the nearest taxel's centre at which a contact point is still on the patch, m.
///
/// It is the distance between neighbouring centres, because the cover extends across the gaps between taxels and a
/// little beyond the outermost ones. A taxel's own corners always belong to the skin, even if it has no neighbour.
pub fn reach_m(taxels: &[Taxel]) -> f64 {
    let farthest_corner_m = taxels.iter().map(corner_m).fold(0.0, f64::max);
    nearest_m(taxels).fold(0.0, f64::max).min(MAX_REACH_M).max(farthest_corner_m)
}

/// Distance from the centre of each taxel to the nearest other one, m; nothing for a single taxel.
pub fn nearest_m(taxels: &[Taxel]) -> impl Iterator<Item = f64> {
    let nearest = move |index: usize| {
        let others = taxels.iter().enumerate().filter(|(other, _)| *other != index);
        others.map(|(_, other)| other.position_link.distance(taxels[index].position_link)).fold(f64::INFINITY, f64::min)
    };
    (0..taxels.len()).map(nearest).filter(|distance| distance.is_finite())
}

/// Distance of the corners of a square taxel from its centre, m.
pub fn corner_m(taxel: &Taxel) -> f64 {
    (taxel.area_m2 / 2.0).sqrt()
}
