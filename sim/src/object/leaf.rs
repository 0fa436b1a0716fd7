//! Leaf: a bendable cantilever stuck in foam (paper, section IV-A).

use std::collections::BTreeMap;

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Category;

use super::mechanism::{Spring, box_mass, massless};
use super::{FRICTION, Footing, Footprint, Limited, Mechanism, Object, Specification, StandsOn};
use crate::physics::{Physics, groups};
use crate::quadrature::gauss_legendre;
use crate::scene::Placement;
use crate::scene::quantity::{DrawError, Quantity};

/// A group of leaves in a scene file. The blade's foot frame: x normal to the blade, y along its width, z up.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeafSpecification {
    /// How many.
    pub count: u32,
    /// Where they may stand; the scene's workspace if not given. They stand on foam blocks only.
    pub place: Option<Placement>,
    /// Height over the foam, m.
    #[serde(default = "default_height")]
    pub height_m: Quantity,
    /// Width of the blade, m.
    #[serde(default = "default_width")]
    pub width_m: Quantity,
    /// Flexural rigidity E I of the blade, N m².
    #[serde(default = "default_flexural_rigidity")]
    pub flexural_rigidity_n_m2: Quantity,
    /// Mass per area, kg/m².
    #[serde(default = "default_mass_per_area")]
    pub mass_per_area_kg_per_m2: Quantity,
    /// Loss factor of the material.
    #[serde(default = "default_loss_factor")]
    pub loss_factor: Quantity,
    /// How deep the stem is stuck into the foam, m.
    #[serde(default = "default_root_depth")]
    pub root_depth_m: Quantity,
    /// Number of elastic segments, each with one hinge.
    #[serde(default = "default_segments")]
    pub segments: u32,
}

/// The rough trial of the whole chain used 25–40 cm; the foliage in the paper's Fig. 2 looks so.
fn default_height() -> Quantity {
    Quantity::uniform(0.25, 0.40)
}

/// Blades of artificial plants are 20–50 mm wide.
fn default_width() -> Quantity {
    Quantity::uniform(0.02, 0.05)
}

/// E I = E w t³ / 12 of plastic sheet spans 1e-4 to 4e-2 N m²; far below 5e-3 a leaf of this height could not carry its
/// own weight, and one that cannot is drawn anew.
fn default_flexural_rigidity() -> Quantity {
    Quantity::uniform(0.005, 0.05)
}

/// Plastic sheet of 0.5–1.2 mm.
fn default_mass_per_area() -> Quantity {
    Quantity::uniform(0.5, 1.0)
}

/// Low-density polyethylene and soft PVC, of which leaves and stems are moulded, have tan δ of 0.1–0.2 at room
/// temperature; the air's drag on a swinging blade adds some hundredths.
fn default_loss_factor() -> Quantity {
    Quantity::uniform(0.1, 0.2)
}

/// Choice: half the height of a foam block.
fn default_root_depth() -> Quantity {
    Quantity::uniform(0.03, 0.05)
}

/// Four: pushed at a third of its height or higher, the leaf is within 4 % of the continuum, far under what is known of
/// a plant's stiffness; the engine's cost grows with the cube.
fn default_segments() -> u32 {
    4
}

/// Largest number of segments: the cost of a leaf grows with its cube.
pub const SEGMENT_LIMITS: (u32, u32) = (2, 40);
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 1.0);
const WIDTH_LIMITS_M: (f64, f64) = (0.003, 0.3);
const RIGIDITY_LIMITS: (f64, f64) = (1.0e-5, 10.0);
const MASS_LIMITS: (f64, f64) = (0.01, 20.0);
const LOSS_LIMITS: (f64, f64) = (0.0, 2.0);
const DEPTH_LIMITS_M: (f64, f64) = (0.005, 0.2);

impl Specification for LeafSpecification {
    fn count(&self) -> u32 {
        self.count
    }

