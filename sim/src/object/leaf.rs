//! Leaf: a bendable cantilever stuck in foam (paper, section IV-A).

use std::collections::BTreeMap;

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::{BodyShape, Category};

use super::group::{Declared, Group, Kind, quantities};
use super::structure::{Axis, Body, CollisionGroup, Inertia, Joint, Spring, Structure, part};
use super::{EARTH_GRAVITY_M_PER_S2, FRICTION, Footing, Object, StandsOn};
use crate::contact::surface::Surface;
use crate::geometry::Footprint;
use crate::quadrature::gauss_legendre;
use crate::range::{Draw, DrawError, draw_possible};

quantities! {
    /// What is drawn for a leaf. The foot frame of its blade: x normal to the blade, y along its width, z up.
    struct DrawnLeaf {
        // Choice: half the height of a foam block. Limits: from a stem that hardly holds to the height of two blocks.
        /// How deep the stem is stuck into the foam, m.
        root_depth_m: Draw::Uniform(0.03, 0.05), 0.005, 0.2;
        // Choice: the foliage in the paper's Fig. 2 looks 25–40 cm high. The arm passes over lower leaves than the limit;
        // higher ones are bushes.
        /// Height over the foam, m.
        height_m: Draw::Uniform(0.25, 0.40), 0.05, 1.0;
        // Blades of artificial plants are 20–50 mm wide. Limits: from a blade of grass to a banana leaf.
        /// Width of the blade, m.
        width_m: Draw::Uniform(0.02, 0.05), 0.003, 0.3;
        // E I = E w t³ / 12 of plastic sheet ranges from 1e-4 to 4e-2 N m². Choice: far below 5e-3 a leaf of this height
        // could not carry its own weight, and a leaf that cannot is drawn again. Limits: from thin foil (a blade 3 mm
        // wide, 0.1 mm thick) to a plastic rod of 1 cm.
        /// Flexural rigidity E I of the blade, N m².
        flexural_rigidity_n_m2: Draw::Uniform(0.005, 0.05), 1.0e-5, 10.0;
        // Plastic sheet of 0.5–1.2 mm. Limits: from foil of 10 µm to 2 cm of wood.
        /// Mass per area, kg/m².
        mass_per_area_kg_per_m2: Draw::Uniform(0.5, 1.0), 0.01, 20.0;
        // Low-density polyethylene and soft PVC, from which leaves and stems are moulded, have tan δ of 0.1–0.2 at room
        // temperature; the air's drag on a swinging blade adds some hundredths. Rubber at its glass transition reaches 2.
        /// Loss factor of the material.
        loss_factor: Draw::Uniform(0.1, 0.2), 0.0, 2.0;
        // Choice: with four, a leaf that is pushed at a third of its height or higher is within 4 % of the continuous
        // beam, far less than the uncertainty of a plant's stiffness. The engine's cost grows with the cube of the number.
        /// Number of elastic segments, each with one hinge; the nearest whole number of what is drawn.
        segments: Draw::Fixed(4.0), 2.0, 40.0;
    }
}

impl Kind for Leaf {
    const GROUP: (&'static str, &'static str) = (
        "LeafSpecification",
        "A group of leaves in a scene file. They stand on foam blocks only. The blade's foot frame: x normal to the blade, \
         y along its width, z up.",
    );
    const QUANTITIES: &'static [Declared] = DrawnLeaf::DECLARED;
    const CATEGORY: Category = Category::LEAF;
    const STANDS_ON: StandsOn = StandsOn::Foam;

