//! Trials: what one taxel, or one connected component, felt from contact to break (paper, sections IV-C and IV-D).

mod component;
mod image;
mod region;
mod tracking;
mod travel;

use std::collections::BTreeMap;

use glam::DVec3;
use thiserror::Error;
use underbrush_recording::{Category, ObjectRecord, Recording, Sample, Trial};

pub use image::PatchImage;
pub(crate) use region::Regions;
pub use tracking::component_trials;
pub(crate) use travel::Travel;

/// What gives a trial its category.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Labels {
    /// The object that is the truth in most of its samples; none where nothing touched the skin.
    Contact,
    /// The environment: where the clutter holds one category only (foam blocks aside), every trial is of that category,
    /// also those of taxels that nothing touches. So were the paper's models trained (section IV-B), as a robot does
    /// not know what lies on a taxel. In mixed clutter as [`Labels::Contact`].
    Environment,
}

/// How trials are cut from a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialOptions {
    /// Name of the patch; the skin's first if `None`. The paper classifies on the forearm only, Cody's first patch.
    pub patch: Option<String>,
    /// A taxel is in contact where its sensed force is above this, N. The authors' threshold is not published. 0.03 by
    /// choice: far over the noise (2 mN), and low enough for the touch of a leaf; with it a reach has about as many
    /// trials as the paper's.
    pub threshold_n: f64,
    /// Trials of fewer samples are left out.
    pub min_samples: usize,
    /// Whether the last column of the grid neighbours the first in components; `None`: as the layout says. The authors'
    /// code does not wrap, though their sleeve is closed.
    pub wrap: Option<bool>,
    /// Components of successive frames are the same contact only if their centres are at most this far apart, m.
    ///
    /// 0.025 by choice: sliding from one taxel to its diagonal neighbour moves the centre by 16 mm (pitch 10.8 mm along
    /// and 12 mm around the forearm), the arm moves at most 5 mm between frames (0.5 m/s, 100 Hz), and a component that
    /// gains or loses an edge row shifts by half a pitch; separate objects are mostly farther apart.
    pub association_distance_m: f64,
    /// What gives a trial its category.
    pub labels: Labels,
}

impl Default for TrialOptions {
    fn default() -> Self {
        TrialOptions {
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
    /// Trials as the paper's models are trained on.
    ///
    /// The category is the environment's (section IV-B). Trials have 20 samples (0.2 s) at least: the recipe cuts every
    /// trial into as many equal time slices as a model has states, 20 at most, and a slice needs a sample. The paper does
    /// not say so; but with shorter ones a reach would have several times the trials that it counts.
    pub fn paper() -> Self {
        TrialOptions {
            min_samples: 20,
            labels: Labels::Environment,
            ..TrialOptions::default()
        }
    }
}

/// Why a recording cannot be cut into trials.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TrialError {
    /// No patch of this name.
    #[error("the skin has no patch called {found:?}; it has {known:?}: name one of these")]
    UnknownPatch {
        /// The name asked for.
        found: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// A skin without patches.
    #[error("the skin has no patch, so there is nothing to classify; use an arm with a skin")]
    NoPatch,
    /// Components need a grid.
    #[error(
        "the taxels of patch {patch} form no grid of rows × columns ({found}); cut its trials by taxel, or give its grid"
    )]
    NoGrid {
        /// The patch.
        patch: String,
        /// What there is instead.
        found: String,
    },
    /// An option that makes no sense.
    #[error("{option} is {found}; allowed: {allowed}")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A frame that does not fit the layout or holds NaN or infinity.
    #[error("frame {frame} (from 0): {found}; allowed: {allowed}; mend or drop the recording")]
    BadFrame {
        /// Index of the frame.
        frame: usize,
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
}

/// A trial and the object behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactTrial {
    /// The trial. Its number counts from 0 within the recording, by first frame, then taxel; its category follows
    /// [`TrialOptions::labels`].
    pub trial: Trial,
    /// Index in [`Recording::objects`] of the object that is the truth in most of the trial's samples (the one with the
    /// smaller index in a tie); `None` where no sample has one.
    pub object: Option<u16>,
}

