//! Plant: a stem with leaves around it, stuck in foam.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use underbrush_recording::{BodyShape, Category, Pose};

use super::{
    Axis, Blade, Body, COLLISION_THICKNESS_M, CollisionGroup, Declared, Drawing, EARTH_GRAVITY_M_PER_S2, FRICTION,
    Footing, Grip, Hinge, Inertia, Joint, Kind, NEVER_PULLED_N, Object, Parameters, SHEET_TORSION_OVER_BENDING, Spring,
    Structure, gauss_legendre, grip, on_root, part, quantities, root_stiffness_nm_per_rad, yields,
};
use crate::{Draw, DrawError, Footprint, Surface};

quantities! {
    /// What is drawn for a plant. Limits: from a seedling to a bush that the arm just reaches over.
    struct DrawnPlant {
        // Choice, as for leaves.
        /// How deep the stem is stuck into the foam, m.
        root_depth_m: Draw::Uniform(0.03, 0.05), 0.005, 0.2;
        // Choice, as for leaves.
        /// Pull at which the root begins to slide out of the foam, N. It falls as the root comes out. 1000: never.
        pull_out_force_n: Draw::Fixed(NEVER_PULLED_N), 0.01, NEVER_PULLED_N;
        /// Height of the stem over the foam, m.
        height_m: Draw::Uniform(0.15, 0.30), 0.02, 1.0;
        // Stems of artificial plants are wire of 1–3 mm in plastic: E I = E π d⁴ / 64 of steel wire of 1.5–2.5 mm is
        // 0.05–0.4 N m².
        /// Flexural rigidity E I of the stem, N m².
        stem_rigidity_n_m2: Draw::Uniform(0.05, 0.3), 1.0e-3, 100.0;
        /// Diameter of the stem, m.
        stem_diameter_m: Draw::Uniform(0.004, 0.008), 0.002, 0.05;
        /// Number of blades; the nearest whole number of what is drawn.
        blades: Draw::Uniform(5.5, 9.5), 1.0, 40.0;
        /// Length of the petiole, the thin stalk between stem and blade, m.
        petiole_m: Draw::Uniform(0.02, 0.05), 0.005, 0.3;
        /// Length of a blade, m.
        blade_length_m: Draw::Uniform(0.10, 0.20), 0.03, 0.6;
        /// Width of a blade, m.
        blade_width_m: Draw::Uniform(0.02, 0.05), 0.003, 0.3;
        // Choice: a blade half as long as a leaf that stands by itself, of sheet half as thick.
        /// Flexural rigidity E I of a blade, N m².
        flexural_rigidity_n_m2: Draw::Uniform(0.002, 0.01), 1.0e-5, 10.0;
        /// Torsional over flexural rigidity of a blade, G J / (E I).
        torsion_over_bending: Draw::Fixed(SHEET_TORSION_OVER_BENDING), 0.01, 2.0;
        /// Angle of the blades' bases over the horizontal, degrees.
        elevation_deg: Draw::Uniform(30.0, 75.0), -60.0, 90.0;
        /// How much lower the tips point than the bases, degrees: the droop under the blade's own weight and its curl
        /// together, as seen.
        droop_deg: Draw::Uniform(20.0, 70.0), -90.0, 180.0;
        // As for leaves.
        /// Mass per area of the blades, kg/m².
        mass_per_area_kg_per_m2: Draw::Uniform(0.3, 0.7), 0.01, 20.0;
        /// Loss factor of the material.
        loss_factor: Draw::Uniform(0.1, 0.2), 0.0, 2.0;
        // Plastic leaves of 0.5–1 mm fold at these moments.
        /// Bending moment beyond which a blade folds and keeps a set, N m. 1000: never.
        yield_moment_nm: Draw::Uniform(0.15, 1.0), 0.001, 1000.0;
        // Choice: with three, a blade's first frequency is within 0.05 % of the beam's.
        /// Number of hinges of a blade; the nearest whole number of what is drawn.
        segments: Draw::Fixed(3.0), 2.0, 20.0;
    }
}

/// One plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// What was drawn.
    drawn: DrawnPlant,
    /// Rotational stiffness of the root in the foam, N m/rad; `None` for a clamped root.
    root_stiffness_nm_per_rad: Option<f64>,
    /// What holds the root if it can be pulled out.
    grip: Option<Grip>,
    /// How far its blades reach at rest. Placing asks for it many times.
    extent: Extent,
}

/// The extent of all blades at rest, m, in the frame of the foot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Extent {
    radius_m: f64,
    lowest_m: f64,
    highest_m: f64,
}

