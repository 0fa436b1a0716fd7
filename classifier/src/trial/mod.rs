//! Trials: what one taxel, or one connected component of taxels, sensed from the start to the end of a contact (paper,
//! sections IV-C and IV-D).

mod component;
mod image;
mod trial_list;

use serde::{Deserialize, Serialize};
use thiserror::Error;
use trial_list::{OpenTrial, TrialList, knows_truth};
use underbrush_recording::{Recording, Sample, Trial};

use crate::error::ValueFault;

pub use component::component_trials;
pub(crate) use component::{Regions, neighbours_of_patch};
pub use image::PatchImage;
pub(crate) use trial_list::Travel;
pub use trial_list::{ContactTrial, environment};

/// What a trial is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// One taxel from contact to break (paper, section IV-D).
    Taxel,
    /// One connected component of taxels (paper, section IV-C).
    Component,
}

impl Unit {
    /// `taxel` or `component`.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Taxel => "taxel",
            Unit::Component => "component",
        }
    }

    /// What trials are made of, as far as their samples tell: the force of a component is always the largest in its region.
    pub fn of(trials: &[Trial]) -> Option<Self> {
        let mut is_region_larger = false;
        for sample in trials.iter().flat_map(|trial| &trial.samples) {
            let Some(region) = sample.region else { continue };
            if sample.force_n < region.largest_force_n {
                return Some(Unit::Taxel);
            }
            is_region_larger |= region.taxels > 1;
        }
        is_region_larger.then_some(Unit::Component)
    }
}

/// How a trial gets its category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Labels {
    /// From the object that touched the skin during most of its samples; none if nothing did.
    Contact,
    /// From the environment: if the clutter contains a single category other than foam blocks, every trial is of that
    /// category, even where nothing touched the taxel. The paper's models were trained this way (section IV-B), because
    /// a robot does not know what touches a taxel. In mixed clutter this is the same as [`Labels::Contact`].
    Environment,
}

/// How trials are cut from a recording.
///
/// ```
/// use underbrush_classifier::trial::{Labels, TrialOptions, Unit};
///
/// // As the paper's models were trained: trials of 20 samples or more, labelled by their environment.
/// let options = TrialOptions { min_samples: 20, labels: Labels::Environment, ..TrialOptions::default() };
/// assert_eq!((options.by, options.threshold_n), (Unit::Taxel, 0.03));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrialOptions {
    /// What a trial is made of, for callers that cut trials of either unit.
    #[serde(skip_serializing)]
    pub by: Unit,
    /// Name of the patch; the skin's first if `None`. The paper classifies on the forearm only, which is Cody's first
    /// patch.
    pub patch: Option<String>,
    /// A taxel is in contact while its sensed force is above this, N.
    ///
    /// Choice: 0.03 N, because the authors' threshold is not published. It is far above the noise (2 mN) and low enough
    /// for the touch of a leaf, and gives about as many trials per reach as the paper counts.
    pub threshold_n: f64,
    /// Trials with fewer samples are left out.
    pub min_samples: usize,
    /// Whether the first and last column of the grid are neighbours when components are formed; `None` takes it from
    /// the layout. The authors' code does not wrap, although their sleeve is closed.
    pub wrap: Option<bool>,
    /// Components of successive frames belong to the same contact only if their centres are at most this far apart, m.
    ///
    /// Choice: 0.025 m. Sliding from one taxel to its diagonal neighbour moves the centre by 16 mm (pitch 10.8 mm along
    /// and 12 mm around the forearm), the arm moves at most 5 mm between frames (0.5 m/s, 100 Hz), and a component that
    /// gains or loses an edge row shifts by half a pitch; separate objects are usually farther apart.
    #[serde(skip_deserializing)]
    pub association_distance_m: f64,
    /// How a trial gets its category.
    pub labels: Labels,
}

impl Default for TrialOptions {
    fn default() -> Self {
        TrialOptions {
            by: Unit::Taxel,
            patch: None,
            threshold_n: 0.03,
            min_samples: 1,
            wrap: None,
            association_distance_m: 0.025,
            labels: Labels::Contact,
        }
    }
}