/// One trial per taxel of the patch and period during which its sensed force stays above the threshold (section IV-D).
///
/// Motion is the length of the path of the taxel's centre in the world frame since the trial's first frame.
///
/// # Errors
/// [`TrialError`] where the patch is unknown, an option makes no sense, or a frame does not fit the layout.
pub fn taxel_trials(recording: &Recording, options: &TrialOptions) -> Result<Vec<ContactTrial>, TrialError> {
    let mut image = PatchImage::new(&recording.layout, options.patch.as_deref(), options.threshold_n)?;
    // Regions need neighbours; without a grid trials come without them.
    let mut regions = Regions::new(&image, options.wrap).ok();
    let mut open: Vec<Option<OpenTrial>> = vec![None; image.patch().taxels.len()];
    let mut trials = TrialList::new(recording, options, &image.patch().name);
    for (index, frame) in recording.frames.iter().enumerate() {
        image.read(index, frame)?;
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
            };
            trial.push(sample, image.object(taxel));
        }
    }
    for trial in open {
        trials.close(trial)?;
    }
    Ok(trials.finish())
}

/// The one category of a recording's objects, foam blocks aside; `None` where there are several or none.
fn environment(recording: &Recording) -> Option<Category> {
    let categories = recording.objects.iter().map(|object| object.category);
    let mut categories = categories.filter(|category| *category != Category::BLOCK);
    let first = categories.next()?;
    categories.all(|category| category == first).then_some(first)
}

/// Whether a recording tells what touched the skin. One that lists no objects, as of a real robot, does not.
fn knows_truth(recording: &Recording) -> bool {
    !recording.objects.is_empty()
}

/// A trial still in contact.
#[derive(Clone, Debug)]
struct OpenTrial {
    first_frame: usize,
    taxel: usize,
    travel: Travel,
    samples: Vec<Sample>,
    /// Samples by object.
    votes: BTreeMap<u16, usize>,
}

impl OpenTrial {
    fn new(first_frame: usize, taxel: usize, start_world: DVec3) -> Self {
        OpenTrial {
            first_frame,
            taxel,
            travel: Travel::from(start_world),
            samples: Vec::new(),
            votes: BTreeMap::new(),
        }
    }

    /// Adds a sample, and the object that is its truth.
    fn push(&mut self, sample: Sample, object: Option<u16>) {
        self.samples.push(sample);
        if let Some(object) = object {
            *self.votes.entry(object).or_default() += 1;
        }
    }

    /// The object with most samples, the smallest index in a tie.
    fn object(&self) -> Option<u16> {
        let max = self.votes.values().max()?;
        self.votes
            .iter()
            .find(|(_, count)| *count == max)
            .map(|(object, _)| *object)
    }
}

/// Closed trials on their way into a table.
struct TrialList<'a> {
    recording: &'a Recording,
    options: &'a TrialOptions,
    patch: String,
    /// The category of all trials, where the environment gives it.
    environment: Option<Category>,
    /// With the sort key first frame, taxel.
    closed: Vec<((usize, usize), ContactTrial)>,
}

impl<'a> TrialList<'a> {
    fn new(recording: &'a Recording, options: &'a TrialOptions, patch: &str) -> Self {
        TrialList {
            recording,
            options,
            patch: patch.to_owned(),
            environment: (options.labels == Labels::Environment)
                .then(|| environment(recording))
                .flatten(),
            closed: Vec::new(),
        }
    }

    fn close(&mut self, trial: Option<OpenTrial>) -> Result<(), TrialError> {
        let Some(trial) = trial.filter(|trial| trial.samples.len() >= self.options.min_samples.max(1)) else {
            return Ok(());
        };
        let object = trial.object();
        let record: Option<&ObjectRecord> = match object {
            None => None,
            Some(index) => {
                let objects = &self.recording.objects;
                Some(objects.get(usize::from(index)).ok_or_else(|| TrialError::BadFrame {
                    frame: trial.first_frame,
                    found: format!("object {index} as ground truth in a contact that begins here"),
                    allowed: format!("indices of the recording's {} objects", objects.len()),
                })?)
            }
        };
        let key = (trial.first_frame, trial.taxel);
        let trial = Trial {
            trial: 0,
            category: self
                .environment
                .or(record.map(|record| record.category))
                .map(|category| category.name().to_owned()),
            reach: Some(self.recording.reach_index),
            patch: Some(self.patch.clone()),
            taxel: u32::try_from(trial.taxel).ok(),
            samples: trial.samples,
        };
        self.closed.push((key, ContactTrial { trial, object }));
        Ok(())
    }

    fn finish(mut self) -> Vec<ContactTrial> {
        self.closed.sort_by_key(|(key, _)| *key);
        let mut trials: Vec<ContactTrial> = self.closed.into_iter().map(|(_, trial)| trial).collect();
        trials
            .iter_mut()
            .zip(0..)
            .for_each(|(contact, number)| contact.trial.trial = number);
        trials
    }
}

#[cfg(test)]
pub(crate) mod tests;
