//! Verdicts frame by frame.

use std::iter;
use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::{Frame, SkinLayout, math};

use super::batch_scores::FeatureRows;
use super::contact_history::{Course, REGION_FEATURE_COUNT};
use super::decision::TouchVerdict;
use super::frame::{SkinTracker, TAXEL_FEATURE_COUNT, TaxelCourse};
use super::model::TouchModel;
use super::network::softmax;
use super::object::{Mobility, OBJECT_FEATURE_COUNT, ObjectTracker, Stiffness, TouchObject, stage};
use crate::frequency::largest;
use crate::trial::TrialError;

/// What touches a taxel in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelTouch {
    /// Index of its patch in the skin.
    pub patch: usize,
    /// Index of the taxel in its patch.
    pub taxel: usize,
    /// Samples since its contact began, at least 1.
    pub samples: usize,
    /// The region that it belongs to: an index in [`TouchClassifier::regions`].
    pub region: usize,
    /// Probability that nothing presses on it.
    pub nothing: f64,
    /// The verdict: nothing, or the verdict on its region.
    pub touch: TouchVerdict,
}

/// What touches a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionTouch {
    /// Index of its patch in the skin.
    pub patch: usize,
    /// Number of the contact on this patch. A contact keeps its number while it slides over the skin.
    pub contact: u64,
    /// Number of the object that it belongs to; `None` while it is as weak as a spurious reading.
    pub object: Option<u64>,
    /// Samples since the contact began, at least 1.
    pub samples: usize,
    /// Number of its taxels, and number of its taxels that are not called nothing.
    pub taxels: [usize; 2],
    /// [`ObjectTouch::share_beyond`] of its object; 1 without one.
    pub share_beyond: f64,
    /// The verdict: nothing if all its taxels are called nothing; otherwise unknown if its object is, or else what its
    /// probabilities say.
    pub touch: TouchVerdict,
}

/// What an object is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectTouch {
    /// Number of the object in its reach, from 1.
    pub object: u64,
    /// Number of samples in which it was felt well enough to be judged, see [`ObjectTracker`].
    pub samples: usize,
    /// Number of frames in which it touched the skin.
    pub frames: usize,
    /// The share of known objects that are as unlike all known categories, see [`super::UnknownObjects`]; 1 before it is
    /// judged, or if the model was trained without auxiliary sets.
    pub share_beyond: f64,
    /// Its stiffness where it was touched when its force was largest, as trees learnt it; `None` before it was touched, or if
    /// the model lacks such trees.
    pub learnt_stiffness: Option<Stiffness>,
    /// Index of the likeliest known category.
    pub likeliest: usize,
    /// Probability of this category, if the object is of a known one.
    pub probability: f64,
    /// The verdict.
    pub touch: TouchVerdict,
}

impl ObjectTouch {
    /// The stiffness of this object, which was felt like this: as trees learnt it, or else as it follows from the path of its
    /// contacts. `None` before it was touched.
    pub fn stiffness(&self, felt: &TouchObject) -> Option<Stiffness> {
        self.learnt_stiffness.or_else(|| felt.course.stiffness())
    }
}

/// All that is known of an object, for other programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectReport<'a> {
    /// Number of the object in its reach, from 1.
    pub object: u64,
    /// Samples in which it was felt well enough to be judged.
    pub samples: usize,
    /// The verdict: a category, `uncertain` or `unknown`.
    pub verdict: &'a str,
    /// See [`ObjectTouch::share_beyond`].
    pub share_beyond: f64,
    /// Its stiffness where it was touched; left out until it is judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<Stiffness>,
    /// How far it is from where it was first felt, horizontally, m.
    pub moved_m: f64,
    /// What it has done so far under the push.
    pub mobility: Mobility,
}

