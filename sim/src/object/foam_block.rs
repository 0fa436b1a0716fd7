//! Foam block: leaves stand in it, and the arm can hit it (paper, section IV-A: 25 cm × 10 cm, wet or dry).

use std::collections::BTreeMap;

use glam::DVec3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{BodyShape, Category};

use super::FRICTION;
use super::structure::{Axis, Body, CollisionGroup, Inertia, Joint, Maxwell, Spring, Structure, part};
use super::{Footing, Object, Specification, StandsOn};
use crate::contact::surface::Surface;
use crate::geometry::Footprint;
use crate::range::{DrawError, Limited, Placement, Quantity, Within};

const CATEGORY: Category = Category::BLOCK;

/// Length and width of a block, m (paper, section IV-A).
const LENGTH_M: f64 = 0.25;
const WIDTH_M: f64 = 0.10;

/// A group of foam blocks in a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoamBlockSpecification {
    /// How many.
    pub count: u32,
    /// Where they may lie; the scene's workspace if not given.
    pub place: Option<Placement>,
    /// Height, m.
    #[serde(default = "default_height")]
    #[schemars(transform = Within(HEIGHT_LIMITS_M))]
    pub height_m: Quantity,
    /// Probability that a block is wet, 0 to 1.
    #[serde(default = "default_wet_share")]
    #[schemars(transform = Within(SHARE_LIMITS))]
    pub wet_share: Quantity,
    /// Modulus of dry foam, Pa.
    #[serde(default = "default_dry_modulus")]
    #[schemars(transform = Within(MODULUS_LIMITS_PA))]
    pub dry_modulus_pa: Quantity,
    /// Modulus of wet foam around a leaf's root, Pa.
    #[serde(default = "default_wet_modulus")]
    #[schemars(transform = Within(MODULUS_LIMITS_PA))]
    pub wet_modulus_pa: Quantity,
}

/// Choice: bricks of floral foam are 8 cm high. A single height keeps the platform level, as in the paper's Fig. 2.
fn default_height() -> Quantity {
    Quantity::fixed(0.08)
}

/// The paper combines wet and dry foam but gives no proportion. Choice: half of each.
fn default_wet_share() -> Quantity {
    Quantity::fixed(0.5)
}

/// Choice: dry phenolic floral foam has a modulus of a few MPa before it crushes.
fn default_dry_modulus() -> Quantity {
    Quantity::uniform(1.0e6, 3.0e6)
}

/// Choice: foam that is soaked and has been pierced before holds a root about forty times more softly.
fn default_wet_modulus() -> Quantity {
    Quantity::uniform(3.0e4, 8.0e4)
}

/// From a mat to a block as high as the clutter.
const HEIGHT_LIMITS_M: (f64, f64) = (0.01, 0.5);
const SHARE_LIMITS: (f64, f64) = (0.0, 1.0);
/// From the softest foams, of a few kPa, to solid plastic.
const MODULUS_LIMITS_PA: (f64, f64) = (1.0e3, 1.0e9);

impl Specification for FoamBlockSpecification {
    fn count(&self) -> u32 {
        self.count
    }

    fn place(&self) -> Option<&Placement> {
        self.place.as_ref()
    }

    fn quantities(&self) -> Vec<Limited<'_>> {
        vec![
            Limited::new("height_m", &self.height_m, HEIGHT_LIMITS_M),
            Limited::new("wet_share", &self.wet_share, SHARE_LIMITS),
            Limited::new("dry_modulus_pa", &self.dry_modulus_pa, MODULUS_LIMITS_PA),
            Limited::new("wet_modulus_pa", &self.wet_modulus_pa, MODULUS_LIMITS_PA),
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let height_m = self.height_m.draw(random, HEIGHT_LIMITS_M)?;
        let wet = random.next_u32() as f64 / 2f64.powi(32) < self.wet_share.draw(random, SHARE_LIMITS)?;
        let modulus = if wet { &self.wet_modulus_pa } else { &self.dry_modulus_pa };
        Ok(Box::new(FoamBlock { height_m, wet, modulus_pa: modulus.draw(random, MODULUS_LIMITS_PA)? }))
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Table
    }
}

