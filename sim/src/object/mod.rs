//! The kinds of objects in the clutter: one file for each, and the list `for_each_object_kind`.
//!
//! A kind declares its quantities once ([`group`]): what a scene file may say about a group of such objects follows from
//! that. An object is one concrete instance drawn from a group. It describes its bodies and joints as plain data
//! ([`structure`]) and does not depend on the engine. To add a kind, write a file like `trunk.rs` and add its line to
//! the list. A kind that belongs to none of the built-in categories defines its own, as `tests/wand.rs` does.

use std::collections::BTreeMap;

use underbrush_recording::Category;

use crate::contact::surface::Surface;
use crate::geometry::Footprint;

pub mod blade;
pub mod foam_block;
pub mod foam_roll;
pub mod group;
pub mod leaf;
pub mod plant;
pub mod structure;
pub mod table;
pub mod trunk;
pub mod water_bottle;

pub use group::{DrawnQuantities, Group, Specification};
pub use structure::Structure;

/// The list of object kinds, as `key in the scene file: type of the object`. Objects are placed in this order, so
/// whatever others stand on comes before them.
macro_rules! for_each_object_kind {
    ($apply:ident) => {
        $apply! {
            /// Table tops, with which the arm and all moving parts of objects collide.
            table: $crate::object::table::Table,
            /// Stiff stems fixed to the table.
            trunk: $crate::object::trunk::Trunk,
            /// Soft rolls, foreign to the foliage.
            foam_roll: $crate::object::foam_roll::FoamRoll,
            /// Nearly empty water bottles that slide on the table, foreign to the foliage.
            water_bottle: $crate::object::water_bottle::WaterBottle,
            /// Blocks of the ground platform.
            foam_block: $crate::object::foam_block::FoamBlock,
            /// Bendable leaves that stand in foam.
            leaf: $crate::object::leaf::Leaf,
            /// Stems with blades around them, which stand in foam.
            plant: $crate::object::plant::Plant,
            /// A made-up object of the tests.
            #[cfg(test)]
            wand: $crate::object::tests::wand::Wand,
        }
    };
}
use blade::{
    Blade, COLLISION_THICKNESS_M, Hinge, NEVER_PULLED_N, NEVER_YIELDS_NM, SHEET_TORSION_OVER_BENDING, gauss_legendre,
    grip, on_root, root_stiffness_nm_per_rad, yields,
};
pub(crate) use for_each_object_kind;
use group::{Declared, Drawing, Kind, declared, quantities};
use structure::{Axis, Body, CollisionGroup, Grip, Inertia, Joint, Spring, part};

macro_rules! declare {
    ($($(#[$attribute:meta])* $key:ident: $kind:ty,)*) => {
        /// The category of each kind.
        #[allow(unused_doc_comments, reason = "the entries' documentation is that of the fields of a scene file")]
        const CATEGORIES: &[Category] = &[$($(#[$attribute])* <$kind as group::Kind>::CATEGORY,)*];

        /// What can collide: the arm, and the kinds of objects by their keys in a scene file.
        #[allow(unused_doc_comments, reason = "the entries' documentation is that of the fields of a scene file")]
        pub const COLLIDING_KINDS: &[&str] = &["arm", $($(#[$attribute])* stringify!($key),)*];

        $($(#[$attribute])*
        impl Listed for $kind {
            fn kind(&self) -> &'static str {
                stringify!($key)
            }

            fn parameters(&self) -> Parameters {
                self.values()
            }
        })*
    };
}
for_each_object_kind!(declare);

/// What the list of kinds says of an object.
pub trait Listed {
    /// Its key in the scene file.
    fn kind(&self) -> &'static str;
    /// Its parameters: the quantities that were drawn, or what its kind records instead.
    fn parameters(&self) -> Parameters;
}

/// What an object stands on once it is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// Height of the surface, m, world frame.
    pub height_m: f64,
    /// Modulus of the foam, Pa; `None` on the bare table.
    pub foam_modulus_pa: Option<f64>,
}

/// Parameters of an object by name, SI units in the names.
pub type Parameters = BTreeMap<&'static str, f64>;

/// One concrete object, ready to be built.
pub trait Object: Listed + std::fmt::Debug + Send + Sync {
    /// Whether it holds the arm back instead of letting it through. Goals keep clear of it.
    fn is_obstacle(&self) -> bool {
        false
    }
    /// Whether it lies under all other objects, which stand on it.
    fn is_ground(&self) -> bool {
        false
    }
    /// Whether it may share ground with a foam block although it stands on the table.
    fn passes_through_foam(&self) -> bool {
        false
    }
    /// Its ground area at rest, and its height over its foot, m.
    fn size(&self) -> (Footprint, f64);
    /// Half its thickness along its own x and y, m, for clearance queries.
    fn half_sizes_m(&self) -> [f64; 2] {
        match self.size().0 {
            Footprint::Disc(radius) => [radius, radius],
            Footprint::Rectangle(x, y) => [x, y],
        }
    }
    /// Its bodies, joints and springs at rest under this gravity, m/s².
    fn structure(&self, gravity_m_per_s2: f64) -> Structure;
    /// The body of its structure that carries what stands on it, if it can move away with it.
    fn carrier(&self) -> Option<usize> {
        None
    }
    /// For foam that others may stand in: its modulus, Pa, and its height, m.
    fn foam_top(&self) -> Option<(f64, f64)> {
        None
    }
}

/// Gravity under which an object must stand by itself, m/s².
pub(crate) const EARTH_GRAVITY_M_PER_S2: f64 = 9.81;

/// Coefficient of friction of the surface of leaves, trunks, foam blocks and foam rolls. The paper gives none; 0.2–0.4
/// is usual for fabric and silicone on plastic, and the authors' planar simulation uses 0.4.
pub const FRICTION: f64 = 0.4;

/// The surface of foam that gives way by this much under a pressure, m³/N, with this loss time, s.
fn foam_surface(compliance_m3_per_n: f64, loss_time_s: f64) -> Surface {
    Surface { compliance_m3_per_n, thickness_m: None, loss_time_s, friction: FRICTION }
}

/// Coefficient of friction of the table. Choice: that of the objects, [`FRICTION`].
pub const TABLE_FRICTION: f64 = 0.4;

#[cfg(test)]
pub(crate) mod tests;