/// Tells what touches each taxel, each region and each object, in every frame. Nothing is allocated after the first
/// frames.
#[derive(Clone, Debug)]
pub struct TouchClassifier {
    model: Arc<TouchModel>,
    patches: Vec<SkinTracker>,
    pub(crate) tracker: ObjectTracker,
    taxels: Vec<TaxelTouch>,
    regions: Vec<RegionTouch>,
    /// In the order of the tracker's objects.
    objects: Vec<ObjectTouch>,
    /// For each object in turn, the sums of the network's log-probabilities of the categories, weighted by force; and these
    /// weights.
    evidence: Vec<f64>,
    weights_n: Vec<f64>,
    /// For each object in turn, the log-probabilities of the categories by its own trees; all the same without trees.
    by_trees: Vec<f64>,
    /// The features of this frame's regions, and of the taxels of one region after the other.
    region_features: FeatureRows<REGION_FEATURE_COUNT>,
    taxel_features: FeatureRows<TAXEL_FEATURE_COUNT>,
    /// Probabilities of the categories for each region in turn, and of nothing and a touch for each taxel in turn.
    probabilities: Vec<f64>,
    touched: Vec<f64>,
}

/// An object is judged in each of its first frames, at the beginning of a stage, and in every frame whose number is a multiple of
/// this: the verdict changes little in between.
const JUDGED_EVERY: usize = 5;
/// The share of an object's trees in the logarithms of its probabilities; the rest is the network's, which judges contacts.
/// Choice: a logistic regression on the training seed 5000 gives 0.73 and 0.30 (scikit-learn's boosted trees, cross-validated).
const TREES_SHARE: f64 = 0.7;
/// The share of a contact's own evidence in the logarithms of its probabilities; the rest is its object's. Contacts with a leaf and with
/// the trunk behind it may be joined to one object. Choice: a logistic regression on the development seed 6000 gives 0.59 and 0.44.
const CONTACT_SHARE: f64 = 0.5;
/// The smallest probability whose logarithm counts.
const LEAST_PROBABILITY: f64 = 1e-6;

impl TouchClassifier {
    /// A classifier for a stream of frames of this skin, without contacts so far.
    ///
    /// # Errors
    /// [`TrialError`] if the skin lacks the model's patch.
    pub fn new(model: Arc<TouchModel>, layout: &SkinLayout) -> Result<Self, TrialError> {
        let patches = SkinTracker::of_patches(layout, model.options())?;
        let count = patches.iter().map(|tracker| tracker.image.patch().taxels.len()).sum();
        Ok(TouchClassifier {
            taxels: Vec::with_capacity(count),
            regions: Vec::with_capacity(count),
            objects: Vec::with_capacity(count),
            evidence: Vec::with_capacity(count * model.categories().len()),
            weights_n: Vec::with_capacity(count),
            by_trees: Vec::with_capacity(count * model.categories().len()),
            region_features: FeatureRows::with_capacity(count),
            taxel_features: FeatureRows::with_capacity(count),
            probabilities: Vec::with_capacity(count * model.categories().len()),
            touched: Vec::with_capacity(count * 2),
            tracker: ObjectTracker::default(),
            patches,
            model,
        })
    }

    /// Takes in the next frame and judges it.
    ///
    /// # Errors
    /// [`TrialError::BadFrame`] if the frame does not fit the skin or holds NaN or infinity.
    pub fn update(&mut self, frame: &Frame) -> Result<(), TrialError> {
        self.region_features.clear();
        self.taxel_features.clear();
        for tracker in &mut self.patches {
            tracker.update(frame)?;
            for region in tracker.regions() {
                self.region_features.push(&region.course.values());
                for &taxel in tracker.taxels(region) {
                    if let Some(values) = tracker.taxel_values(taxel, region) {
                        self.taxel_features.push(&values);
                    }
                }
            }
        }
        self.tracker.update(&self.patches, frame.time_s);
        self.region_features.compress(&Course::KNEES);
        self.taxel_features.compress(&TaxelCourse::KNEES);
        self.model.category.probabilities(&self.region_features, &mut self.probabilities);
        self.model.touched.probabilities(&self.taxel_features, &mut self.touched);
        self.judge_objects();
        self.decide();
        Ok(())
    }

