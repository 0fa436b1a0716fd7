//! Water bottles in a scene file, and a bottle drawn from them.

use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Category;

use super::{CATEGORY, WaterBottle};
use crate::object::{Footing, Object, Specification, StandsOn};
use crate::range::{DrawError, Limited, Placement, Quantity, Within, draw_possible};

/// A group of water bottles in a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaterBottleSpecification {
    /// How many.
    pub count: u32,
    /// Where they may stand; the scene's workspace if not given.
    pub place: Option<Placement>,
    /// Diameter, m.
    #[serde(default = "default_diameter")]
    #[schemars(transform = Within(DIAMETER_LIMITS_M))]
    pub diameter_m: Quantity,
    /// Height over the table, m.
    #[serde(default = "default_height")]
    #[schemars(transform = Within(HEIGHT_LIMITS_M))]
    pub height_m: Quantity,
    /// Mass of the empty bottle, kg.
    #[serde(default = "default_empty_mass")]
    #[schemars(transform = Within(EMPTY_MASS_LIMITS_KG))]
    pub empty_mass_kg: Quantity,
    /// Mass of the water in it, kg.
    #[serde(default = "default_water_mass")]
    #[schemars(transform = Within(WATER_MASS_LIMITS_KG))]
    pub water_mass_kg: Quantity,
    /// Coefficient of friction of the bottle; the table has 0.4, and a contact has the mean of its two surfaces.
    #[serde(default = "default_friction")]
    #[schemars(transform = Within(FRICTION_LIMITS))]
    pub friction: Quantity,
}

/// Bottles of water dispensers: those of 3 US gallons (11.4 l) are 25 cm thick and 38 cm high, those of 5 (18.9 l) are
/// 27 cm thick and 49 cm high. Smaller bottles are lower than the arm passes, or so slim that it tips them over.
fn default_diameter() -> Quantity {
    Quantity::uniform(0.25, 0.27)
}

fn default_height() -> Quantity {
    Quantity::uniform(0.38, 0.49)
}

/// Empty polycarbonate bottles of 5 gallons weigh about 0.75 kg.
fn default_empty_mass() -> Quantity {
    Quantity::fixed(0.75)
}

/// Choice: a rest of at most half a litre. A full bottle would resist with 50 N, which is more than the 3 N that the
/// controller allows a contact, and would feel like a trunk.
fn default_water_mass() -> Quantity {
    Quantity::uniform(0.0, 0.5)
}

/// Choice: the coefficient of a contact is then 0.25 to 0.30 with the table (0.4) and 0.20 to 0.25 with Cody's skin
/// (0.3). Hard plastics slide on smooth table tops with 0.2 to 0.4.
fn default_friction() -> Quantity {
    Quantity::uniform(0.1, 0.2)
}

/// The limits of foam rolls: from a glass tube to a barrel.
const DIAMETER_LIMITS_M: (f64, f64) = (0.02, 0.5);
/// The limits of trunks.
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 2.0);
/// From a thin film of plastic to a steel barrel.
const EMPTY_MASS_LIMITS_KG: (f64, f64) = (0.01, 30.0);
/// The upper limit is that of a barrel. A draw of more than the bottle holds is refused.
const WATER_MASS_LIMITS_KG: (f64, f64) = (0.0, 300.0);
/// The limits of an arm's friction.
const FRICTION_LIMITS: (f64, f64) = (0.0, 2.0);

impl Specification for WaterBottleSpecification {
    fn count(&self) -> u32 {
        self.count
    }

    fn place(&self) -> Option<&Placement> {
        self.place.as_ref()
    }

    fn quantities(&self) -> Vec<Limited<'_>> {
        vec![
            Limited::new("diameter_m", &self.diameter_m, DIAMETER_LIMITS_M),
            Limited::new("height_m", &self.height_m, HEIGHT_LIMITS_M),
            Limited::new("empty_mass_kg", &self.empty_mass_kg, EMPTY_MASS_LIMITS_KG),
            Limited::new("water_mass_kg", &self.water_mass_kg, WATER_MASS_LIMITS_KG),
            Limited::new("friction", &self.friction, FRICTION_LIMITS),
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let draw = || self.draw_once(random);
        let is_possible = |bottle: &WaterBottle| bottle.water_mass_kg <= bottle.capacity_kg();
        // If nearly all bottles of these ranges would overflow, the error asks for less water.
        let refusal = |bottle: &WaterBottle| DrawError {
            draw: self.water_mass_kg.draw,
            low: WATER_MASS_LIMITS_KG.0,
            high: bottle.capacity_kg(),
        };
        Ok(Box::new(draw_possible(draw, is_possible, refusal)?))
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Table
    }
}

impl WaterBottleSpecification {
    fn draw_once(&self, random: &mut ChaCha8Rng) -> Result<WaterBottle, DrawError> {
        Ok(WaterBottle {
            diameter_m: self.diameter_m.draw(random, DIAMETER_LIMITS_M)?,
            height_m: self.height_m.draw(random, HEIGHT_LIMITS_M)?,
            empty_mass_kg: self.empty_mass_kg.draw(random, EMPTY_MASS_LIMITS_KG)?,
            water_mass_kg: self.water_mass_kg.draw(random, WATER_MASS_LIMITS_KG)?,
            friction: self.friction.draw(random, FRICTION_LIMITS)?,
        })
    }
}
