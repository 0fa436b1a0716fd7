//! Foam block: leaves stand in it, and the arm can hit it (paper, section IV-A: 25 cm × 10 cm, wet or dry).

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_recording::limits::SHARE;
use underbrush_recording::{BodyShape, Category, Limits};

use super::{
    Axis, Body, CollisionGroup, Declared, Drawing, FRICTION, Footing, Inertia, Joint, Kind, Object, Parameters, Spring,
    Structure, declared, foam_surface, part,
};
use crate::{Draw, DrawError, Footprint, Surface};

/// Length and width of a block, m (paper, section IV-A).
pub(crate) const LENGTH_M: f64 = 0.25;
const WIDTH_M: f64 = 0.10;

/// From the softest foams, of a few kPa, to solid plastic.
const MODULUS_PA: Limits = Limits::new(1.0e3, 1.0e9, "Pa");

impl Kind for FoamBlock {
    const GROUP: (&'static str, &'static str) = ("FoamBlockSpecification", "A group of foam blocks in a scene file.");
    const QUANTITIES: &'static [Declared] = declared! {
        // Choice: bricks of floral foam are 8 cm high. A single height keeps the platform level, as in the paper's Fig. 2.
        // Limits: from a mat to a block as high as the clutter.
        /// Height, m.
        height_m: Draw::Fixed(0.08), 0.01, 0.5;
        // The paper combines wet and dry foam but gives no proportion. Choice: half of each.
        /// Probability that a block is wet, 0 to 1.
        wet_share: Draw::Fixed(0.5), SHARE.min, SHARE.max;
        // Choice: dry phenolic floral foam has a modulus of a few MPa before it crushes.
        /// Modulus of dry foam, Pa.
        dry_modulus_pa: Draw::Uniform(1.0e6, 3.0e6), MODULUS_PA.min, MODULUS_PA.max;
        // Choice: foam that is soaked and has been pierced before holds a root about forty times more softly.
        /// Modulus of wet foam around a leaf's root, Pa.
        wet_modulus_pa: Draw::Uniform(3.0e4, 8.0e4), MODULUS_PA.min, MODULUS_PA.max;
        // Choice: no. In the paper's Fig. 2 blocks cover the ground and hold each other. A dry block of 50 g that stands alone
        // slides at 0.2 N, less than the force of one leaf, and the arm would sweep the clutter away.
        /// Whether a block stands free and carries its leaves: 1 yes, 0 no; the nearest whole number of what is drawn.
        stands_free: Draw::Fixed(0.0), SHARE.min, SHARE.max;
    };
    const CATEGORY: Category = Category::BLOCK;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        let height_m = drawing.quantity("height_m")?;
        let wet = drawing.happens("wet_share")?;
        let modulus_pa = drawing.quantity(if wet { "wet_modulus_pa" } else { "dry_modulus_pa" })?;
        Ok(FoamBlock { height_m, wet, modulus_pa, stands_free: drawing.quantity("stands_free")?.round() == 1.0 })
    }
}

/// Density of the foam without water, kg/m³: a dry brick of two litres weighs about 50 g. Choice: in wet foam, too,
/// only this mass moves with the top, and the water flows through the cells.
const DENSITY_KG_PER_M3: f64 = 25.0;
/// Water in a soaked block, kg/m³. Choice: floral foam is nearly all pores, and makers state that a brick of two litres takes
/// up nearly two litres. It counts only for a block that stands free, which carries its water along.
const WATER_KG_PER_M3: f64 = 900.0;
/// Share of the stiffness that relaxes, and the relaxation time, s, each of dry and of wet foam. Choices: dry phenolic
/// foam is a brittle solid and creeps little; in soaked foam water must flow, which takes some seconds over a hand's
/// breadth.
const RELAXING_SHARE: [f64; 2] = [0.05, 0.3];
const RELAXATION_TIME_S: [f64; 2] = [1.0, 2.0];
/// Damping ratio of the top on its spring, of dry and of wet foam: half the loss factor, about 0.2 for rigid foam.
/// Choice: more in wet foam, which moves water.
const DAMPING_RATIO: [f64; 2] = [0.1, 0.3];

/// One foam block: a bar under axial pressure, whose top sinks as a whole on a standard linear solid of stiffness E A /
/// H. The feet of leaves do not move with it; their roots have the stiffness of the foam.
///
/// A dry block has about 600 kN/m and a wet one 15 kN/m, two to four orders of magnitude above the arm's 0.1–0.4 kN/m.
///
/// One that stands free is a rigid box on the table, which slides, tips, and carries its leaves along. Its foam gives way
/// where something presses on it, as columns of height H do: by the pressure times H / E.
///
/// ```
/// use underbrush_sim::object::foam_block::FoamBlock;
///
/// let wet = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5e4, stands_free: true };
/// assert!((wet.stiffness_n_per_m() - 15_625.0).abs() < 1e-6);
/// // Two litres of foam and the water in them.
/// assert!((wet.mass_kg() - 1.85).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoamBlock {
    /// Height, m.
    pub height_m: f64,
    /// Whether it is soaked.
    pub wet: bool,
    /// Modulus, Pa.
    pub modulus_pa: f64,
    /// Whether it can slide and tip.
    pub stands_free: bool,
}

