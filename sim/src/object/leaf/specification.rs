//! Leaves in a scene file, and a leaf drawn from them.

use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Category;

use super::{CATEGORY, LARGEST_LOAD_SHARE, Leaf, root_stiffness_nm_per_rad};
use crate::object::{Footing, Object, Specification, StandsOn};
use crate::range::{DrawError, Limited, Placement, Quantity, Within, draw_possible};

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
    #[schemars(transform = Within(HEIGHT_LIMITS_M))]
    pub height_m: Quantity,
    /// Width of the blade, m.
    #[serde(default = "default_width")]
    #[schemars(transform = Within(WIDTH_LIMITS_M))]
    pub width_m: Quantity,
    /// Flexural rigidity E I of the blade, N m².
    #[serde(default = "default_flexural_rigidity")]
    #[schemars(transform = Within(RIGIDITY_LIMITS))]
    pub flexural_rigidity_n_m2: Quantity,
    /// Mass per area, kg/m².
    #[serde(default = "default_mass_per_area")]
    #[schemars(transform = Within(MASS_LIMITS))]
    pub mass_per_area_kg_per_m2: Quantity,
    /// Loss factor of the material.
    #[serde(default = "default_loss_factor")]
    #[schemars(transform = Within(LOSS_LIMITS))]
    pub loss_factor: Quantity,
    /// How deep the stem is stuck into the foam, m.
    #[serde(default = "default_root_depth")]
    #[schemars(transform = Within(DEPTH_LIMITS_M))]
    pub root_depth_m: Quantity,
    /// Number of elastic segments, each with one hinge.
    #[serde(default = "default_segments")]
    pub segments: u32,
}

/// Choice: the foliage in the paper's Fig. 2 looks 25–40 cm high.
fn default_height() -> Quantity {
    Quantity::uniform(0.25, 0.40)
}

/// Blades of artificial plants are 20–50 mm wide.
fn default_width() -> Quantity {
    Quantity::uniform(0.02, 0.05)
}

/// E I = E w t³ / 12 of plastic sheet ranges from 1e-4 to 4e-2 N m². Choice: far below 5e-3 a leaf of this height could
/// not carry its own weight, and a leaf that cannot is drawn again.
fn default_flexural_rigidity() -> Quantity {
    Quantity::uniform(0.005, 0.05)
}

/// Plastic sheet of 0.5–1.2 mm.
fn default_mass_per_area() -> Quantity {
    Quantity::uniform(0.5, 1.0)
}

/// Low-density polyethylene and soft PVC, from which leaves and stems are moulded, have tan δ of 0.1–0.2 at room
/// temperature; the air's drag on a swinging blade adds some hundredths.
fn default_loss_factor() -> Quantity {
    Quantity::uniform(0.1, 0.2)
}

/// Choice: half the height of a foam block.
fn default_root_depth() -> Quantity {
    Quantity::uniform(0.03, 0.05)
}

/// Choice: with four, a leaf that is pushed at a third of its height or higher is within 4 % of the continuous beam,
/// far less than the uncertainty of a plant's stiffness. The engine's cost grows with the cube of the number.
fn default_segments() -> u32 {
    4
}

/// Smallest and largest number of segments; the cost of a leaf grows with the cube.
pub const SEGMENT_LIMITS: (u32, u32) = (2, 40);
/// The arm passes over lower leaves; higher ones are bushes.
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 1.0);
/// From a blade of grass to a banana leaf.
const WIDTH_LIMITS_M: (f64, f64) = (0.003, 0.3);
/// From thin foil (a blade 3 mm wide, 0.1 mm thick) to a plastic rod of 1 cm.
const RIGIDITY_LIMITS: (f64, f64) = (1.0e-5, 10.0);
/// From foil of 10 µm to 2 cm of wood.
const MASS_LIMITS: (f64, f64) = (0.01, 20.0);
/// Rubber at its glass transition reaches 2.
const LOSS_LIMITS: (f64, f64) = (0.0, 2.0);
/// From a stem that hardly holds to the height of two foam blocks.
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
            Limited::new("height_m", &self.height_m, HEIGHT_LIMITS_M),
            Limited::new("width_m", &self.width_m, WIDTH_LIMITS_M),
            Limited::new("flexural_rigidity_n_m2", &self.flexural_rigidity_n_m2, RIGIDITY_LIMITS),
            Limited::new("mass_per_area_kg_per_m2", &self.mass_per_area_kg_per_m2, MASS_LIMITS),
            Limited::new("loss_factor", &self.loss_factor, LOSS_LIMITS),
            Limited::new("root_depth_m", &self.root_depth_m, DEPTH_LIMITS_M),
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, footing: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let draw = || self.draw_once(random, footing);
        // If nearly all leaves of these ranges would lie down, the error asks for a higher rigidity.
        let refusal = |leaf: &Leaf| DrawError {
            draw: self.flexural_rigidity_n_m2.draw,
            low: leaf.flexural_rigidity_n_m2 * leaf.load_share() / LARGEST_LOAD_SHARE,
            high: RIGIDITY_LIMITS.1,
        };
        Ok(Box::new(draw_possible(draw, Leaf::stands_by_itself, refusal)?))
    }

    fn fault(&self) -> Option<(&'static str, String, String)> {
        let (min, max) = SEGMENT_LIMITS;
        (!(min..=max).contains(&self.segments))
            .then(|| ("segments", self.segments.to_string(), format!("{min} to {max}")))
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Foam
    }
}

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
