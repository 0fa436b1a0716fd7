//! Wand: a made-up object with a category of its own, for tests of how objects are added. A rod on two springy hinges.

#![allow(missing_docs, reason = "only tests use it")]

use glam::DVec3;
use underbrush_recording::{BodyShape, Category};

use crate::contact::surface::Surface;
use crate::geometry::Footprint;
use crate::object::group::{Declared, Drawing, Kind, quantities};
use crate::object::structure::{Axis, Body, CollisionGroup, Inertia, Joint, Spring, Structure, part};
use crate::object::{Footing, Object};
use crate::range::{Draw, DrawError};

pub(super) const CATEGORY: Category = Category::new("wand", 127).unwrap();

const RADIUS_M: f64 = 0.01;
const MASS_KG: f64 = 0.05;

quantities! {
    pub struct Wand {
        /// Height over the table, m.
        height_m: Draw::Uniform(0.45, 0.55), 0.1, 1.0;
    }
}

impl Kind for Wand {
    const GROUP: (&'static str, &'static str) = ("WandSpecification", "A group of wands.");
    const QUANTITIES: &'static [Declared] = Self::DECLARED;
    const CATEGORY: Category = CATEGORY;

    fn draw(drawing: &mut Drawing<'_>, _: &Footing) -> Result<Self, DrawError> {
        Self::draw_all(drawing)
    }
}

impl Object for Wand {
    fn passes_through_foam(&self) -> bool {
        true
    }

    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(RADIUS_M), self.height_m)
    }

    fn structure(&self, _: f64) -> Structure {
        let hinge = |parent, axis| Joint::parallel(parent, DVec3::ZERO, vec![(axis, Spring::elastic(2.0, 0.05))]);
        let center = DVec3::Z * (self.height_m / 2.0);
        let size_m = DVec3::new(2.0 * RADIUS_M, 2.0 * RADIUS_M, self.height_m);
        let rod = Body {
            joint: Some(hinge(1, Axis::about(DVec3::Y))),
            inertia: Inertia::of_box(MASS_KG, center, size_m),
            parts: vec![part(
                BodyShape::Capsule { radius_m: RADIUS_M, length_m: self.height_m - 2.0 * RADIUS_M },
                center,
            )],
            collision_group: CollisionGroup::Rooted,
            ..Body::foot()
        };
        Structure {
            bodies: vec![Body::foot(), Body::between_hinges(hinge(0, Axis::about(DVec3::X))), rod],
            axisymmetric: true,
            surface: Surface::hard(crate::object::FRICTION),
        }
    }
}