/// Hinges of the stem. Choice: with two, the first frequency is within 1.1 % of the beam's.
const STEM_SEGMENTS: u32 = 2;
/// Density of stems, kg/m³: plastic around a wire.
const STEM_DENSITY_KG_PER_M3: f64 = 1500.0;
/// Blades grow between this share of the stem's height and its top. Choice.
const LOWEST_BLADE: f64 = 0.3;
/// The golden angle, by which each blade is turned from the one below, rad (phyllotaxis).
const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;
/// A petiole is so many times as stiff as its blade, as a leaf's stem is. Choice.
const PETIOLE_RIGIDITY_OVER_BLADE: f64 = 4.0;
/// Share of the buckling load that the weight may be, as for a leaf.
const LARGEST_LOAD_SHARE: f64 = 0.4;

impl Kind for Plant {
    const GROUP: (&'static str, &'static str) = (
        "PlantSpecification",
        "A group of plants in a scene file. They stand on foam blocks only. Each is a stem with blades around it, which bend, \
         twist and fold.",
    );
    const QUANTITIES: &'static [Declared] = DrawnPlant::DECLARED;
    const CATEGORY: Category = Category::LEAF;
    const NEEDS_FOAM: bool = true;

    fn draw(drawing: &mut Drawing<'_>, footing: &Footing) -> Result<Self, DrawError> {
        let draw = |drawing: &mut Drawing<'_>| {
            let mut drawn = DrawnPlant::draw_all(drawing)?;
            (drawn.blades, drawn.segments) = (drawn.blades.round(), drawn.segments.round());
            let root = footing.foam_modulus_pa.map(|modulus| root_stiffness_nm_per_rad(modulus, drawn.root_depth_m));
            let grip = grip(footing.foam_modulus_pa, drawn.root_depth_m, drawn.pull_out_force_n);
            let plant = Plant { drawn, root_stiffness_nm_per_rad: root, grip, extent: Extent::default() };
            Ok(Plant { extent: plant.find_extent(), ..plant })
        };
        // If nearly all plants of these ranges would lie down, the error asks for a stiffer stem; if their tips would be in
        // the foam, for less droop.
        let refusal = |plant: &Plant| {
            let drawn = &plant.drawn;
            let enough = |rigidity: f64, load_share: f64| Some(rigidity * load_share / LARGEST_LOAD_SHARE);
            match plant.load_shares() {
                _ if plant.stands_by_itself() => ("droop_deg", None, Some(drawn.elevation_deg)),
                [stem, blade] if stem > blade => ("stem_rigidity_n_m2", enough(drawn.stem_rigidity_n_m2, stem), None),
                [_, blade] => ("flexural_rigidity_n_m2", enough(drawn.flexural_rigidity_n_m2, blade), None),
            }
        };
        // All blades must be over the foam.
        let is_possible = |plant: &Plant| plant.stands_by_itself() && plant.extent.lowest_m > COLLISION_THICKNESS_M;
        drawing.until_possible(draw, is_possible, refusal)
    }
}

impl Plant {
    /// What is recorded of it.
    pub(in crate::object) fn values(&self) -> Parameters {
        let mut parameters = self.drawn.values();
        parameters.extend(self.root_stiffness_nm_per_rad.map(|own| ("root_stiffness_nm_per_rad", own)));
        parameters
    }

    /// A blade with its petiole as its lowest part.
    fn blade(&self) -> Blade {
        let drawn = &self.drawn;
        Blade {
            length_m: drawn.blade_length_m,
            width_m: drawn.blade_width_m,
            flexural_rigidity_n_m2: drawn.flexural_rigidity_n_m2,
            torsional_rigidity_n_m2: drawn.torsion_over_bending * drawn.flexural_rigidity_n_m2,
            mass_per_area_kg_per_m2: drawn.mass_per_area_kg_per_m2,
            loss_factor: drawn.loss_factor,
            yield_moment_nm: yields(drawn.yield_moment_nm),
            segments: drawn.segments as u32,
        }
    }

    /// Hinges of a blade, measured from the stem, the lowest one together with the petiole.
    fn blade_hinges(&self) -> Vec<Hinge> {
        let (blade, petiole_m) = (self.blade(), self.drawn.petiole_m);
        let mut hinges = blade.hinges();
        for hinge in &mut hinges {
            hinge.place_m += petiole_m;
        }
        if let Some(lowest) = hinges.first_mut() {
            let compliance = petiole_m / PETIOLE_RIGIDITY_OVER_BLADE;
            *lowest = lowest.joined(Hinge {
                place_m: 0.5 * petiole_m,
                bend: compliance / blade.flexural_rigidity_n_m2,
                twist: compliance / blade.torsional_rigidity_n_m2,
            });
        }
        hinges
    }

