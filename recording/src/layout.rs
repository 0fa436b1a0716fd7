//! The positions of the taxels: patches of skin on the links of an arm.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// All patches of skin on an arm, in the order used by [`crate::frame::TaxelReading::patch`].
///
/// ```
/// use glam::DVec3;
/// use underbrush_recording::{Grid, Patch, SkinLayout, Taxel};
///
/// // A pad of 2 × 3 taxels on a link called palm, 1 cm apart.
/// let taxel = |index: usize| Taxel {
///     position_link: 0.01 * DVec3::new((index % 3) as f64, (index / 3) as f64, 0.0),
///     normal_link: DVec3::Z,
///     tangent_link: DVec3::X,
///     area_m2: 1e-4,
/// };
/// let grid = Some(Grid { rows: 2, columns: 3, wraps: false });
/// let pad = Patch { name: "pad".into(), link: "palm".into(), grid, taxels: (0..6).map(taxel).collect() };
/// let layout = SkinLayout { patches: vec![pad] };
/// assert_eq!(layout.taxel_count(), 6);
/// assert_eq!((layout.patch_index("pad"), layout.chosen_patch(Some("sole"))), (Some(0), None));
/// ```
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

impl Grid {
    /// The taxels above, below, before and behind a taxel; `None` where the grid ends.
    ///
    /// ```
    /// let grid = underbrush_recording::Grid { rows: 2, columns: 3, wraps: true };
    /// assert_eq!(grid.neighbours(0), [None, Some(3), Some(2), Some(1)]);
    /// // Taxels 0 and 2 are neighbours around the sleeve.
    /// assert_eq!(grid.regions(|taxel| [0, 2, 4].contains(&taxel)), [vec![0, 2], vec![4]]);
    /// ```
    pub fn neighbours(&self, taxel: usize) -> [Option<usize>; 4] {
        let Grid { rows, columns, wraps } = *self;
        let (row, column) = (taxel / columns, taxel % columns);
        let at = |row: usize, column: usize| row * columns + column;
        [
            (row > 0).then(|| at(row - 1, column)),
            (row + 1 < rows).then(|| at(row + 1, column)),
            (column > 0 || wraps).then(|| at(row, (column + columns - 1) % columns)),
            (column + 1 < columns || wraps).then(|| at(row, (column + 1) % columns)),
        ]
    }

    /// The connected taxels in contact: for each region its taxels, ascending; the regions by their first taxel.
    pub fn regions(&self, is_in_contact: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let mut seen = vec![false; self.rows * self.columns];
        let mut found = Vec::new();
        for first in 0..seen.len() {
            if seen[first] || !is_in_contact(first) {
                continue;
            }
            seen[first] = true;
            let mut taxels = vec![first];
            let mut next = 0;
            while let Some(&taxel) = taxels.get(next) {
                next += 1;
                for neighbour in self.neighbours(taxel).into_iter().flatten() {
                    if !seen[neighbour] && is_in_contact(neighbour) {
                        seen[neighbour] = true;
                        taxels.push(neighbour);
                    }
                }
            }
            taxels.sort_unstable();
            found.push(taxels);
        }
        found
    }
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