impl TrialOptions {
    /// Trials like those on which the paper's models were trained.
    ///
    /// The category is the environment's (section IV-B). Trials have at least 20 samples (0.2 s): the recipe divides
    /// every trial into as many equal time slices as a model has states, up to 20, and a slice needs at least one
    /// sample. The paper does not state this, but with shorter trials a reach would have several times as many trials
    /// as the paper counts.
    pub fn paper() -> Self {
        TrialOptions { min_samples: 20, labels: Labels::Environment, ..TrialOptions::default() }
    }
}

/// Why a recording cannot be cut into trials.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrialError {
    /// There is no patch with this name.
    #[error("the skin has no patch named {found:?}; choose one of {}", known.join(", "))]
    UnknownPatch {
        /// The name requested.
        found: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// A recording that lists neither objects nor bodies, as one of a real robot: every reading would count as spurious.
    #[error("reach {reach} of {scene} lists neither objects nor bodies, so it has no ground truth; leave it out")]
    NoTruth {
        /// The index of the reach.
        reach: u64,
        /// The scene.
        scene: String,
    },
    /// The skin has no patches.
    #[error("the skin has no patch, so there is nothing to classify; use an arm with a skin")]
    NoPatch,
    /// Components need a grid.
    #[error(
        "the taxels of patch {patch} do not form a grid of rows × columns ({found}); use trials by taxel, or add the grid to \
         the layout"
    )]
    NoGrid {
        /// The patch.
        patch: String,
        /// What was found instead.
        found: String,
    },
    /// An option is out of range.
    #[error(transparent)]
    BadOption(#[from] ValueFault),
    /// A frame does not fit the layout, or contains NaN or infinity.
    #[error("frame {frame} (counted from 0): {found}; allowed: {allowed}; repair or drop the recording")]
    BadFrame {
        /// Index of the frame.
        frame: usize,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
}

/// Refuses a recording without ground truth.
///
/// # Errors
/// [`TrialError::NoTruth`].
pub(crate) fn require_truth(recording: &Recording) -> Result<(), TrialError> {
    if !knows_truth(recording) {
        return Err(TrialError::NoTruth { reach: recording.reach_index, scene: recording.scene.clone() });
    }
    Ok(())
}

/// One trial for each period during which the sensed force of a taxel stays above the threshold (section IV-D).
///
/// Motion is the length of the path of the taxel's centre in the world frame since the first frame of the trial.
///
/// # Errors
/// [`TrialError`] if the patch is unknown, an option is out of range, or a frame does not fit the layout.
pub fn taxel_trials(recording: &Recording, options: &TrialOptions) -> Result<Vec<ContactTrial>, TrialError> {
    let mut image = PatchImage::new(&recording.layout, options.patch.as_deref(), options.threshold_n)?;
    // Regions need neighbours; without a grid, samples have no region.
    let mut regions = Regions::new(&image, options.wrap).ok();
    let mut open: Vec<Option<OpenTrial>> = vec![None; image.patch().taxels.len()];
    let mut trials = TrialList::new(recording, options, &image.patch().name);
    for (index, frame) in recording.frames.iter().enumerate() {
        image.read(frame)?;
        if let Some(regions) = &mut regions {
            regions.find(&image);
        }
        for (taxel, slot) in open.iter_mut().enumerate() {
            if !image.is_in_contact(taxel) {
                trials.close(slot.take())?;
                continue;
            }
            let position_world = image.position_world(taxel);
            let trial = slot.get_or_insert_with(|| OpenTrial::new(index, taxel, position_world));
            let sample = Sample {
                time_s: frame.time_s,
                force_n: image.sensed_force_n(taxel),
                motion_m: Some(trial.travel.to(position_world)),
                region: regions.as_ref().and_then(|regions| regions.of(taxel)),
                touched: knows_truth(recording).then(|| image.is_touched(taxel)),
                ..Sample::default()
            };
            trial.push(sample, image.object(taxel));
        }
    }
    trials.finish(open)
}

#[cfg(test)]
pub(crate) mod tests;