    fn place(&self) -> Option<&Placement> {
        self.place.as_ref()
    }

    fn quantities(&self) -> Vec<Limited<'_>> {
        vec![
            Limited {
                name: "height_m",
                quantity: &self.height_m,
                limits: HEIGHT_LIMITS_M,
            },
            Limited {
                name: "width_m",
                quantity: &self.width_m,
                limits: WIDTH_LIMITS_M,
            },
            Limited {
                name: "flexural_rigidity_n_m2",
                quantity: &self.flexural_rigidity_n_m2,
                limits: RIGIDITY_LIMITS,
            },
            Limited {
                name: "mass_per_area_kg_per_m2",
                quantity: &self.mass_per_area_kg_per_m2,
                limits: MASS_LIMITS,
            },
            Limited {
                name: "loss_factor",
                quantity: &self.loss_factor,
                limits: LOSS_LIMITS,
            },
            Limited {
                name: "root_depth_m",
                quantity: &self.root_depth_m,
                limits: DEPTH_LIMITS_M,
            },
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, footing: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let mut drawn = self.draw_once(random, footing)?;
        for _ in 0..DRAWS {
            if drawn.stands_by_itself() {
                return Ok(Box::new(drawn));
            }
            drawn = self.draw_once(random, footing)?;
        }
        // Nearly all leaves of these ranges would lie down: the rigidity is what to change.
        let needed = drawn.flexural_rigidity_n_m2 * drawn.load_share() / LARGEST_LOAD_SHARE;
        Err(DrawError {
            draw: self.flexural_rigidity_n_m2.draw,
            low: needed,
            high: RIGIDITY_LIMITS.1,
        })
    }

    fn fault(&self) -> Option<(&'static str, String, String)> {
        let (least, most) = SEGMENT_LIMITS;
        (!(least..=most).contains(&self.segments))
            .then(|| ("segments", self.segments.to_string(), format!("{least} to {most}")))
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Foam
    }
}

/// A leaf is drawn anew where it could not carry itself, this many times.
const DRAWS: usize = 100;

/// A leaf stands by itself where its weight is at most this share of the load under which it would buckle: it is then
/// no softer than 3/5 of what it would be without weight.
const LARGEST_LOAD_SHARE: f64 = 0.4;

impl LeafSpecification {
    fn draw_once(&self, random: &mut ChaCha8Rng, footing: &Footing) -> Result<Leaf, DrawError> {
        let root_depth_m = self.root_depth_m.draw(random, DEPTH_LIMITS_M)?;
        Ok(Leaf {
            height_m: self.height_m.draw(random, HEIGHT_LIMITS_M)?,
            width_m: self.width_m.draw(random, WIDTH_LIMITS_M)?,
            flexural_rigidity_n_m2: self.flexural_rigidity_n_m2.draw(random, RIGIDITY_LIMITS)?,
            mass_per_area_kg_per_m2: self.mass_per_area_kg_per_m2.draw(random, MASS_LIMITS)?,
            loss_factor: self.loss_factor.draw(random, LOSS_LIMITS)?,
            root_stiffness_nm_per_rad: footing
                .foam_modulus_pa
                .map(|modulus| root_stiffness_nm_per_rad(modulus, root_depth_m)),
            segments: self.segments,
        })
    }
}

/// Rotational stiffness of a root of depth `depth_m` in foam of the given modulus, Nm/rad: a rigid peg on an elastic
/// foundation of modulus E per unit length, turning about the surface, resists with ∫ E x² dx = E d³ / 3.
pub fn root_stiffness_nm_per_rad(foam_modulus_pa: f64, depth_m: f64) -> f64 {
    foam_modulus_pa * depth_m.powi(3) / 3.0
}

