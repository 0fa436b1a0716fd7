//! Verdicts frame by frame.

use std::sync::Arc;

use underbrush_recording::{Frame, SkinLayout};

use super::batch_scores::FeatureRows;
use super::contact_history::{REGION_FEATURE_COUNT, REGION_KNEES};
use super::decision::Touch;
use super::frame::SkinTracker;
use super::model::TouchModel;
use super::taxel::{TAXEL_FEATURE_COUNT, TAXEL_KNEES};
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
    /// The verdict: nothing, or the verdict on its region.
    pub touch: Touch,
}

/// What touches a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionTouch {
    /// Number of the contact. A contact keeps its number while it slides over the skin.
    pub contact: u64,
    /// Samples since the contact began, at least 1.
    pub samples: usize,
    /// Number of its taxels, and number of its taxels that are not called nothing.
    pub taxels: [usize; 2],
    /// The share of contacts with known categories that are as unusual.
    pub share_beyond: f64,
    /// The verdict; nothing if all its taxels are called nothing.
    pub touch: Touch,
}

/// Tells what touches each taxel and each region of a patch, in every frame. Nothing is allocated after the first
/// frames.
#[derive(Clone, Debug)]
pub struct TouchClassifier {
    model: Arc<TouchModel>,
    tracker: SkinTracker,
    taxels: Vec<TaxelTouch>,
    regions: Vec<RegionTouch>,
    /// The features of this frame's regions, and of the taxels of one region after the other.
    region_features: FeatureRows<REGION_FEATURE_COUNT>,
    taxel_features: FeatureRows<TAXEL_FEATURE_COUNT>,
    /// Probabilities of the categories for each region in turn, and of nothing and a touch for each taxel in turn.
    probabilities: Vec<f64>,
    touched: Vec<f64>,
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
            region_features: FeatureRows::with_capacity(count),
            taxel_features: FeatureRows::with_capacity(count),
            probabilities: Vec::with_capacity(count * model.categories().len()),
            touched: Vec::with_capacity(count * 2),
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
        self.region_features.clear();
        self.taxel_features.clear();
        for region in self.tracker.regions() {
            self.region_features.push(&region.course.values());
            for &taxel in self.tracker.taxels(region) {
                if let Some(values) = self.tracker.taxel_values(taxel, region) {
                    self.taxel_features.push(&values);
                }
            }
        }
        self.region_features.compress(&REGION_KNEES);
        self.taxel_features.compress(&TAXEL_KNEES);
        self.model.category.probabilities(&self.region_features, &mut self.probabilities);
        self.model.touched.probabilities(&self.taxel_features, &mut self.touched);
        self.decide();
        Ok(())
    }

    /// From the probabilities of this frame to its verdicts.
    fn decide(&mut self) {
        self.taxels.clear();
        self.regions.clear();
        let model = &self.model;
        let mut touched = self.touched.chunks_exact(2);
        for (index, region) in self.tracker.regions().iter().enumerate() {
            let share_beyond = model.share_beyond(&region.course);
            let of_region = model.decision.of_region(self.probabilities(index), share_beyond);
            let mut touched_taxels = 0;
            for (&taxel, touched) in self.tracker.taxels(region).iter().zip(&mut touched) {
                let nothing = touched[0];
                let is_nothing = nothing > model.decision.nothing_above;
                touched_taxels += usize::from(!is_nothing);
                self.taxels.push(TaxelTouch {
                    taxel,
                    samples: self.tracker.samples(taxel),
                    region: index,
                    nothing,
                    touch: if is_nothing { Touch::Nothing } else { of_region },
                });
            }
            self.regions.push(RegionTouch {
                contact: region.contact,
                samples: region.course.samples(),
                taxels: [self.tracker.taxels(region).len(), touched_taxels],
                share_beyond,
                touch: if touched_taxels == 0 { Touch::Nothing } else { of_region },
            });
        }
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

    /// Probabilities of the known categories for a region, if something touches it, in the order of
    /// [`TouchModel::categories`].
    pub fn probabilities(&self, region: usize) -> &[f64] {
        let count = self.model.categories().len();
        &self.probabilities[region * count..][..count]
    }
}