    fn draw(group: &Group<Self>, random: &mut ChaCha8Rng, footing: &Footing) -> Result<Self, DrawError> {
        let draw = || {
            let drawn = DrawnLeaf::draw_all(group, random)?;
            Ok(Leaf {
                height_m: drawn.height_m,
                width_m: drawn.width_m,
                flexural_rigidity_n_m2: drawn.flexural_rigidity_n_m2,
                mass_per_area_kg_per_m2: drawn.mass_per_area_kg_per_m2,
                loss_factor: drawn.loss_factor,
                root_stiffness_nm_per_rad: footing
                    .foam_modulus_pa
                    .map(|modulus| root_stiffness_nm_per_rad(modulus, drawn.root_depth_m)),
                segments: drawn.segments.round() as u32,
            })
        };
        // If nearly all leaves of these ranges would lie down, the error asks for a higher rigidity.
        let enough = |leaf: &Leaf| leaf.flexural_rigidity_n_m2 * leaf.load_share() / LARGEST_LOAD_SHARE;
        let refusal = |leaf: &Leaf| group.refusal("flexural_rigidity_n_m2", Some(enough(leaf)), None);
        draw_possible(draw, Leaf::stands_by_itself, refusal)
    }
}

/// Rotational stiffness of a root of depth `depth_m` in foam of the given modulus, Nm/rad. A rigid peg in a Winkler
/// foundation of modulus E per unit length that rotates about the surface resists with ∫ E x² dx = E d³ / 3 (Hetényi,
/// *Beams on Elastic Foundation*, 1946).
pub fn root_stiffness_nm_per_rad(foam_modulus_pa: f64, depth_m: f64) -> f64 {
    foam_modulus_pa * depth_m.powi(3) / 3.0
}

/// One leaf: a chain of rigid pieces on a root that rotates in the foam about both horizontal axes and twists a little.
///
/// Its n bending hinges stand at the nodes of Gauss-Legendre quadrature over the height H and have the stiffness
/// E I / (w H), where w is the node's weight. The deflection under a load P at height a, P ∫ (a − x)² dx / (E I), thus
/// becomes a sum over the hinges below the load, which is exact for a load at the tip. Hinges at the midpoints of equal
/// segments have a relative error of 1/(4n²) there. With four hinges the first frequency is within 0.02 % of the beam's
/// (eight at midpoints: 0.4 %), and the deflection under a load above 0.3 H is within 4 % (eight at midpoints: 4 %).
///
/// The root's rotation about the blade's weak axis and the lowest hinge are less than a segment apart and are combined
/// into one hinge ([`Leaf::lowest_hinge`]).
///
/// ```
/// use underbrush_sim::object::Object;
/// use underbrush_sim::object::leaf::Leaf;
///
/// let leaf = Leaf {
///     height_m: 0.3,
///     width_m: 0.03,
///     flexural_rigidity_n_m2: 0.02,
///     mass_per_area_kg_per_m2: 0.7,
///     loss_factor: 0.15,
///     root_stiffness_nm_per_rad: None,
///     segments: 4,
/// };
/// assert!(leaf.stands_by_itself());
/// // The foot, a root that leans, and five pieces between and beyond four hinges.
/// assert_eq!(leaf.structure().bodies.len(), 7);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Height, m.
    pub height_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Flexural rigidity E I about the blade's weak axis, N m².
    pub flexural_rigidity_n_m2: f64,
    /// Mass per area, kg/m².
    pub mass_per_area_kg_per_m2: f64,
    /// Loss factor η; the first mode's damping ratio is η/2.
    pub loss_factor: f64,
    /// Rotational stiffness of the root in the foam, Nm/rad; `None` for a clamped root.
    pub root_stiffness_nm_per_rad: Option<f64>,
    /// Number of elastic segments, each with one hinge.
    pub segments: u32,
}

/// Thickness of the collision shape, m. Choice: about twice that of a plastic blade, the minimum that the engine
/// handles safely at the arm's speed.
const COLLISION_THICKNESS_M: f64 = 0.002;

/// Poisson's ratio of plastics, for the blade's torsional rigidity G J = 2 E I / (1 + ν).
const POISSON_RATIO: f64 = 0.35;

/// Artificial leaves stand on a stem of round wire, about a quarter of their height and several times as stiff as the
/// blade. Sideways, where the blade itself does not bend, the stem does. Choices.
const STEM_SHARE_OF_HEIGHT: f64 = 0.25;
const STEM_RIGIDITY_OVER_BLADE: f64 = 4.0;