/// One leaf: a chain of rigid pieces on a root that turns in the foam about both horizontal axes and twists a little.
///
/// Its n bending hinges stand at the nodes of Gauss-Legendre quadrature over the height and have the stiffness
/// E I / (w H), w their weight. The deflection by a load at height a, P ∫ (a − x)² dx / E I, is then a sum over the hinges
/// below it that is exact for a load at the tip; hinges at the middles of equal segments are 1/(4n²) off. With four
/// hinges the first frequency is within 0.02 % of the beam's (eight at the middles: 0.4 %), and the deflection by a load
/// anywhere over 0.3 of the height within 4 % (eight at the middles: 4 %).
///
/// The root's turn about the blade's weak axis and the lowest hinge, not a segment apart, are one
/// ([`Leaf::lowest_hinge`]).
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

/// Thickness of the collision shape, m: about twice a plastic blade's, the least that the engine handles safely at
/// the arm's speed.
const COLLISION_THICKNESS_M: f64 = 0.002;

/// Poisson's ratio of plastics, for the blade's torsional rigidity G J = 2 E I / (1 + ν).
const POISSON_RATIO: f64 = 0.35;

/// Artificial leaves stand on a round wire stem, about a quarter of their height, several times as stiff as the blade;
/// sideways, where the blade itself does not give, the stem does. Choices.
const STEM_SHARE_OF_HEIGHT: f64 = 0.25;
const STEM_RIGIDITY_OVER_BLADE: f64 = 4.0;

const EARTH_GRAVITY_M_PER_S2: f64 = 9.81;

/// Inertia on the massless stacked hinges at the root, kg m²: a hundredth of the lightest leaf's about its root; a
/// trial found 2e-6 to be stable.
const ROOT_ARMATURE_KG_M2: f64 = 2.0e-6;

impl Leaf {
    /// Mass per length, kg/m.
    pub fn mass_per_length_kg_per_m(&self) -> f64 {
        self.mass_per_area_kg_per_m2 * self.width_m
    }

    /// First natural angular frequency of the clamped continuum, rad/s: 1.8751² √(EI / ρA H⁴).
    pub fn first_frequency_rad_per_s(&self) -> f64 {
        1.875_104_068_711_961_f64.powi(2)
            * (self.flexural_rigidity_n_m2 / (self.mass_per_length_kg_per_m() * self.height_m.powi(4))).sqrt()
    }

    /// Share of its weight in the load under which it would buckle: Greenhill's g ρA H³ / 7.84 E I of the blade, and
    /// the weight's moment about the root, g ρA H² / 2, over the root's stiffness.
    pub fn load_share(&self) -> f64 {
        let weight_n_per_m = EARTH_GRAVITY_M_PER_S2 * self.mass_per_length_kg_per_m();
        let blade = weight_n_per_m * self.height_m.powi(3) / (7.84 * self.flexural_rigidity_n_m2);
        let root = self
            .root_stiffness_nm_per_rad
            .map_or(0.0, |k| weight_n_per_m * self.height_m.powi(2) / 2.0 / k);
        blade + root
    }

    /// Whether the leaf carries its own weight and comes back upright.
    pub fn stands_by_itself(&self) -> bool {
        self.load_share() <= LARGEST_LOAD_SHARE
    }

    /// Stiffness of the root against leaning sideways, along the blade's width, Nm/rad: stem and foam in series.
    pub fn sideways_stiffness_nm_per_rad(&self) -> f64 {
        let stem = STEM_RIGIDITY_OVER_BLADE * self.flexural_rigidity_n_m2 / (STEM_SHARE_OF_HEIGHT * self.height_m);
        in_series(stem, self.root_stiffness_nm_per_rad)
    }

    /// Stiffness against twist about the vertical, Nm/rad: the blade's own over half its height, in series with the
    /// foam.
    pub fn twist_stiffness_nm_per_rad(&self) -> f64 {
        let blade = 2.0 * self.flexural_rigidity_n_m2 / (1.0 + POISSON_RATIO) / (self.height_m / 2.0);
        in_series(blade, self.root_stiffness_nm_per_rad)
    }