/// Density of the foam without water, kg/m³: a dry brick of two litres weighs about 50 g. Choice: in wet foam, too,
/// only this mass moves with the top, and the water flows through the cells.
const DENSITY_KG_PER_M3: f64 = 25.0;
/// Share of the stiffness that relaxes, and the relaxation time, s. Choices: dry phenolic foam is a brittle solid and
/// creeps little; in soaked foam water must flow, which takes some seconds over a hand's breadth.
const RELAXING_SHARE: Kinds = Kinds { dry: 0.05, wet: 0.3 };
const RELAXATION_TIME_S: Kinds = Kinds { dry: 1.0, wet: 2.0 };
/// Damping ratio of the top on its spring: half the loss factor, about 0.2 for rigid foam. Choice: more in wet foam,
/// which moves water.
const DAMPING_RATIO: Kinds = Kinds { dry: 0.1, wet: 0.3 };

struct Kinds {
    dry: f64,
    wet: f64,
}

impl Kinds {
    fn of(&self, block: &FoamBlock) -> f64 {
        if block.wet { self.wet } else { self.dry }
    }
}

/// One foam block: a bar under axial pressure, whose top sinks as a whole on a standard linear solid of stiffness E A /
/// H. The feet of leaves do not move with it; their roots have the stiffness of the foam.
///
/// A dry block has about 600 kN/m and a wet one 15 kN/m, two to four orders of magnitude above the arm's 0.1–0.4 kN/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamBlock {
    /// Height, m.
    pub height_m: f64,
    /// Whether it is soaked.
    pub wet: bool,
    /// Modulus, Pa.
    pub modulus_pa: f64,
}

impl FoamBlock {
    /// Instantaneous stiffness of the top against being pressed in, N/m: E A / H of an axially loaded bar.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.modulus_pa * LENGTH_M * WIDTH_M / self.height_m
    }

    /// Mass that moves with the top, kg: half of the block's. Its weight then lowers the top by ρ g H² / (2 E), as the
    /// weight of a uniform bar does.
    pub fn moving_mass_kg(&self) -> f64 {
        0.5 * DENSITY_KG_PER_M3 * LENGTH_M * WIDTH_M * self.height_m
    }

    fn spring(&self) -> Spring {
        let (stiffness, share) = (self.stiffness_n_per_m(), RELAXING_SHARE.of(self));
        Spring {
            stiffness: stiffness * (1.0 - share),
            damping: 2.0 * DAMPING_RATIO.of(self) * (stiffness * self.moving_mass_kg()).sqrt(),
            armature: 0.0,
            maxwell: Some(Maxwell { stiffness: stiffness * share, relaxation_time_s: RELAXATION_TIME_S.of(self) }),
        }
    }
}

impl Object for FoamBlock {
    fn kind(&self) -> &'static str {
        "foam_block"
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    /// No: goals lie above it.
    fn is_obstacle(&self) -> bool {
        false
    }

    fn may_stand_in_foam(&self) -> bool {
        false
    }

    fn footprint(&self) -> Footprint {
        Footprint::Rectangle(LENGTH_M / 2.0, WIDTH_M / 2.0)
    }

    fn height_m(&self) -> f64 {
        self.height_m
    }

    fn parameters(&self) -> BTreeMap<String, f64> {
        BTreeMap::from([
            ("length_m".into(), LENGTH_M),
            ("width_m".into(), WIDTH_M),
            ("height_m".into(), self.height_m),
            ("wet".into(), f64::from(u8::from(self.wet))),
            ("modulus_pa".into(), self.modulus_pa),
            ("density_kg_per_m3".into(), DENSITY_KG_PER_M3),
            ("relaxing_share".into(), RELAXING_SHARE.of(self)),
            ("relaxation_time_s".into(), RELAXATION_TIME_S.of(self)),
        ])
    }

    fn structure(&self) -> Structure {
        let size_m = DVec3::new(LENGTH_M, WIDTH_M, self.height_m);
        let center = DVec3::Z * (self.height_m / 2.0);
        let top = Body {
            joint: Some(Joint {
                parent: 0,
                origin_parent: DVec3::ZERO,
                free_axes: vec![(Axis::TranslationZ, self.spring())],
            }),
            inertia: Inertia::of_box(self.moving_mass_kg(), center, size_m),
            parts: vec![part(BodyShape::Box { size_m }, center)],
            collision_group: CollisionGroup::Fixed,
        };
        Structure { bodies: vec![Body::foot(), top], axisymmetric: false, surface: Surface::hard(FRICTION) }
    }

    fn foam_top(&self) -> Option<(f64, f64)> {
        Some((self.modulus_pa, self.height_m))
    }
}