/// A leaf stands by itself if its weight is at most this share of its buckling load. Choice: its stiffness is then at
/// least 3/5 of a weightless leaf's.
const LARGEST_LOAD_SHARE: f64 = 0.4;

/// Armature of the stacked massless hinges at the root, kg m². Choice: a hundredth of the lightest leaf's inertia about
/// its root; 2e-6 was found to be stable.
const ROOT_ARMATURE_KG_M2: f64 = 2.0e-6;

impl Leaf {
    /// Mass per length, kg/m.
    pub fn mass_per_length_kg_per_m(&self) -> f64 {
        self.mass_per_area_kg_per_m2 * self.width_m
    }

    /// First natural angular frequency of the clamped beam, rad/s: 1.8751² √(E I / (ρA H⁴)) (Blevins, *Formulas for
    /// Natural Frequency and Mode Shape*).
    pub fn first_frequency_rad_per_s(&self) -> f64 {
        1.875_104_068_711_961_f64.powi(2)
            * (self.flexural_rigidity_n_m2 / (self.mass_per_length_kg_per_m() * self.height_m.powi(4))).sqrt()
    }

    /// The leaf's weight as a share of its buckling load: g ρA H³ / (7.84 E I) for the blade (Greenhill 1881), plus the
    /// weight's destabilizing moment g ρA H² / 2 over the stiffness of the root.
    pub fn load_share(&self) -> f64 {
        let weight_n_per_m = EARTH_GRAVITY_M_PER_S2 * self.mass_per_length_kg_per_m();
        let blade = weight_n_per_m * self.height_m.powi(3) / (7.84 * self.flexural_rigidity_n_m2);
        let root = self.root_stiffness_nm_per_rad.map_or(0.0, |k| weight_n_per_m * self.height_m.powi(2) / 2.0 / k);
        blade + root
    }

    /// Whether the leaf carries its own weight and returns upright.
    pub fn stands_by_itself(&self) -> bool {
        self.load_share() <= LARGEST_LOAD_SHARE
    }

    /// Stiffness of the root against leaning sideways, along the blade's width, Nm/rad: stem and foam in series.
    pub fn sideways_stiffness_nm_per_rad(&self) -> f64 {
        let stem = STEM_RIGIDITY_OVER_BLADE * self.flexural_rigidity_n_m2 / (STEM_SHARE_OF_HEIGHT * self.height_m);
        in_series(stem, self.root_stiffness_nm_per_rad)
    }

    /// Stiffness against twist about the vertical, Nm/rad: the blade over half its height, in series with the foam.
    pub fn twist_stiffness_nm_per_rad(&self) -> f64 {
        let blade = 2.0 * self.flexural_rigidity_n_m2 / (1.0 + POISSON_RATIO) / (self.height_m / 2.0);
        in_series(blade, self.root_stiffness_nm_per_rad)
    }

    /// Heights over the foam, m, and compliances, rad/Nm, of the blade's bending hinges, lowest first.
    pub fn blade_hinges(&self) -> Vec<(f64, f64)> {
        gauss_legendre(self.segments)
            .into_iter()
            .map(|(node, weight)| {
                let place = self.height_m * node;
                (place, self.height_m * weight / self.flexural_rigidity_n_m2)
            })
            .collect()
    }

    /// Combines the blade's lowest hinge (height, m, and compliance, rad/Nm) with the root in the foam: their
    /// compliances add, at the mean of their heights weighted by compliance.
    ///
    /// A moment thus rotates the leaf as both hinges would. The deflection under a tip load P is smaller by
    /// P x² c₁ c₂ / (c₁ + c₂), where c are the compliances and x is the height of the lowest node: less than a
    /// thousandth of the total with four segments, in any foam.
    pub fn lowest_hinge(&self, (place_m, blade): (f64, f64)) -> (f64, f64) {
        let root = self.root_stiffness_nm_per_rad.map_or(0.0, |stiffness| 1.0 / stiffness);
        (place_m * blade / (blade + root), blade + root)
    }