    /// The verdicts on the objects of this frame.
    fn judge_objects(&mut self) {
        let count = self.model.categories().len();
        self.keep_objects(count);
        let regions = self.patches.iter().flat_map(SkinTracker::regions);
        let probabilities = self.probabilities.chunks_exact_mut(count);
        for ((region, object), probabilities) in regions.zip(&self.tracker.of_region).zip(probabilities) {
            let Some(object) = *object else { continue };
            let force_n = region.course.now.force_n;
            self.weights_n[object] += force_n;
            for (sum, probability) in self.evidence[object * count..][..count].iter_mut().zip(probabilities) {
                // Its logarithm stands here until the object is judged.
                *probability = math::ln(probability.max(LEAST_PROBABILITY));
                *sum += force_n * *probability;
            }
        }
        for (index, (own, object)) in self.objects.iter_mut().zip(&self.tracker.objects).enumerate() {
            let (course, places) = (&object.course, index * count..(index + 1) * count);
            let is_due = course.frames() <= JUDGED_EVERY
                || course.frames().is_multiple_of(JUDGED_EVERY)
                || stage(course.samples()) != stage(own.samples);
            let categories = self.model.of_objects.as_ref().filter(|_| is_due);
            let unknown = self.model.unknown.as_ref().filter(|_| is_due);
            let stiffness = self.model.stiffness.as_ref().filter(|_| course.is_at_largest_force());
            let needs_features = categories.is_some() || unknown.is_some() || stiffness.is_some();
            if course.frames() != own.frames && needs_features {
                let features: [f32; OBJECT_FEATURE_COUNT] = course.features();
                if let Some(trees) = stiffness {
                    own.learnt_stiffness = Some(trees.of(&features));
                }
                if let Some(categories) = categories {
                    let own = &mut self.by_trees[places.clone()];
                    categories.probabilities(&features, own);
                    own.iter_mut().for_each(|own| *own = math::ln(own.max(LEAST_PROBABILITY)));
                }
                if let Some(unknown) = unknown.filter(|_| object.is_judged()) {
                    own.share_beyond = unknown.share_beyond(&features, course.samples());
                }
            }
            (own.frames, own.samples) = (course.frames(), course.samples());
            // The sums of evidence stay; the decision needs the likeliest category and its probability.
            let weight_n = self.weights_n[index].max(f64::MIN_POSITIVE);
            let scores =
                || score(&self.evidence[places.clone()], weight_n, &self.by_trees[places.clone()], &self.model);
            let best = largest(scores().enumerate()).unwrap_or((0, 0.0));
            let others = scores().map(|score| math::exp(score - best.1)).sum::<f64>();
            (own.likeliest, own.probability) = (best.0, 1.0 / others);
            own.touch = self.model.decision.of(own.likeliest, own.probability, own.share_beyond, own.samples);
        }
        self.probabilities_of_objects(count);
    }

    /// Gives each region that belongs to an object the geometric mean of its own probabilities and of its object's.
    fn probabilities_of_objects(&mut self, count: usize) {
        for (object, probabilities) in self.tracker.of_region.iter().zip(self.probabilities.chunks_exact_mut(count)) {
            let Some(object) = *object else { continue };
            let weight_n = self.weights_n[object].max(f64::MIN_POSITIVE);
            let [evidence, by_trees] = [&self.evidence, &self.by_trees].map(|own| &own[object * count..][..count]);
            for (probability, score) in probabilities.iter_mut().zip(score(evidence, weight_n, by_trees, &self.model)) {
                *probability = CONTACT_SHARE * *probability + (1.0 - CONTACT_SHARE) * score;
            }
            softmax(probabilities);
        }
    }

    /// Makes the lists of objects those of the tracker, which forgets some and appends new ones.
    fn keep_objects(&mut self, count: usize) {
        for ended in &self.tracker.ended {
            if let Some(index) = self.objects.iter().position(|own| own.object == ended.number) {
                self.objects.remove(index);
                self.weights_n.remove(index);
                for own in [&mut self.evidence, &mut self.by_trees] {
                    own.drain(index * count..(index + 1) * count);
                }
            }
        }
        for object in &self.tracker.objects[self.objects.len()..] {
            self.objects.push(ObjectTouch {
                object: object.number,
                samples: 0,
                frames: 0,
                share_beyond: 1.0,
                learnt_stiffness: None,
                likeliest: 0,
                probability: 1.0 / count as f64,
                touch: TouchVerdict::Uncertain,
            });
            self.weights_n.push(0.0);
            self.evidence.extend(iter::repeat_n(0.0, count));
            self.by_trees.extend(iter::repeat_n(math::ln(1.0 / count as f64), count));
        }
    }

