//! Foam roll: the outlier, soft and slow to recover (paper, section V-D and Fig. 14).

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_recording::{BodyShape, Category};

use super::{
    Axis, Body, CollisionGroup, Declared, Drawing, EARTH_GRAVITY_M_PER_S2, Footing, Inertia, Joint, Kind, Object,
    Spring, Structure, foam_surface, part, quantities,
};
use crate::{Draw, DrawError, Footprint};

/// Number of slices that a roll is cut into along its height. Choice: each is then about half as high as the arm is
/// thick.
const SLICES: usize = 10;

quantities! {
    /// One foam roll standing on the table. Its core leans as a whole on two hinges at the base, and each slice slides
    /// sideways on the core where it is pushed. Every spring is a standard linear solid (Zener model).
    pub struct FoamRoll {
        // Choice: rolls of soft polyethylene or polyurethane foam, 10–15 cm thick. Limits: from pipe insulation to a
        // bolster.
        /// Diameter, m.
        diameter_m: Draw::Uniform(0.10, 0.15), 0.02, 0.5;
        // The limits of trunks.
        /// Height over the table, m.
        height_m: Draw::Uniform(0.45, 0.55), 0.05, 2.0;
        // Choice: open-cell polyurethane to soft polyethylene foam.
        /// Instantaneous modulus, Pa.
        modulus_pa: Draw::Uniform(5.0e4, 2.0e5), 1.0e3, 1.0e8;
        // Choice: viscoelastic foams relax to about half of their instantaneous stiffness.
        /// Share of that modulus that relaxes, 0 to 0.95.
        relaxing_share: Draw::Uniform(0.4, 0.6), 0.0, 0.95;
        // Choice: "slow to recover" means seconds. Limits: from the length of a frame to a quarter of an hour.
        /// Relaxation time, s.
        relaxation_time_s: Draw::Uniform(1.0, 3.0), 0.01, 1000.0;
        // Limits: from aerogel to soaked foam.
        /// Density, kg/m³.
        density_kg_per_m3: Draw::Fixed(30.0), 1.0, 1000.0;
    }
}

impl Kind for FoamRoll {
    const GROUP: (&'static str, &'static str) = ("FoamRollSpecification", "A group of foam rolls in a scene file.");
    const QUANTITIES: &'static [Declared] = Self::DECLARED;
    const CATEGORY: Category = Category::OUTLIER;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        // If nearly all rolls of these ranges would topple, the error asks for a higher modulus.
        let enough = |roll: &FoamRoll| roll.modulus_pa * roll.load_share() / LARGEST_LOAD_SHARE;
        let refusal = |roll: &FoamRoll| ("modulus_pa", Some(enough(roll)), None);
        drawing.until_possible(Self::draw_all, FoamRoll::stands_by_itself, refusal)
    }
}

/// A roll counts as standing up to this share of its toppling load. Choice: it then leans at most five times as far as
/// a weightless roll would.
const LARGEST_LOAD_SHARE: f64 = 0.8;

/// Damping ratio: half the loss factor of such foams, about 0.4 (at resonance η = 2 ζ).
const DAMPING_RATIO: f64 = 0.2;

/// Loss time of the surface, s: a loss factor of 0.4 at the 10 Hz of a touch.
const SURFACE_LOSS_TIME_S: f64 = 0.4 / (2.0 * PI * 10.0);

impl FoamRoll {
    /// Instantaneous stiffness of the two base hinges, N m/rad. With k = 3 E I / H, a force F at the tip deflects the
    /// roll as it would a cantilever, by F H³ / (3 E I) (Gere & Goodno, *Mechanics of Materials*, table of beam
    /// deflections).
    pub fn lean_stiffness_nm_per_rad(&self) -> f64 {
        3.0 * self.modulus_pa * PI * self.diameter_m.powi(4) / 64.0 / self.height_m
    }