    /// A spring damped in proportion to its stiffness so that the first mode's damping ratio is η/2.
    fn damped(&self, stiffness: f64) -> Spring {
        Spring::elastic(stiffness, stiffness * self.loss_factor / self.first_frequency_rad_per_s())
    }

    fn at_root(&self, stiffness: f64) -> Spring {
        Spring { armature: ROOT_ARMATURE_KG_M2, ..self.damped(stiffness) }
    }
}

fn in_series(stiffness: f64, other: Option<f64>) -> f64 {
    other.map_or(stiffness, |other| stiffness * other / (stiffness + other))
}

impl Object for Leaf {
    fn kind(&self) -> &'static str {
        "leaf"
    }

    fn category(&self) -> Category {
        Self::CATEGORY
    }

    fn is_obstacle(&self) -> bool {
        false
    }

    fn may_stand_in_foam(&self) -> bool {
        true
    }

    fn footprint(&self) -> Footprint {
        Footprint::Disc(self.width_m / 2.0)
    }

    fn half_sizes_m(&self) -> [f64; 2] {
        [COLLISION_THICKNESS_M / 2.0, self.width_m / 2.0]
    }

    fn height_m(&self) -> f64 {
        self.height_m
    }

    fn parameters(&self) -> BTreeMap<String, f64> {
        let mut parameters = BTreeMap::from([
            ("height_m".into(), self.height_m),
            ("width_m".into(), self.width_m),
            ("flexural_rigidity_n_m2".into(), self.flexural_rigidity_n_m2),
            ("mass_per_area_kg_per_m2".into(), self.mass_per_area_kg_per_m2),
            ("loss_factor".into(), self.loss_factor),
            ("segments".into(), f64::from(self.segments)),
        ]);
        if let Some(stiffness) = self.root_stiffness_nm_per_rad {
            parameters.insert("root_stiffness_nm_per_rad".into(), stiffness);
        }
        parameters
    }

    fn structure(&self) -> Structure {
        // No joint has two free rotations, so the root leans sideways on a massless link of its own.
        let sideways = self.at_root(self.sideways_stiffness_nm_per_rad());
        let root = Body::between_hinges(Joint {
            parent: 0,
            origin_parent: DVec3::ZERO,
            free_axes: vec![(Axis::RotationX, sideways)],
        });
        let mut bodies = vec![Body::foot(), root];
        let twist = self.at_root(self.twist_stiffness_nm_per_rad());
        let mut hinges = self.blade_hinges();
        if let Some(lowest) = hinges.first_mut() {
            *lowest = self.lowest_hinge(*lowest);
        }
        let bend = |(_, compliance): &(f64, f64)| (Axis::RotationY, self.damped(1.0 / compliance));
        let axes = std::iter::once((Axis::RotationZ, twist)).chain(hinges.iter().map(bend));
        let bottoms = std::iter::once(0.0).chain(hinges.iter().map(|hinge| hinge.0));
        let tops = hinges.iter().map(|hinge| hinge.0).chain([self.height_m]);
        // Pieces lie between hinges: the first from the foot to the lowest hinge, the last from the highest hinge to
        // the tip.
        let mut origin_parent = DVec3::ZERO;
        for (piece, ((axis, bottom), top)) in axes.zip(bottoms).zip(tops).enumerate() {
            let length = top - bottom;
            let size_m = DVec3::new(COLLISION_THICKNESS_M, self.width_m, length);
            let center = DVec3::Z * (length / 2.0);
            bodies.push(Body {
                joint: Some(Joint { parent: bodies.len() - 1, origin_parent, free_axes: vec![axis] }),
                inertia: Inertia::of_box(self.mass_per_length_kg_per_m() * length, center, size_m),
                parts: vec![part(BodyShape::Box { size_m }, center)],
                collision_group: if piece <= 1 { CollisionGroup::Rooted } else { CollisionGroup::Bendable },
            });
            origin_parent = DVec3::Z * length;
        }
        Structure { bodies, axisymmetric: false, surface: Surface::hard(FRICTION) }
    }
}
