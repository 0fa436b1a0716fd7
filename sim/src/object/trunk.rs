//! Trunk: rigid, fixed to the table beneath the foam (paper, section IV-A).

use glam::DVec3;
use underbrush_recording::{BodyShape, Category};

use super::{Body, Declared, Drawing, FRICTION, Footing, Kind, Object, Structure, part, quantities};
use crate::{Draw, DrawError, Footprint, Surface};

quantities! {
    /// One trunk.
    pub struct Trunk {
        // Choice: stems of artificial trees, and the pipes used in their place, are 2 to 4 cm thick. Limits: from a twig
        // to a tree trunk.
        /// Diameter, m.
        diameter_m: Draw::Uniform(0.02, 0.04), 0.005, 0.3;
        // Choice: as high over the table as the tallest leaves, so that the arm meets both at the same heights. The arm
        // passes over lower ones than the limit, and higher ones only add length above it.
        /// Height over the table, m.
        height_m: Draw::Uniform(0.40, 0.55), 0.05, 2.0;
    }
}

impl Kind for Trunk {
    const GROUP: (&'static str, &'static str) = ("TrunkSpecification", "A group of trunks in a scene file.");
    const QUANTITIES: &'static [Declared] = Self::DECLARED;
    const CATEGORY: Category = Category::TRUNK;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        // The top is half a ball, which must be above the table.
        let is_possible = |trunk: &Trunk| trunk.height_m >= trunk.diameter_m / 2.0;
        let refusal = |trunk: &Trunk| ("height_m", Some(trunk.diameter_m / 2.0), None);
        drawing.until_possible(Self::draw_all, is_possible, refusal)
    }
}

impl Object for Trunk {
    fn is_obstacle(&self) -> bool {
        true
    }

    fn passes_through_foam(&self) -> bool {
        true
    }

    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(self.diameter_m / 2.0), self.height_m)
    }

    fn structure(&self, _: f64) -> Structure {
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