impl FoamBlock {
    /// What is recorded of it.
    pub(in crate::object) fn values(&self) -> Parameters {
        let mut parameters = Parameters::from([
            ("length_m", LENGTH_M),
            ("width_m", WIDTH_M),
            ("height_m", self.height_m),
            ("wet", f64::from(u8::from(self.wet))),
            ("modulus_pa", self.modulus_pa),
            ("density_kg_per_m3", DENSITY_KG_PER_M3),
            ("relaxing_share", self.own(RELAXING_SHARE)),
            ("relaxation_time_s", self.own(RELAXATION_TIME_S)),
        ]);
        parameters.extend(self.stands_free.then(|| ("mass_kg", self.mass_kg())));
        parameters
    }

    /// Instantaneous stiffness of the top against being pressed in, N/m: E A / H of an axially loaded bar.
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.modulus_pa * LENGTH_M * WIDTH_M / self.height_m
    }

    /// Mass that moves with the top, kg: half of the block's. Its weight then lowers the top by ρ g H² / (2 E), as the
    /// weight of a uniform bar does.
    pub fn moving_mass_kg(&self) -> f64 {
        0.5 * DENSITY_KG_PER_M3 * LENGTH_M * WIDTH_M * self.height_m
    }

    /// The one of two constants of dry and of wet foam that is its own.
    fn own(&self, [dry, wet]: [f64; 2]) -> f64 {
        if self.wet { wet } else { dry }
    }

    /// Mass with the water in it, kg.
    pub fn mass_kg(&self) -> f64 {
        let water = if self.wet { WATER_KG_PER_M3 } else { 0.0 };
        (DENSITY_KG_PER_M3 + water) * LENGTH_M * WIDTH_M * self.height_m
    }
}

impl Object for FoamBlock {
    fn size(&self) -> (Footprint, f64) {
        (Footprint::Rectangle(LENGTH_M / 2.0, WIDTH_M / 2.0), self.height_m)
    }

    fn structure(&self, gravity_m_per_s2: f64) -> Structure {
        let size_m = DVec3::new(LENGTH_M, WIDTH_M, self.height_m);
        let center = DVec3::Z * (self.height_m / 2.0);
        let [damping_ratio, share, time_s] =
            [DAMPING_RATIO, RELAXING_SHARE, RELAXATION_TIME_S].map(|own| self.own(own));
        if self.stands_free {
            // It sinks into its own foam: m g / (E A / H).
            let sag_m = self.mass_kg() * gravity_m_per_s2 / self.stiffness_n_per_m();
            let block = Body {
                joint: Some(Joint::free(0, center - DVec3::Z * sag_m)),
                inertia: Inertia::of_box(self.mass_kg(), DVec3::ZERO, size_m),
                parts: vec![part(BodyShape::Box { size_m }, DVec3::ZERO)],
                collision_group: CollisionGroup::Standing,
                ..Body::foot()
            };
            // Choice: its loss time is that of the foam's loss factor, twice the damping ratio, at the 10 Hz of a touch.
            let loss_time_s = 2.0 * damping_ratio / (2.0 * PI * 10.0);
            let surface = foam_surface(self.height_m / self.modulus_pa, loss_time_s);
            return Structure { bodies: vec![Body::foot(), block], axisymmetric: false, surface };
        }
        let (stiffness, mass_kg) = (self.stiffness_n_per_m(), self.moving_mass_kg());
        let spring = Spring::relaxing(stiffness, mass_kg, damping_ratio, share, time_s);
        let top = Body {
            joint: Some(Joint::parallel(0, DVec3::ZERO, vec![(Axis::along(DVec3::Z), spring)])),
            inertia: Inertia::of_box(mass_kg, center, size_m),
            parts: vec![part(BodyShape::Box { size_m }, center)],
            collision_group: CollisionGroup::Foam,
            ..Body::foot()
        };
        Structure { bodies: vec![Body::foot(), top], axisymmetric: false, surface: Surface::hard(FRICTION) }
    }

    fn carrier(&self) -> Option<usize> {
        self.stands_free.then_some(1)
    }

    fn foam_top(&self) -> Option<(f64, f64)> {
        Some((self.modulus_pa, self.height_m))
    }
}
