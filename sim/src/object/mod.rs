//! What stands in the clutter: one file an object, and `for_each_object_kind` as the one list of them.
//!
//! An object has two faces: a *specification* (what a scene file says of a group of such objects, with ranges) and a
//! *drawn object* (one concrete thing that describes its bodies and joints). To add one, write a file like `trunk.rs`
//! and add its line to the list below.

use std::collections::BTreeMap;

use rand_chacha::ChaCha8Rng;
use underbrush_recording::Category;

use crate::geometry::Footprint;
use crate::range::{DrawError, Limited, Placement};

pub mod foam_block;
pub mod foam_roll;
pub mod leaf;
pub mod structure;
pub mod trunk;

pub use structure::Structure;

/// The one list of object kinds: `key in the scene file: specification type`.
macro_rules! for_each_object_kind {
    ($apply:ident) => {
        $apply! {
            /// Stiff stems fixed to the table.
            trunk: $crate::object::trunk::TrunkSpecification,
            /// The outlier.
            foam_roll: $crate::object::foam_roll::FoamRollSpecification,
            /// Ground platform and obstacle; must come before what stands in it.
            foam_block: $crate::object::foam_block::FoamBlockSpecification,
            /// Bendable leaves stuck in foam.
            leaf: $crate::object::leaf::LeafSpecification,
        }
    };
}
pub(crate) use for_each_object_kind;

/// What a scene file says of a group of objects of one kind.
pub trait Specification {
    /// How many there are.
    fn count(&self) -> u32;

    /// Where they may stand, where the group says so.
    fn place(&self) -> Option<&Placement>;

    /// Every range of it with its name and the physical limits of its values, for validation and error texts.
    fn quantities(&self) -> Vec<Limited<'_>>;

    /// Draws one object. `footing` is what it stands on.
    ///
    /// # Errors
    /// When a range has (almost) no share of physical values.
    fn draw(&self, random: &mut ChaCha8Rng, footing: &Footing) -> Result<Box<dyn Object>, DrawError>;

    /// What else is wrong with the group, if anything: `(field, found, allowed)`.
    fn fault(&self) -> Option<(&'static str, String, String)> {
        None
    }

    /// What the objects must stand on.
    fn stands_on(&self) -> StandsOn;

    /// Their ground-truth category.
    fn category(&self) -> Category;
}

/// What an object needs under its foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandsOn {
    /// The table beneath the foam.
    Table,
    /// The top of a foam block.
    Foam,
}

/// What an object stands on once it is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// Height of the surface, m, world frame.
    pub height_m: f64,
    /// Modulus of the foam, Pa; `None` on the bare table.
    pub foam_modulus_pa: Option<f64>,
}

/// One concrete object, ready to be built.
pub trait Object: std::fmt::Debug + Send + Sync {
    /// Its key in the scene file.
    fn kind(&self) -> &'static str;
    /// Its ground-truth category.
    fn category(&self) -> Category;
    /// Whether it holds the arm back instead of letting it through. Goals keep clear of it.
    fn is_obstacle(&self) -> bool;
    /// Whether its ground area may overlap that of foam, because it stands in the foam or goes through it to the table.
    fn may_stand_in_foam(&self) -> bool;
    /// Its ground area at rest.
    fn footprint(&self) -> Footprint;
    /// Half its thickness along its own x and y, m, for questions of nearness.
    fn half_sizes_m(&self) -> [f64; 2] {
        match self.footprint() {
            Footprint::Disc(radius) => [radius, radius],
            Footprint::Rectangle(x, y) => [x, y],
        }
    }
    /// Its height over its foot, m.
    fn height_m(&self) -> f64;
    /// Its drawn parameters by name, SI units in the names.
    fn parameters(&self) -> BTreeMap<String, f64>;
    /// Its bodies, joints and springs at rest.
    fn structure(&self) -> Structure;
    /// How far its surface gives way under pressure, m³/N: the skin's layer and it are pressed in together. 0 where it is
    /// rigid against the skin's cover, as most things are.
    fn surface_compliance_m3_per_n(&self) -> f64 {
        0.0
    }
    /// Modulus and height of the foam in which others may stand, Pa and m, where it is such foam.
    fn foam_top(&self) -> Option<(f64, f64)> {
        None
    }
}

/// Gravity under which a drawn object must stand by itself, m/s².
pub(crate) const EARTH_GRAVITY_M_PER_S2: f64 = 9.81;

/// Friction between the skin and whatever it touches: the paper gives none; 0.2–0.4 is usual for
/// fabric and silicone on plastic, and the authors' planar simulation uses 0.4.
pub const FRICTION: f64 = 0.4;
