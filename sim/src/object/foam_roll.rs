//! Foam roll: the outlier, soft and slow to recover (paper, section V-D and Fig. 14).

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{BodyShape, Category};

use super::structure::{Axis, Body, CollisionGroup, Inertia, Joint, Maxwell, Spring, Structure, part};
use super::{EARTH_GRAVITY_M_PER_S2, Footing, Object, Specification, StandsOn};
use crate::geometry::Footprint;
use crate::range::{DrawError, Limited, Placement, Quantity, Within};

const CATEGORY: Category = Category::OUTLIER;

/// Slices into which a roll is cut along its height: each about half as high as the arm is thick.
const SLICES: usize = 10;

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
    /// Modulus felt at once, Pa.
    #[serde(default = "default_modulus")]
    #[schemars(transform = Within(MODULUS_LIMITS_PA))]
    pub modulus_pa: Quantity,
    /// Share of that modulus which relaxes away, 0 to 0.95.
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

/// Choice: viscoelastic foams lose about half of their first stiffness.
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

/// From a pipe's lagging to a bolster.
const DIAMETER_LIMITS_M: (f64, f64) = (0.02, 0.5);
/// As of trunks.
const HEIGHT_LIMITS_M: (f64, f64) = (0.05, 2.0);
const MODULUS_LIMITS_PA: (f64, f64) = (1.0e3, 1.0e8);
const SHARE_LIMITS: (f64, f64) = (0.0, 0.95);
/// From a frame to a quarter of an hour.
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
            Limited {
                name: "diameter_m",
                quantity: &self.diameter_m,
                limits: DIAMETER_LIMITS_M,
            },
            Limited {
                name: "height_m",
                quantity: &self.height_m,
                limits: HEIGHT_LIMITS_M,
            },
            Limited {
                name: "modulus_pa",
                quantity: &self.modulus_pa,
                limits: MODULUS_LIMITS_PA,
            },
            Limited {
                name: "relaxing_share",
                quantity: &self.relaxing_share,
                limits: SHARE_LIMITS,
            },
            Limited {
                name: "relaxation_time_s",
                quantity: &self.relaxation_time_s,
                limits: TIME_LIMITS_S,
            },
            Limited {
                name: "density_kg_per_m3",
                quantity: &self.density_kg_per_m3,
                limits: DENSITY_LIMITS,
            },
        ]
    }

    fn draw(&self, random: &mut ChaCha8Rng, _: &Footing) -> Result<Box<dyn Object>, DrawError> {
        let mut drawn = self.draw_once(random)?;
        for _ in 0..DRAWS {
            if drawn.stands_by_itself() {
                return Ok(Box::new(drawn));
            }
            drawn = self.draw_once(random)?;
        }
        // Nearly all rolls of these ranges would topple: the modulus is what to change.
        Err(DrawError {
            draw: self.modulus_pa.draw,
            low: drawn.modulus_pa * drawn.load_share() / LARGEST_LOAD_SHARE,
            high: MODULUS_LIMITS_PA.1,
        })
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    fn stands_on(&self) -> StandsOn {
        StandsOn::Table
    }
}

/// A roll that could not stand by itself is drawn anew, this many times.
const DRAWS: usize = 100;

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

/// One foam roll standing on the table: a core that leans as a whole on two base hinges, and slices that each slide
/// sideways on the core where they are pushed. Every spring is a standard linear solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamRoll {
    /// Diameter, m.
    pub diameter_m: f64,
    /// Height, m.
    pub height_m: f64,
    /// Modulus felt at once, Pa.
    pub modulus_pa: f64,
    /// Share of the modulus which relaxes away.
    pub relaxing_share: f64,
    /// Relaxation time, s.
    pub relaxation_time_s: f64,
    /// Density, kg/m³.
    pub density_kg_per_m3: f64,
}

/// Largest share of the toppling load with which a roll counts as standing. Choice: it then leans at most five times as
/// far as a roll without weight would.
const LARGEST_LOAD_SHARE: f64 = 0.8;

/// Damping ratio of a foam's own vibrations: its loss factor of about 0.4, halved.
const DAMPING_RATIO: f64 = 0.2;

impl FoamRoll {
    /// Stiffness of the two base hinges felt at once, Nm/rad: the one that gives the tip of the roll the deflection
    /// of a cantilever, F H³ / 3 E I, that is k = 3 E I / H.
    pub fn lean_stiffness_nm_per_rad(&self) -> f64 {
        3.0 * self.modulus_pa * PI * self.diameter_m.powi(4) / 64.0 / self.height_m
    }

    /// Stiffness of one slice against sliding sideways felt at once, N/m: a bar as long and as wide as the diameter
    /// and one slice high has E A / D = E h.
    pub fn slice_stiffness_n_per_m(&self) -> f64 {
        self.modulus_pa * self.height_m / SLICES as f64
    }