    /// Mass of the stem, kg.
    fn stem_mass_kg(&self) -> f64 {
        0.25 * PI * self.drawn.stem_diameter_m.powi(2) * STEM_DENSITY_KG_PER_M3 * self.drawn.height_m
    }

    /// The weight of all as a share of what makes the stem buckle. The stem's own counts as that of a column (Greenhill
    /// 1881), the blades' as if all were at the top (Euler: π² E I / (4 H²)), and on a root that turns each as its moment
    /// over the root's stiffness; the shares add (Dunkerley). A blade's share of its own buckling load is that of an upright
    /// one, whose petiole turns as the root does. Returns the shares of stem and blade.
    fn load_shares(&self) -> [f64; 2] {
        let drawn = &self.drawn;
        let blade_n =
            EARTH_GRAVITY_M_PER_S2 * drawn.mass_per_area_kg_per_m2 * drawn.blade_width_m * drawn.blade_length_m;
        let blades_n = drawn.blades * blade_n;
        let (stem_n, height) = (EARTH_GRAVITY_M_PER_S2 * self.stem_mass_kg(), drawn.height_m);
        let bends = (stem_n / 7.84 + 4.0 * blades_n / (PI * PI)) * height * height / drawn.stem_rigidity_n_m2;
        let leans = self.root_stiffness_nm_per_rad.map_or(0.0, |k| height * (0.5 * stem_n + blades_n) / k);
        // The petiole's hinge is in its middle.
        let arm_m = 0.5 * (drawn.petiole_m + drawn.blade_length_m);
        let nods = blade_n * arm_m * drawn.petiole_m / (PETIOLE_RIGIDITY_OVER_BLADE * drawn.flexural_rigidity_n_m2);
        [bends + leans, nods + self.blade().load_share(EARTH_GRAVITY_M_PER_S2)]
    }

    /// Whether the plant carries its own weight.
    pub fn stands_by_itself(&self) -> bool {
        self.load_shares().into_iter().all(|share| share <= LARGEST_LOAD_SHARE)
    }

    /// Heights over the foam, m, and compliances, rad/(N m), of the stem's hinges, the lowest one together with the root.
    fn stem_hinges(&self) -> Vec<Hinge> {
        let height = self.drawn.height_m;
        let of_node = |(node, weight): (f64, f64)| {
            let bend = height * weight / self.drawn.stem_rigidity_n_m2;
            // A round rod: G J = E I / (1 + ν), much as a sheet's half.
            Hinge { place_m: height * node, bend, twist: 2.0 * bend / SHEET_TORSION_OVER_BENDING }
        };
        on_root(gauss_legendre(STEM_SEGMENTS).into_iter().map(of_node).collect(), self.root_stiffness_nm_per_rad)
    }

    /// Springs of the stem, damped like those of its blades at the stem's first frequency with all blades at its top.
    fn stem_spring(&self, compliance: f64) -> Spring {
        let drawn = &self.drawn;
        let blades_kg = drawn.blades * self.blade().mass_per_length_kg_per_m() * drawn.blade_length_m;
        // A massless cantilever with the blades and a quarter of its own mass at the top (Rayleigh).
        let mass_kg = blades_kg + 0.25 * self.stem_mass_kg();
        let frequency = (3.0 * drawn.stem_rigidity_n_m2 / (mass_kg * drawn.height_m.powi(3))).sqrt();
        Spring::elastic(1.0 / compliance, drawn.loss_factor / frequency / compliance)
    }

    /// Adds the stem, and returns the body that carries each of its pieces, and the piece's lower end, m.
    fn grow_stem(&self, bodies: &mut Vec<Body>) -> Vec<(usize, f64)> {
        let (hinges, height_m) = (self.stem_hinges(), self.drawn.height_m);
        let radius_m = 0.5 * self.drawn.stem_diameter_m;
        let rod = |length_m: f64| part(BodyShape::Capsule { radius_m, length_m }, DVec3::Z * (0.5 * length_m));
        let mut foot = Body { collision_group: CollisionGroup::Rooted, ..Body::foot() };
        foot.parts.extend(hinges.first().map(|hinge| rod(hinge.place_m)));
        bodies.push(foot);
        let mut pieces = Vec::new();
        let mut before_m = 0.0;
        let ends = hinges.iter().skip(1).map(|hinge| hinge.place_m).chain([height_m]);
        for (number, (hinge, end_m)) in hinges.iter().zip(ends).enumerate() {
            let spring = self.stem_spring(hinge.bend);
            let mut origin_parent = DVec3::Z * (hinge.place_m - before_m);
            if number == 0 {
                let twist = vec![(Axis::about(DVec3::Z), self.stem_spring(hinge.twist))];
                bodies.push(Body::between_hinges(Joint::parallel(bodies.len() - 1, origin_parent, twist)));
                origin_parent = DVec3::ZERO;
            }
            let length_m = end_m - hinge.place_m;
            let center = DVec3::Z * (0.5 * length_m);
            let inertia = Inertia::of_cylinder(self.stem_mass_kg() * length_m / height_m, radius_m, length_m);
            let bends = vec![(Axis::about(DVec3::X), spring), (Axis::about(DVec3::Y), spring)];
            bodies.push(Body {
                joint: Some(Joint::parallel(bodies.len() - 1, origin_parent, bends)),
                inertia: Inertia { center_of_mass_body: center, ..inertia },
                parts: vec![rod(length_m)],
                collision_group: if number == 0 { CollisionGroup::Rooted } else { CollisionGroup::Bendable },
                ..Body::foot()
            });
            pieces.push((bodies.len() - 1, hinge.place_m));
            before_m = hinge.place_m;
        }
        pieces
    }

