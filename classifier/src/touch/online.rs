//! Verdicts frame by frame.

use std::sync::Arc;

use underbrush_recording::{Frame, SkinLayout};

use super::decision::Touch;
use super::frame::SkinTracker;
use super::model::TouchModel;
use crate::trial::TrialError;

/// What touches a taxel in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelTouch {
    /// Index of the taxel in its patch.
    pub taxel: usize,
    /// Samples since its contact began, at least 1.
    pub samples: usize,
    /// The region that it belongs to: an index in [`TouchClassifier::regions`].
    pub region: usize,
    /// Probability that nothing presses on it.
    pub nothing: f64,
    /// The verdict: nothing, or that of its region.
    pub touch: Touch,
}

/// What touches a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionTouch {
    /// Number of the contact. A contact keeps its number while it slides over the skin.
    pub contact: u64,
    /// Samples since the contact began, at least 1.
    pub samples: usize,
    /// Number of its taxels, and of those that are not called nothing.
    pub taxels: [usize; 2],
    /// The share of contacts with known categories that are as unusual.
    pub share_beyond: f64,
    /// The verdict; nothing if all its taxels are called so.
    pub touch: Touch,
}

/// Tells what touches each taxel and each region of a patch, in every frame. Nothing is allocated after the first frames.
#[derive(Clone, Debug)]
pub struct TouchClassifier {
    model: Arc<TouchModel>,
    tracker: SkinTracker,
    taxels: Vec<TaxelTouch>,
    regions: Vec<RegionTouch>,
    /// Of each region in turn.
    probabilities: Vec<f64>,
}

impl TouchClassifier {
    /// A classifier for a stream of frames of this skin, without contacts so far.
    ///
    /// # Errors
    /// [`TrialError`] if the skin lacks the model's patch, or the patch has no grid.
    pub fn new(model: Arc<TouchModel>, layout: &SkinLayout) -> Result<Self, TrialError> {
        let options = model.options();
        let tracker = SkinTracker::new(layout, options.patch.as_deref(), options.threshold_n)?;
        let count = tracker.image().patch().taxels.len();
        Ok(TouchClassifier {
            taxels: Vec::with_capacity(count),
            regions: Vec::with_capacity(count),
            probabilities: Vec::with_capacity(count * model.categories().len()),
            tracker,
            model,
        })
    }

    /// Takes in the next frame and judges it.
    ///
    /// # Errors
    /// [`TrialError::BadFrame`] if the frame does not fit the skin or holds NaN or infinity.
    pub fn update(&mut self, frame: &Frame) -> Result<(), TrialError> {
        self.tracker.update(frame)?;
        let TouchClassifier {
            model,
            tracker,
            taxels,
            regions,
            probabilities,
        } = self;
        taxels.clear();
        regions.clear();
        probabilities.clear();
        for (index, region) in tracker.regions().iter().enumerate() {
            let first = probabilities.len();
            probabilities.resize(first + model.categories().len(), 0.0);
            let share_beyond = model.region(&region.course, &mut probabilities[first..]);
            let of_region = model.decision.of_region(&probabilities[first..], share_beyond);
            let mut touched = 0;
            for &taxel in tracker.taxels(region) {
                let Some(features) = tracker.taxel_features(taxel, region) else {
                    continue;
                };
                let nothing = model.nothing(&features);
                let is_nothing = nothing > model.decision.nothing_above;
                touched += usize::from(!is_nothing);
                taxels.push(TaxelTouch {
                    taxel,
                    samples: tracker.samples(taxel),
                    region: index,
                    nothing,
                    touch: if is_nothing { Touch::Nothing } else { of_region },
                });
            }
            regions.push(RegionTouch {
                contact: region.contact,
                samples: region.course.samples(),
                taxels: [tracker.taxels(region).len(), touched],
                share_beyond,
                touch: if touched == 0 { Touch::Nothing } else { of_region },
            });
        }
        Ok(())
    }

    /// The model.
    pub fn model(&self) -> &TouchModel {
        &self.model
    }

    /// Regions and taxels as the classifier sees them in the last frame.
    pub fn tracker(&self) -> &SkinTracker {
        &self.tracker
    }

    /// The taxels in contact in the last frame, region by region.
    pub fn taxels(&self) -> &[TaxelTouch] {
        &self.taxels
    }

    /// The regions of the last frame.
    pub fn regions(&self) -> &[RegionTouch] {
        &self.regions
    }

    /// Probabilities of the known categories for a region, if something touches it, in the order of [`TouchModel::categories`].
    pub fn probabilities(&self, region: usize) -> &[f64] {
        let count = self.model.categories().len();
        &self.probabilities[region * count..][..count]
    }
}
