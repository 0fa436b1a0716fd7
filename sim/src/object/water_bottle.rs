//! Water bottle: an outlier that stands free on the table, and slides or tips over when it is pushed.

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_recording::{BodyShape, Category};

use super::{
    Body, CollisionGroup, Declared, Drawing, Footing, Inertia, Joint, Kind, Object, Structure, part, quantities,
};
use crate::{Draw, DrawError, Footprint, Surface};

/// The category of water bottles. Like the foam roll, a bottle does not belong to the foliage; it has a category of its
/// own because it feels different from a roll.
pub const CATEGORY: Category = Category::new("bottle", 4).expect("a valid name and a free code");

const WATER_DENSITY_KG_PER_M3: f64 = 1000.0;

quantities! {
    /// One bottle of a water dispenser, nearly empty. It is a rigid upright cylinder that no joint holds: it stands on the
    /// table by contact alone.
    ///
    /// If it is pushed slowly below the height r / μ, it slides and resists with μ m g, however far it has been pushed. If
    /// it is pushed higher up, it tips over.
    pub struct WaterBottle {
        // Bottles of water dispensers: those of 3 US gallons (11.4 l) are 25 cm thick and 38 cm high, those of 5 (18.9 l)
        // are 27 cm thick and 49 cm high. Smaller bottles are lower than the arm passes, or so slim that it tips them
        // over. Limits: those of foam rolls, from a glass tube to a barrel.
        /// Diameter, m.
        diameter_m: Draw::Uniform(0.25, 0.27), 0.02, 0.5;
        // The limits of trunks.
        /// Height over the table, m.
        height_m: Draw::Uniform(0.38, 0.49), 0.05, 2.0;
        // Empty polycarbonate bottles of 5 gallons weigh about 0.75 kg. Limits: from a thin film of plastic to a steel
        // barrel.
        /// Mass of the empty bottle, kg.
        empty_mass_kg: Draw::Fixed(0.75), 0.01, 30.0;
        // Choice: a rest of at most half a litre. A full bottle would resist with 50 N, which is more than the 3 N that
        // the controller allows a contact, and would feel like a trunk. The upper limit is that of a barrel; a draw of
        // more than the bottle holds is refused.
        /// Mass of the water in it, kg.
        water_mass_kg: Draw::Uniform(0.0, 0.5), 0.0, 300.0;
        // Choice: the coefficient of a contact is then 0.25 to 0.30 with the table (0.4) and 0.20 to 0.25 with Cody's skin
        // (0.3). Hard plastics slide on smooth table tops with 0.2 to 0.4. The limits are those of an arm's friction.
        /// Coefficient of friction of the bottle; the table has 0.4, and a contact has the mean of its two surfaces.
        friction: Draw::Uniform(0.1, 0.2), 0.0, 2.0;
    }
}

impl Kind for WaterBottle {
    const GROUP: (&'static str, &'static str) =
        ("WaterBottleSpecification", "A group of water bottles in a scene file.");
    const QUANTITIES: &'static [Declared] = Self::DECLARED;
    const CATEGORY: Category = CATEGORY;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        let is_possible = |bottle: &WaterBottle| bottle.water_mass_kg <= bottle.capacity_kg();
        // If nearly all bottles of these ranges would overflow, the error asks for less water.
        let refusal = |bottle: &WaterBottle| ("water_mass_kg", None, Some(bottle.capacity_kg()));
        drawing.until_possible(Self::draw_all, is_possible, refusal)
    }
}

impl WaterBottle {
    /// Mass with the water, kg.
    pub fn mass_kg(&self) -> f64 {
        self.empty_mass_kg + self.water_mass_kg
    }

    /// Height of the centre of mass over the table, m: the shell's is half-way up, the water's is half-way up its
    /// level.
    pub fn center_of_mass_m(&self) -> f64 {
        (self.empty_mass_kg * self.height_m + self.water_mass_kg * self.water_level_m()) / (2.0 * self.mass_kg())
    }

    /// Mass of the water that it can hold, kg.
    pub fn capacity_kg(&self) -> f64 {
        WATER_DENSITY_KG_PER_M3 * PI * self.radius_m().powi(2) * self.height_m
    }

    fn radius_m(&self) -> f64 {
        self.diameter_m / 2.0
    }

    fn water_level_m(&self) -> f64 {
        self.water_mass_kg / (WATER_DENSITY_KG_PER_M3 * PI * self.radius_m().powi(2))
    }

    /// Mass and inertia about the centre of mass, which is the origin of the body's frame. Choices: all plastic is in
    /// the wall, and the water moves as if it were frozen, because slow pushes hardly make it slosh.
    fn inertia(&self) -> Inertia {
        let (radius, height) = (self.radius_m(), self.height_m);
        // A thin-walled cylinder without ends: (m/12) (6 r² + h²) across, m r² about its axis.
        let wall_across = self.empty_mass_kg * (6.0 * radius * radius + height * height) / 12.0;
        let wall = DVec3::new(wall_across, wall_across, self.empty_mass_kg * radius * radius);
        let water = Inertia::of_cylinder(self.water_mass_kg, radius, self.water_level_m());
        // Both are shifted along the axis to the common centre of mass.
        let shift = |mass_kg: f64, center_m: f64| {
            mass_kg * (center_m - self.center_of_mass_m()).powi(2) * DVec3::new(1.0, 1.0, 0.0)
        };
        let principal_kg_m2 = wall
            + water.principal_kg_m2
            + shift(self.empty_mass_kg, height / 2.0)
            + shift(self.water_mass_kg, self.water_level_m() / 2.0);
        Inertia { mass_kg: self.mass_kg(), center_of_mass_body: DVec3::ZERO, principal_kg_m2 }
    }
}

impl Object for WaterBottle {
    /// The arm can push it away, but not pass through it.
    fn is_obstacle(&self) -> bool {
        true
    }

    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(self.radius_m()), self.height_m)
    }

    fn structure(&self, _: f64) -> Structure {
        let center_of_mass = DVec3::Z * self.center_of_mass_m();
        let cylinder = BodyShape::Cylinder { radius_m: self.radius_m(), length_m: self.height_m };
        let bottle = Body {
            joint: Some(Joint::free(0, center_of_mass)),
            inertia: self.inertia(),
            parts: vec![part(cylinder, DVec3::Z * (self.height_m / 2.0) - center_of_mass)],
            collision_group: CollisionGroup::Standing,
            ..Body::foot()
        };
        // Hard, like the other shells of plastic: where a wall bends under a push, it bends locally.
        Structure { bodies: vec![Body::foot(), bottle], axisymmetric: true, surface: Surface::hard(self.friction) }
    }
}

#[cfg(test)]
mod tests;
