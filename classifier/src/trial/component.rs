//! Connected components of the taxels in contact in one frame.

use glam::DVec3;
use underbrush_recording::{Grid, Region};

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
    /// The force of that taxel, N: the feature "maximum force".
    pub(super) force_n: f64,
    /// The sum of the taxels' forces, N.
    pub(super) force_sum_n: f64,
    /// Ground truth: the object of the strongest taxel that has one. Because of crosstalk, a taxel that touches nothing
    /// can also sense a force.
    pub(super) object: Option<u16>,
    /// Ground truth: whether an object presses on any of its taxels.
    pub(super) touched: bool,
}

impl Component {
    /// What a trial stores of the component.
    pub(super) fn region(&self) -> Region {
        Region {
            // No patch has nearly 2³² taxels.
            taxels: u32::try_from(self.taxels.len()).unwrap_or(u32::MAX),
            largest_force_n: self.force_n,
            force_sum_n: self.force_sum_n,
        }
    }
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
        force_n: image.sensed_force_n(strongest),
        force_sum_n: taxels.iter().map(|&taxel| image.sensed_force_n(taxel)).sum(),
        object: touching.and_then(|taxel| image.object(taxel)),
        touched: taxels.iter().any(|&taxel| image.is_touched(taxel)),
        taxels,
    }
}
