//! Connected components of the taxels in contact in one frame, and the contact region around each taxel.

use glam::DVec3;
use underbrush_recording::{Grid, Region};

use super::TrialError;
use super::image::PatchImage;

/// One contact region of one frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Component {
    /// Its taxels in ascending order.
    pub(super) taxels: Vec<usize>,
    /// Unweighted mean of the taxels' centres, m, world frame (as in the authors' code; paper, section IV-C).
    pub(super) center_world: DVec3,
    /// The taxel with the largest sensed force, the first in a tie.
    pub(super) strongest: usize,
    /// What a trial stores of it.
    pub(super) region: Region,
    /// Ground truth: the object of the strongest taxel that has one. Because of crosstalk, a taxel that touches nothing
    /// can also sense a force.
    pub(super) object: Option<u16>,
    /// Ground truth: whether an object presses on any of its taxels.
    pub(super) touched: bool,
}

/// The 4-connected regions of taxels in contact, ordered by first taxel.
///
/// The grid must have as many cells as the patch has taxels; `grid.wraps` makes the first and last column neighbours.
pub(super) fn components(image: &PatchImage, grid: Grid) -> Vec<Component> {
    let regions = grid.regions(|taxel| image.is_in_contact(taxel));
    regions.into_iter().map(|taxels| measure(image, taxels)).collect()
}

fn measure(image: &PatchImage, taxels: Vec<usize>) -> Component {
    let strongest_of = |taxels: &mut dyn Iterator<Item = usize>| {
        taxels.reduce(|best, taxel| if image.sensed_force_n(taxel) > image.sensed_force_n(best) { taxel } else { best })
    };
    let strongest = strongest_of(&mut taxels.iter().copied()).unwrap_or(taxels[0]);
    let touching = strongest_of(&mut taxels.iter().copied().filter(|&taxel| image.object(taxel).is_some()));
    let sum: DVec3 = taxels.iter().map(|&taxel| image.position_world(taxel)).sum();
    Component {
        center_world: sum / taxels.len() as f64,
        strongest,
        region: Region {
            // No patch has nearly 2³² taxels.
            taxels: u32::try_from(taxels.len()).unwrap_or(u32::MAX),
            largest_force_n: image.sensed_force_n(strongest),
            force_sum_n: taxels.iter().map(|&taxel| image.sensed_force_n(taxel)).sum(),
        },
        object: touching.and_then(|taxel| image.object(taxel)),
        touched: taxels.iter().any(|&taxel| image.is_touched(taxel)),
        taxels,
    }
}

/// The contact region of each taxel in contact in the frame last read.
#[derive(Clone, Debug)]
pub(crate) struct Regions {
    grid: Grid,
    of_taxel: Vec<Option<Region>>,
}

impl Regions {
    /// Regions of the patch of an image; `wrap` as in [`super::TrialOptions::wrap`].
    ///
    /// # Errors
    /// [`TrialError::NoGrid`] if the patch has no grid.
    pub(crate) fn new(image: &PatchImage, wrap: Option<bool>) -> Result<Self, TrialError> {
        Ok(Regions { grid: grid(image, wrap)?, of_taxel: vec![None; image.patch().taxels.len()] })
    }

    /// Finds the regions of the frame that the image holds.
    pub(crate) fn find(&mut self, image: &PatchImage) {
        self.of_taxel.fill(None);
        for component in components(image, self.grid) {
            for taxel in component.taxels {
                self.of_taxel[taxel] = Some(component.region);
            }
        }
    }

    /// The region that a taxel is part of; `None` if it is not in contact.
    pub(crate) fn of(&self, taxel: usize) -> Option<Region> {
        self.of_taxel.get(taxel).copied().flatten()
    }
}

/// The neighbours of each taxel of an image's patch in its grid.
///
/// # Errors
/// [`TrialError::NoGrid`] if the patch has no grid.
pub(crate) fn neighbours_of_patch(image: &PatchImage) -> Result<Vec<[Option<usize>; 4]>, TrialError> {
    let grid = grid(image, None)?;
    Ok((0..image.patch().taxels.len()).map(|taxel| grid.neighbours(taxel)).collect())
}

pub(super) fn grid(image: &PatchImage, wrap: Option<bool>) -> Result<Grid, TrialError> {
    let patch = image.patch();
    let no_grid = |found: String| TrialError::NoGrid { patch: patch.name.clone(), found };
    let grid = patch.grid.ok_or_else(|| no_grid("the layout gives none".into()))?;
    if grid.rows.checked_mul(grid.columns) != Some(patch.taxels.len()) {
        return Err(no_grid(format!("{} × {} for {} taxels", grid.rows, grid.columns, patch.taxels.len())));
    }
    Ok(Grid { wraps: wrap.unwrap_or(grid.wraps), ..grid })
}
