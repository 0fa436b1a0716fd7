//! Trunk: rigid, fixed to the table beneath the foam (paper, section IV-A).

use std::collections::BTreeMap;

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{BodyShape, Category};

use super::structure::{Body, Structure, part};
use super::{FRICTION, Footing, Object, Specification, StandsOn};
use crate::contact::surface::Surface;
use crate::geometry::Footprint;
use crate::range::{DrawError, Limited, Placement, Quantity, Within, draw_possible};

const CATEGORY: Category = Category::TRUNK;

/// A group of trunks in a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrunkSpecification {
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
}

/// Choice: stems of artificial trees, and the pipes used in their place, are 2 to 4 cm thick.
fn default_diameter() -> Quantity {
    Quantity::uniform(0.02, 0.04)
}

/// Choice: as high over the table as the tallest leaves, so that the arm meets both at the same heights.
fn default_height() -> Quantity {
    Quantity::uniform(0.40, 0.55)
}

/// From a twig to a tree trunk.
const DIAMETER_LIMITS_M: (f64, f64) = (0.005, 0.3);
/// The arm passes over lower ones, and higher ones only add length above it.
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 2.0);

impl Specification for TrunkSpecification {
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
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let draw = || -> Result<Trunk, DrawError> {
            Ok(Trunk {
                diameter_m: self.diameter_m.draw(random, DIAMETER_LIMITS_M)?,
                height_m: self.height_m.draw(random, HEIGHT_LIMITS_M)?,
            })
        };
        // The top is half a ball, which must be above the table.
        let is_possible = |trunk: &Trunk| trunk.height_m >= trunk.diameter_m / 2.0;
        let refusal = |trunk: &Trunk| DrawError {
            draw: self.height_m.draw,
            low: trunk.diameter_m / 2.0,
            high: HEIGHT_LIMITS_M.1,
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

/// One trunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trunk {
    /// Diameter, m.
    pub diameter_m: f64,
    /// Height, m.
    pub height_m: f64,
}

impl Object for Trunk {
    fn kind(&self) -> &'static str {
        "trunk"
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn is_obstacle(&self) -> bool {
        true
    }

    fn may_stand_in_foam(&self) -> bool {
        true
    }

    fn footprint(&self) -> Footprint {
        Footprint::Disc(self.diameter_m / 2.0)
    }

    fn height_m(&self) -> f64 {
        self.height_m
    }

    fn parameters(&self) -> BTreeMap<String, f64> {
        BTreeMap::from([("diameter_m".into(), self.diameter_m), ("height_m".into(), self.height_m)])
    }

    fn structure(&self) -> Structure {
        // A capsule whose upper round end is the top of the trunk; the lower one is under the table.
        let radius_m = self.diameter_m / 2.0;
        let length_m = self.height_m - radius_m;
        let trunk = Body {
            parts: vec![part(BodyShape::Capsule { radius_m, length_m }, DVec3::Z * (length_m / 2.0))],
            ..Body::foot()
        };
        Structure { bodies: vec![trunk], axisymmetric: true, surface: Surface::hard(FRICTION) }
    }
}