    /// Adds a blade that grows from the stem at this height, m, in the direction of this azimuth, rad.
    fn grow_blade(&self, pieces: &[(usize, f64)], height_m: f64, azimuth_rad: f64, bodies: &mut Vec<Body>) {
        let Some((carrier, from_m)) = pieces.iter().rev().find(|(_, from_m)| *from_m <= height_m).or(pieces.first())
        else {
            return;
        };
        let (blade, hinges, drawn) = (self.blade(), self.blade_hinges(), &self.drawn);
        let end_m = drawn.petiole_m + drawn.blade_length_m;
        let first_m = hinges.first().map_or(end_m, |hinge| hinge.place_m);
        let tilt_rad = (90.0 - drawn.elevation_deg).to_radians();
        // Sideways a blade does not bend, but its petiole does.
        let sideways = blade.damped(PETIOLE_RIGIDITY_OVER_BLADE * drawn.flexural_rigidity_n_m2 / drawn.petiole_m);
        let radius_m = COLLISION_THICKNESS_M;
        let stalk_m = first_m.min(drawn.petiole_m);
        let stalk = part(BodyShape::Capsule { radius_m, length_m: stalk_m }, DVec3::Z * (0.5 * stalk_m));
        let base = blade.piece(0.0, first_m);
        bodies.push(Body {
            joint: Some(Joint {
                orientation_parent: DQuat::from_rotation_z(azimuth_rad) * DQuat::from_rotation_y(tilt_rad),
                ..Joint::parallel(*carrier, DVec3::Z * (height_m - from_m), vec![(Axis::about(DVec3::X), sideways)])
            }),
            parts: vec![stalk],
            drag: None,
            ..base
        });
        blade.grow(&hinges, end_m, drawn.droop_deg.to_radians(), bodies);
    }

    /// Of the ends of the blades' pieces, at both edges.
    fn find_extent(&self) -> Extent {
        let structure = self.structure(EARTH_GRAVITY_M_PER_S2);
        let poses = structure.rest_poses(Pose::IDENTITY);
        let half_m = 0.5 * self.drawn.blade_width_m;
        let mut extent = Extent { lowest_m: f64::INFINITY, ..Extent::default() };
        for (body, pose) in structure.bodies.iter().zip(poses).filter(|(body, _)| body.drag.is_some()) {
            let end_m = 2.0 * body.inertia.center_of_mass_body.z;
            for side in [-half_m, half_m] {
                let corner = pose.transform_point(DVec3::new(0.0, side, end_m));
                extent.radius_m = extent.radius_m.max(corner.truncate().length());
                extent.lowest_m = extent.lowest_m.min(corner.z);
                extent.highest_m = extent.highest_m.max(corner.z);
            }
        }
        extent
    }
}

impl Object for Plant {
    /// On a disc under all blades, so that those of two plants do not start within each other.
    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(self.extent.radius_m), self.drawn.height_m.max(self.extent.highest_m))
    }

    fn structure(&self, gravity_m_per_s2: f64) -> Structure {
        let mut bodies = Vec::new();
        let pieces = self.grow_stem(&mut bodies);
        let count = self.drawn.blades as u32;
        for number in 0..count {
            let share = LOWEST_BLADE + (1.0 - LOWEST_BLADE) * (f64::from(number) + 0.5) / f64::from(count);
            let azimuth_rad = f64::from(number) * GOLDEN_ANGLE_RAD;
            self.grow_blade(&pieces, share * self.drawn.height_m, azimuth_rad, &mut bodies);
        }
        let plant = Structure { bodies, axisymmetric: false, surface: Surface::hard(FRICTION) };
        plant.balanced(gravity_m_per_s2).held_by(self.grip)
    }
}

#[cfg(test)]
mod tests;
