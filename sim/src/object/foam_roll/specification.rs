//! Foam rolls in a scene file, and a roll drawn from them.

use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Category;

use super::{CATEGORY, FoamRoll, LARGEST_LOAD_SHARE};
use crate::object::{Footing, Object, Specification, StandsOn};
use crate::range::{DrawError, Limited, Placement, Quantity, Within, draw_possible};

/// A group of foam rolls in a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoamRollSpecification {
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
    /// Instantaneous modulus, Pa.
    #[serde(default = "default_modulus")]
    #[schemars(transform = Within(MODULUS_LIMITS_PA))]
    pub modulus_pa: Quantity,
    /// Share of that modulus that relaxes, 0 to 0.95.
    #[serde(default = "default_relaxing_share")]
    #[schemars(transform = Within(SHARE_LIMITS))]
    pub relaxing_share: Quantity,
    /// Relaxation time, s.
    #[serde(default = "default_relaxation_time")]
    #[schemars(transform = Within(TIME_LIMITS_S))]
    pub relaxation_time_s: Quantity,
    /// Density, kg/m³.
    #[serde(default = "default_density")]
    #[schemars(transform = Within(DENSITY_LIMITS))]
    pub density_kg_per_m3: Quantity,
}

/// Choice: rolls of soft polyethylene or polyurethane foam, 10–15 cm thick.
fn default_diameter() -> Quantity {
    Quantity::uniform(0.10, 0.15)
}

fn default_height() -> Quantity {
    Quantity::uniform(0.45, 0.55)
}

/// Choice: open-cell polyurethane to soft polyethylene foam.
fn default_modulus() -> Quantity {
    Quantity::uniform(5.0e4, 2.0e5)
}

/// Choice: viscoelastic foams relax to about half of their instantaneous stiffness.
fn default_relaxing_share() -> Quantity {
    Quantity::uniform(0.4, 0.6)
}

/// Choice: "slow to recover" means seconds.
fn default_relaxation_time() -> Quantity {
    Quantity::uniform(1.0, 3.0)
}

fn default_density() -> Quantity {
    Quantity::fixed(30.0)
}

/// From pipe insulation to a bolster.
const DIAMETER_LIMITS_M: (f64, f64) = (0.02, 0.5);
/// The limits of trunks.
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 2.0);
const MODULUS_LIMITS_PA: (f64, f64) = (1.0e3, 1.0e8);
const SHARE_LIMITS: (f64, f64) = (0.0, 0.95);
/// From the length of a frame to a quarter of an hour.
const TIME_LIMITS_S: (f64, f64) = (0.01, 1000.0);
/// From aerogel to soaked foam.
const DENSITY_LIMITS: (f64, f64) = (1.0, 1000.0);

impl Specification for FoamRollSpecification {
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
            Limited::new("modulus_pa", &self.modulus_pa, MODULUS_LIMITS_PA),
            Limited::new("relaxing_share", &self.relaxing_share, SHARE_LIMITS),
            Limited::new("relaxation_time_s", &self.relaxation_time_s, TIME_LIMITS_S),
            Limited::new("density_kg_per_m3", &self.density_kg_per_m3, DENSITY_LIMITS),
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let draw = || self.draw_once(random);
        // If nearly all rolls of these ranges would topple, the error asks for a higher modulus.
        let refusal = |roll: &FoamRoll| DrawError {
            draw: self.modulus_pa.draw,
            low: roll.modulus_pa * roll.load_share() / LARGEST_LOAD_SHARE,
            high: MODULUS_LIMITS_PA.1,
        };
        Ok(Box::new(draw_possible(draw, FoamRoll::stands_by_itself, refusal)?))
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Table
    }
}

impl FoamRollSpecification {
    fn draw_once(&self, random: &mut ChaCha8Rng) -> Result<FoamRoll, DrawError> {
        Ok(FoamRoll {
            diameter_m: self.diameter_m.draw(random, DIAMETER_LIMITS_M)?,
            height_m: self.height_m.draw(random, HEIGHT_LIMITS_M)?,
            modulus_pa: self.modulus_pa.draw(random, MODULUS_LIMITS_PA)?,
            relaxing_share: self.relaxing_share.draw(random, SHARE_LIMITS)?,
            relaxation_time_s: self.relaxation_time_s.draw(random, TIME_LIMITS_S)?,
            density_kg_per_m3: self.density_kg_per_m3.draw(random, DENSITY_LIMITS)?,
        })
    }
}
