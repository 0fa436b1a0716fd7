//! The contact region around each taxel of a patch.

use underbrush_recording::{Grid, Region};

use super::TrialError;
use super::component::components;
use super::image::PatchImage;
use super::tracking::grid;

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
            let region = component.region();
            for taxel in component.taxels {
                self.of_taxel[taxel] = Some(region);
            }
        }
    }

    /// The region that a taxel is part of; `None` if it is not in contact.
    pub(crate) fn of(&self, taxel: usize) -> Option<Region> {
        self.of_taxel.get(taxel).copied().flatten()
    }
}