    /// From the probabilities of this frame to its verdicts.
    fn decide(&mut self) {
        self.taxels.clear();
        self.regions.clear();
        let decision = &self.model.decision;
        let mut touched = self.touched.chunks_exact(2);
        let mut of_region = self.tracker.of_region.iter();
        for tracker in &self.patches {
            let patch = tracker.image.patch_index();
            for region in tracker.regions() {
                let index = self.regions.len();
                let object = of_region.next().copied().flatten().map(|object| self.objects[object]);
                let (share_beyond, samples) = object.map_or((1.0, 0), |object| (object.share_beyond, object.samples));
                let verdict = decision.of_region(self.probabilities(index), share_beyond, samples);
                let mut touched_taxels = 0;
                for (&taxel, touched) in tracker.taxels(region).iter().zip(&mut touched) {
                    let nothing = touched[0];
                    let is_nothing = nothing > decision.nothing_above;
                    touched_taxels += usize::from(!is_nothing);
                    self.taxels.push(TaxelTouch {
                        patch,
                        taxel,
                        samples: tracker.samples(taxel),
                        region: index,
                        nothing,
                        touch: if is_nothing { TouchVerdict::Nothing } else { verdict },
                    });
                }
                self.regions.push(RegionTouch {
                    patch,
                    contact: region.contact,
                    object: object.map(|object| object.object),
                    samples: region.course.samples(),
                    taxels: [tracker.taxels(region).len(), touched_taxels],
                    share_beyond,
                    touch: if touched_taxels == 0 { TouchVerdict::Nothing } else { verdict },
                });
            }
        }
    }

    /// The model.
    pub fn model(&self) -> &TouchModel {
        &self.model
    }

    /// Regions and taxels of each patch that the model judges, as the classifier sees them in the last frame.
    pub fn patches(&self) -> &[SkinTracker] {
        &self.patches
    }

    /// The taxels in contact in the last frame, patch by patch and region by region.
    pub fn taxels(&self) -> &[TaxelTouch] {
        &self.taxels
    }

    /// The regions of the last frame, patch by patch.
    pub fn regions(&self) -> &[RegionTouch] {
        &self.regions
    }

    /// The objects that touch the skin, or did so in the last thirty seconds, in the order of
    /// [`ObjectTracker::objects`]. The verdict on one that no longer touches the skin stands.
    pub fn objects(&self) -> &[ObjectTouch] {
        &self.objects
    }

    /// All that is known of each object, in the order of [`TouchClassifier::objects`].
    pub fn object_reports(&self) -> impl Iterator<Item = ObjectReport<'_>> {
        self.objects.iter().zip(&self.tracker.objects).map(|(own, felt)| ObjectReport {
            object: own.object,
            samples: own.samples,
            verdict: own.touch.name(self.model.categories()),
            share_beyond: own.share_beyond,
            stiffness: own.stiffness(felt).filter(|_| felt.is_judged()),
            moved_m: felt.course.moved_m(),
            mobility: felt.course.mobility(),
        })
    }

    /// Probabilities of the known categories for a region, if something known touches it, in the order of
    /// [`TouchModel::categories`]: from the contact itself, and from its object if it belongs to one.
    pub fn probabilities(&self, region: usize) -> &[f64] {
        let count = self.model.categories().len();
        &self.probabilities[region * count..][..count]
    }
}

/// The logarithms of an object's probabilities, but for a constant: the mean of the network's, and those of its own trees.
fn score<'a>(
    evidence: &'a [f64],
    weight_n: f64,
    by_trees: &'a [f64],
    model: &TouchModel,
) -> impl Iterator<Item = f64> + use<'a> {
    let share = if model.of_objects.is_some() { TREES_SHARE } else { 0.0 };
    evidence.iter().zip(by_trees).map(move |(sum, own)| (1.0 - share) * sum / weight_n + share * own)
}
