//! Table top: what the arm, leaves, rolls and bottles meet below the clutter. A scene has one only if it says so: Cody's arm
//! stays well above the ground in the scenes of leaves and trunks.

use glam::DVec3;
use underbrush_recording::{BodyShape, Category};

use super::{Body, Declared, Drawing, Footing, Kind, Object, Structure, TABLE_FRICTION, part, quantities};
use crate::{Draw, DrawError, Footprint, Surface};

/// Thickness of the top, m. Choice: thicker than any overlap, so that nothing comes out below.
const THICKNESS_M: f64 = 0.1;

quantities! {
    /// The top of a table, at the height of the workspace's table.
    pub struct Table {
        // Choice: larger than an arm's reach around any place of the workspace. Limits: from a shelf to a floor.
        /// Length, m.
        length_m: Draw::Fixed(3.0), 0.05, 20.0;
        /// Width, m.
        width_m: Draw::Fixed(3.0), 0.05, 20.0;
    }
}

impl Kind for Table {
    const GROUP: (&'static str, &'static str) =
        ("TableSpecification", "A table top that arm and objects collide with.");
    const QUANTITIES: &'static [Declared] = Self::DECLARED;
    /// It belongs to the ground, as foam blocks do.
    const CATEGORY: Category = Category::BLOCK;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        Self::draw_all(drawing)
    }
}

impl Object for Table {
    fn is_ground(&self) -> bool {
        true
    }

    fn size(&self) -> (Footprint, f64) {
        (Footprint::Rectangle(self.length_m / 2.0, self.width_m / 2.0), 0.0)
    }

    fn structure(&self, _: f64) -> Structure {
        let size_m = DVec3::new(self.length_m, self.width_m, THICKNESS_M);
        let top =
            Body { parts: vec![part(BodyShape::Box { size_m }, -DVec3::Z * (THICKNESS_M / 2.0))], ..Body::foot() };
        Structure { bodies: vec![top], axisymmetric: false, surface: Surface::hard(TABLE_FRICTION) }
    }
}
