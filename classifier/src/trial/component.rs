//! Connected components of the taxels in contact, the contact region around each taxel, and how components are tracked from
//! frame to frame.

use glam::DVec3;
use underbrush_recording::{Grid, Recording, Region, Sample};

use super::image::PatchImage;
use super::trial_list::{ContactTrial, OpenTrial, TrialList, knows_truth};
use super::{TrialError, TrialOptions};
use crate::error::ValueFault;

/// One contact region of one frame.
#[derive(Clone, Debug, PartialEq)]
struct Component {
    /// Its taxels in ascending order.
    taxels: Vec<usize>,
    /// Unweighted mean of the taxels' centres, m, world frame (as in the authors' code; paper, section IV-C).
    center_world: DVec3,
    /// The taxel with the largest sensed force, the first in a tie.
    strongest: usize,
    /// What a trial stores of it.
    region: Region,
    /// Ground truth: the object of the strongest taxel that has one. Because of crosstalk, a taxel that touches nothing
    /// can also sense a force.
    object: Option<u16>,
    /// Ground truth: whether an object presses on any of its taxels.
    touched: bool,
}

/// The 4-connected regions of taxels in contact, ordered by first taxel.
///
/// The grid must have as many cells as the patch has taxels; `grid.wraps` makes the first and last column neighbours.
fn components(image: &PatchImage, grid: Grid) -> Vec<Component> {
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
    /// Regions of the patch of an image; `wrap` as in [`TrialOptions::wrap`].
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

fn grid(image: &PatchImage, wrap: Option<bool>) -> Result<Grid, TrialError> {
    let patch = image.patch();
    let no_grid = |found: String| TrialError::NoGrid { patch: patch.name.clone(), found };
    let grid = patch.grid.ok_or_else(|| no_grid("the layout gives none".into()))?;
    if grid.rows.checked_mul(grid.columns) != Some(patch.taxels.len()) {
        return Err(no_grid(format!("{} × {} for {} taxels", grid.rows, grid.columns, patch.taxels.len())));
    }
    Ok(Grid { wraps: wrap.unwrap_or(grid.wraps), ..grid })
}

/// One trial for each connected component, tracked from the start to the end of its contact (section IV-C).
///
/// Force is the largest force among the component's taxels in each frame. Motion is the length of the path of its
/// centre in the world frame since the trial started.
///
/// Components are associated with those of the previous frame by the distance between their centres in the world frame:
/// nearest pair first, each used once, and none farther apart than [`TrialOptions::association_distance_m`]. Hence:
/// * If two components merge, the one with the nearer centre continues and the other's trial ends.
/// * If a component splits, the part nearer to the old centre continues and the other starts a new trial.
/// * If a component moves farther than this limit between frames, its trial ends and a new one starts.
///
/// # Errors
/// [`TrialError`] as for [`super::taxel_trials`], and if the patch has no grid.
pub fn component_trials(recording: &Recording, options: &TrialOptions) -> Result<Vec<ContactTrial>, TrialError> {
    let reach = options.association_distance_m;
    if !reach.is_finite() || reach < 0.0 {
        let allowed = "a finite distance from 0 m";
        return Err(ValueFault::new("association_distance_m", reach.to_string(), allowed).into());
    }
    let mut image = PatchImage::new(&recording.layout, options.patch.as_deref(), options.threshold_n)?;
    let grid = grid(&image, options.wrap)?;
    let mut open: Vec<OpenTrial> = Vec::new();
    let mut trials = TrialList::new(recording, options, &image.patch().name);
    for (index, frame) in recording.frames.iter().enumerate() {
        image.read(frame)?;
        let found = components(&image, grid);
        let followed = associate(&open, &found, reach);
        let mut before: Vec<Option<OpenTrial>> = open.into_iter().map(Some).collect();
        open = Vec::with_capacity(found.len());
        for (component, followed) in found.iter().zip(followed) {
            let center_world = component.center_world;
            let continued = followed.and_then(|trial| before[trial].take());
            let mut trial = continued.unwrap_or_else(|| OpenTrial::new(index, component.strongest, center_world));
            let sample = Sample {
                time_s: frame.time_s,
                force_n: component.region.largest_force_n,
                motion_m: Some(trial.travel.to(center_world)),
                region: Some(component.region),
                touched: knows_truth(recording).then_some(component.touched),
                ..Sample::default()
            };
            trial.push(sample, component.object);
            open.push(trial);
        }
        before.into_iter().try_for_each(|ended| trials.close(ended))?;
    }
    trials.finish(open.into_iter().map(Some))
}

/// The trial that each component continues. Ties go to the trial, then the component, with the smaller index.
fn associate(open: &[OpenTrial], found: &[Component], reach_m: f64) -> Vec<Option<usize>> {
    let mut pairs = Vec::new();
    for (t, trial) in open.iter().enumerate() {
        for (c, component) in found.iter().enumerate() {
            let distance = trial.travel.last_world.distance(component.center_world);
            if distance <= reach_m {
                pairs.push((distance, t, c));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut used = vec![false; open.len()];
    let mut followed = vec![None; found.len()];
    for (_, t, c) in pairs {
        if !used[t] && followed[c].is_none() {
            used[t] = true;
            followed[c] = Some(t);
        }
    }
    followed
}