    /// The roll's weight as a share of the load under which it would topple once its foam has relaxed.
    ///
    /// With the core leaning by θ and slice i slid by x_i, the energy to second order is
    /// ½ k θ² + Σ ½ s x_i² − Σ m g (½ h_i θ² + x_i θ), where m is a slice's mass, h_i its height, and k and s are the
    /// relaxed stiffness of hinge and slice. At its minimum over the x_i it is ½ θ² (k − M g H / 2 − (M g)² / Σ s), so the
    /// roll comes back upright where k is larger than the two terms of the weight M g.
    pub fn load_share(&self) -> f64 {
        let relaxed = 1.0 - self.relaxing_share;
        let area_m2 = PI * self.diameter_m.powi(2) / 4.0;
        let weight_n = EARTH_GRAVITY_M_PER_S2 * self.density_kg_per_m3 * area_m2 * self.height_m;
        let slices_n_per_m = SLICES as f64 * self.slice_stiffness_n_per_m() * relaxed;
        let tilting_nm_per_rad = weight_n * self.height_m / 2.0 + weight_n * weight_n / slices_n_per_m;
        tilting_nm_per_rad / (self.lean_stiffness_nm_per_rad() * relaxed)
    }

    /// Whether the roll carries its own weight and comes back upright, however long it was pushed.
    pub fn stands_by_itself(&self) -> bool {
        self.load_share() <= LARGEST_LOAD_SHARE
    }

    fn standard_linear_solid(&self, stiffness: f64, inertia: f64) -> Spring {
        Spring {
            stiffness: stiffness * (1.0 - self.relaxing_share),
            damping: 2.0 * DAMPING_RATIO * (stiffness * inertia).sqrt(),
            armature: 0.0,
            maxwell: Some(Maxwell {
                stiffness: stiffness * self.relaxing_share,
                relaxation_time_s: self.relaxation_time_s,
            }),
        }
    }
}

impl Object for FoamRoll {
    fn kind(&self) -> &'static str {
        "foam_roll"
    }

    fn category(&self) -> Category {
        CATEGORY
    }

    /// The arm presses its surface in, but cannot pass it.
    fn is_obstacle(&self) -> bool {
        true
    }

    fn may_stand_in_foam(&self) -> bool {
        false
    }

    fn footprint(&self) -> Footprint {
        Footprint::Disc(self.diameter_m / 2.0)
    }

    fn height_m(&self) -> f64 {
        self.height_m
    }

    /// Choice: a layer as thick as the radius, down to the core, gives way by R / E.
    fn surface_compliance_m3_per_n(&self) -> f64 {
        0.5 * self.diameter_m / self.modulus_pa
    }

    fn parameters(&self) -> BTreeMap<String, f64> {
        BTreeMap::from([
            ("diameter_m".into(), self.diameter_m),
            ("height_m".into(), self.height_m),
            ("modulus_pa".into(), self.modulus_pa),
            ("relaxing_share".into(), self.relaxing_share),
            ("relaxation_time_s".into(), self.relaxation_time_s),
            ("density_kg_per_m3".into(), self.density_kg_per_m3),
        ])
    }

    fn structure(&self) -> Structure {
        let radius_m = self.diameter_m / 2.0;
        let slice_height_m = self.height_m / SLICES as f64;
        let slice_mass_kg = self.density_kg_per_m3 * PI * radius_m * radius_m * slice_height_m;
        let lean_inertia = slice_mass_kg * SLICES as f64 * self.height_m.powi(2) / 3.0;
        let lean = self.standard_linear_solid(self.lean_stiffness_nm_per_rad(), lean_inertia);
        let base_hinge = |parent, axis| {
            Body::between_hinges(Joint {
                parent,
                origin_parent: DVec3::ZERO,
                free_axes: vec![(axis, lean)],
            })
        };
        let mut bodies = vec![
            Body::foot(),
            base_hinge(0, Axis::RotationX),
            base_hinge(1, Axis::RotationY),
        ];
        let core = bodies.len() - 1;
        let slide = self.standard_linear_solid(self.slice_stiffness_n_per_m(), slice_mass_kg);
        bodies.extend((0..SLICES).map(|slice| Body {
            joint: Some(Joint {
                parent: core,
                origin_parent: DVec3::Z * (slice as f64 + 0.5) * slice_height_m,
                free_axes: vec![(Axis::TranslationX, slide), (Axis::TranslationY, slide)],
            }),
            inertia: Inertia::of_cylinder(slice_mass_kg, radius_m, slice_height_m),
            parts: vec![part(
                BodyShape::Cylinder {
                    radius_m,
                    length_m: slice_height_m,
                },
                DVec3::ZERO,
            )],
            collision_group: if slice == 0 {
                CollisionGroup::Rooted
            } else {
                CollisionGroup::Bendable
            },
        }));
        Structure {
            bodies,
            axisymmetric: true,
        }
    }
}

#[cfg(test)]
mod tests;
