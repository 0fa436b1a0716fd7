//! Wand: a made-up object with a category of its own, for tests of how objects are added. A rod on two springy hinges.

#![allow(missing_docs, reason = "only tests use it")]

use std::collections::BTreeMap;

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{BodyShape, Category};

use super::structure::{Axis, Body, CollisionGroup, Inertia, Joint, Spring, Structure, part};
use super::{Footing, Object, Specification, StandsOn};
use crate::contact::surface::Surface;
use crate::geometry::Footprint;
use crate::range::{DrawError, Limited, Placement, Quantity};

pub(super) const CATEGORY: Category = Category::new("wand", 127).unwrap();

const HEIGHT_LIMITS_M: (f64, f64) = (0.1, 1.0);
const RADIUS_M: f64 = 0.01;
const MASS_KG: f64 = 0.05;

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WandSpecification {
    pub count: u32,
    pub place: Option<Placement>,
    #[serde(default = "default_height")]
    pub height_m: Quantity,
}

fn default_height() -> Quantity {
    Quantity::uniform(0.45, 0.55)
}

impl Specification for WandSpecification {
    fn count(&self) -> u32 {
        self.count
    }

    fn place(&self) -> Option<&Placement> {
        self.place.as_ref()
    }

    fn quantities(&self) -> Vec<Limited<'_>> {
        vec![Limited::new("height_m", &self.height_m, HEIGHT_LIMITS_M)]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        Ok(Box::new(Wand { height_m: self.height_m.draw(random, HEIGHT_LIMITS_M)? }))
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Table
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Wand {
    pub height_m: f64,
}

impl Object for Wand {
    fn kind(&self) -> &'static str {
        "wand"
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn is_obstacle(&self) -> bool {
        false
    }

    fn may_stand_in_foam(&self) -> bool {
        true
    }

    fn footprint(&self) -> Footprint {
        Footprint::Disc(RADIUS_M)
    }

    fn height_m(&self) -> f64 {
        self.height_m
    }

    fn parameters(&self) -> BTreeMap<String, f64> {
        BTreeMap::from([("height_m".into(), self.height_m)])
    }

    fn structure(&self) -> Structure {
        let hinge = |parent, axis| Joint {
            parent,
            origin_parent: DVec3::ZERO,
            free_axes: vec![(axis, Spring::elastic(2.0, 0.05))],
        };
        let center = DVec3::Z * (self.height_m / 2.0);
        let size_m = DVec3::new(2.0 * RADIUS_M, 2.0 * RADIUS_M, self.height_m);
        let rod = Body {
            joint: Some(hinge(1, Axis::RotationY)),
            inertia: Inertia::of_box(MASS_KG, center, size_m),
            parts: vec![part(
                BodyShape::Capsule { radius_m: RADIUS_M, length_m: self.height_m - 2.0 * RADIUS_M },
                center,
            )],
            collision_group: CollisionGroup::Rooted,
        };
        Structure {
            bodies: vec![Body::foot(), Body::between_hinges(hinge(0, Axis::RotationX)), rod],
            axisymmetric: true,
            surface: Surface::hard(crate::object::FRICTION),
        }
    }
}
