//! The positions of the taxels: patches of skin on the links of an arm.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// All patches of skin on an arm, in the order used by [`crate::frame::TaxelReading::patch`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkinLayout {
    /// The patches; names are unique.
    pub patches: Vec<Patch>,
}

impl SkinLayout {
    /// The index of the patch called `name`.
    pub fn patch_index(&self, name: &str) -> Option<usize> {
        self.patches.iter().position(|patch| patch.name == name)
    }

    /// The index of the patch called `name`, or of the first patch if no name is given.
    pub fn chosen_patch(&self, name: Option<&str>) -> Option<usize> {
        match name {
            Some(name) => self.patch_index(name),
            None => (!self.patches.is_empty()).then_some(0),
        }
    }

    /// Total number of taxels.
    pub fn taxel_count(&self) -> usize {
        self.patches.iter().map(|patch| patch.taxels.len()).sum()
    }
}

/// One patch of skin, fixed to one link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Patch {
    /// Name, unique in the layout (`forearm`, `flipper`); part of column names in data sets.
    pub name: String,
    /// The link that carries it.
    pub link: String,
    /// Rows and columns, if the taxels form a grid.
    pub grid: Option<Grid>,
    /// The taxels. In a grid, index = row · columns + column.
    pub taxels: Vec<Taxel>,
}

/// The grid of a patch, which is needed to find connected components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grid {
    /// Rows (forearm: 16, along the arm).
    pub rows: usize,
    /// Columns (forearm: 24, around the arm).
    pub columns: usize,
    /// Whether the last column is a neighbour of the first, as on a closed sleeve.
    pub wraps: bool,
}

/// One taxel (tactile pixel) in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Taxel {
    /// Centre, m, link frame.
    pub position_link: DVec3,
    /// Outward unit normal, link frame.
    pub normal_link: DVec3,
    /// First unit tangent, link frame; the second is `normal × tangent`. Shear forces are given along these two.
    pub tangent_link: DVec3,
    /// Sensitive area, m².
    pub area_m2: f64,
}