    /// Instantaneous stiffness of one slice against sliding sideways, N/m: that of a bar as long and as wide as the
    /// roll's diameter D and as high as a slice, E A / D = E h.
    pub fn slice_stiffness_n_per_m(&self) -> f64 {
        self.modulus_pa * self.height_m / SLICES as f64
    }

    /// The roll's weight as a share of the load under which it would topple once its foam has relaxed.
    ///
    /// When the core leans by θ and slice i slides by x_i, the energy to second order is ½ k θ² + Σ ½ s x_i² − Σ m g (½
    /// h_i θ² + x_i θ), where m is a slice's mass, h_i its height, and k and s are the relaxed stiffness of hinge and
    /// slice. At its minimum over the x_i it is ½ θ² (k − M g H / 2 − (M g)² / Σ s), so the roll returns upright if k
    /// is larger than the two terms of the weight M g.
    pub fn load_share(&self) -> f64 {
        let relaxed = 1.0 - self.relaxing_share;
        let area_m2 = PI * self.diameter_m.powi(2) / 4.0;
        let weight_n = EARTH_GRAVITY_M_PER_S2 * self.density_kg_per_m3 * area_m2 * self.height_m;
        let slices_n_per_m = SLICES as f64 * self.slice_stiffness_n_per_m() * relaxed;
        let tilting_nm_per_rad = weight_n * self.height_m / 2.0 + weight_n * weight_n / slices_n_per_m;
        tilting_nm_per_rad / (self.lean_stiffness_nm_per_rad() * relaxed)
    }

    /// Whether the roll carries its own weight and returns upright after any push, however long.
    pub fn stands_by_itself(&self) -> bool {
        self.load_share() <= LARGEST_LOAD_SHARE
    }
}

impl Object for FoamRoll {
    /// The arm presses its surface in, but cannot pass it.
    fn is_obstacle(&self) -> bool {
        true
    }

    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(self.diameter_m / 2.0), self.height_m)
    }

    fn structure(&self, _: f64) -> Structure {
        let radius_m = self.diameter_m / 2.0;
        let slice_height_m = self.height_m / SLICES as f64;
        let slice_mass_kg = self.density_kg_per_m3 * PI * radius_m * radius_m * slice_height_m;
        let lean_inertia = slice_mass_kg * SLICES as f64 * self.height_m.powi(2) / 3.0;
        let solid = |stiffness: f64, inertia: f64| {
            Spring::relaxing(stiffness, inertia, DAMPING_RATIO, self.relaxing_share, self.relaxation_time_s)
        };
        let lean = solid(self.lean_stiffness_nm_per_rad(), lean_inertia);
        let base_hinge = |parent, axis| Body::between_hinges(Joint::parallel(parent, DVec3::ZERO, vec![(axis, lean)]));
        let mut bodies = vec![Body::foot(), base_hinge(0, Axis::about(DVec3::X)), base_hinge(1, Axis::about(DVec3::Y))];
        let core = bodies.len() - 1;
        let slide = solid(self.slice_stiffness_n_per_m(), slice_mass_kg);
        bodies.extend((0..SLICES).map(|slice| Body {
            joint: Some(Joint::parallel(
                core,
                DVec3::Z * (slice as f64 + 0.5) * slice_height_m,
                vec![(Axis::along(DVec3::X), slide), (Axis::along(DVec3::Y), slide)],
            )),
            inertia: Inertia::of_cylinder(slice_mass_kg, radius_m, slice_height_m),
            parts: vec![part(BodyShape::Cylinder { radius_m, length_m: slice_height_m }, DVec3::ZERO)],
            collision_group: if slice == 0 { CollisionGroup::Rooted } else { CollisionGroup::Bendable },
            ..Body::foot()
        }));
        // The foam between surface and core, a layer as thick as the radius R, has a compliance of R / E per area. Choice.
        let surface = foam_surface(0.5 * self.diameter_m / self.modulus_pa, SURFACE_LOSS_TIME_S);
        Structure { bodies, axisymmetric: true, surface }
    }
}

#[cfg(test)]
mod tests;