    /// Places over the foam, m, and compliances, rad/Nm, of the bending hinges of the blade, lowest first.
    pub fn blade_hinges(&self) -> Vec<(f64, f64)> {
        gauss_legendre(self.segments)
            .into_iter()
            .map(|(node, weight)| {
                let place = self.height_m * node;
                (place, self.height_m * weight / self.flexural_rigidity_n_m2)
            })
            .collect()
    }

    /// The blade's lowest hinge (place, m, and compliance, rad/Nm) made one with the root in the foam: in series, at the
    /// mean of their places weighted by compliance.
    ///
    /// So a load's moment turns the leaf as both would; its deflection by a tip load P is less by P x² c₁ c₂ / (c₁ + c₂)
    /// with compliances c and the lowest node's place x: under a thousandth of the whole at four segments, in any foam.
    pub fn lowest_hinge(&self, (place_m, blade): (f64, f64)) -> (f64, f64) {
        let root = self.root_stiffness_nm_per_rad.map_or(0.0, |stiffness| 1.0 / stiffness);
        (place_m * blade / (blade + root), blade + root)
    }

    /// A spring damped in proportion to its stiffness so that the first mode's damping ratio is η/2.
    fn damped(&self, stiffness: f64) -> Spring {
        Spring::elastic(
            stiffness,
            stiffness * self.loss_factor / self.first_frequency_rad_per_s(),
        )
    }

    fn at_root(&self, stiffness: f64) -> Spring {
        Spring {
            armature: ROOT_ARMATURE_KG_M2,
            ..self.damped(stiffness)
        }
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
        Category::Leaf
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

    fn build(&self, physics: &mut Physics, foot_world: DVec3, yaw_rad: f64) -> Mechanism {
        let mut mechanism = Mechanism::default();
        let mut parent = mechanism.fixed_foot(physics, Pose::new(foot_world, DVec3::Z * yaw_rad));
        // The engine has no joint of two free rotations, so the root is a stack of one-axis hinges.
        let sideways = self.at_root(self.sideways_stiffness_nm_per_rad());
        parent = mechanism.jointed(physics, parent, DVec3::ZERO, massless(), &[(3, sideways)]);
        let twist = self.at_root(self.twist_stiffness_nm_per_rad());
        let mut hinges = self.blade_hinges();
        if let Some(lowest) = hinges.first_mut() {
            *lowest = self.lowest_hinge(*lowest);
        }
        let bend = |(_, compliance): &(f64, f64)| (4, self.damped(1.0 / compliance));
        let joints = std::iter::once((5, twist)).chain(hinges.iter().map(bend));
        let bottoms = std::iter::once(0.0).chain(hinges.iter().map(|hinge| hinge.0));
        let tops = hinges.iter().map(|hinge| hinge.0).chain([self.height_m]);
        // Pieces lie between hinges, the first from the foot to the lowest hinge, the last up to the tip.
        let mut origin = DVec3::ZERO;
        for (piece, ((joint, bottom), top)) in joints.zip(bottoms).zip(tops).enumerate() {
            let length = top - bottom;
            let size = DVec3::new(COLLISION_THICKNESS_M, self.width_m, length);
            let center = DVec3::Z * (length / 2.0);
            let mass = box_mass(self.mass_per_length_kg_per_m() * length, center, size);
            parent = mechanism.jointed(physics, parent, origin, mass, &[joint]);
            origin = DVec3::Z * length;
            let group = if piece <= 1 {
                groups::rooted()
            } else {
                groups::bendable()
            };
            let shape = ColliderBuilder::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0)
                .position(Pose::from_translation(center))
                .friction(FRICTION)
                .collision_groups(group);
            mechanism.shape(physics, parent, shape);
        }
        mechanism.finish(physics);
        mechanism
    }
}

#[cfg(test)]
mod tests;
