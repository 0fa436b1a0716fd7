//! Classification while the arm moves: each new frame gives a verdict for every taxel in contact.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use thiserror::Error;
use underbrush_recording::{Frame, Sample, SkinLayout};

use crate::decision::{Decision, DecisionError, Judge, Verdict};
use crate::error::ModelError;
use crate::estimator::{Classifier, OnlineScorer};
use crate::feature::{MOTION, SampleFault};
use crate::trial::{PatchImage, Regions, Travel, TrialError, TrialOptions};

/// Why online classification stops.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OnlineError {
    /// A skin or frame that does not fit.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// Priors or thresholds that do not fit the classifier.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// A classifier that fails while it scores.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A sample that cannot be used.
    #[error("taxel {taxel} {fault}")]
    BadSample {
        /// Index of the taxel in its patch.
        taxel: usize,
        /// What is wrong.
        fault: SampleFault,
    },
    /// The classifier needs the contact region, and the taxels form no grid.
    #[error(
        "the feature {feature} needs the contact region, but the taxels of patch {patch} form no grid of rows × columns; \
         give its grid, or use a model without {feature}"
    )]
    NoRegion {
        /// Name of the feature.
        feature: &'static str,
        /// The patch.
        patch: String,
    },
    /// The feature of this name is a channel, which frames do not have.
    #[error("{0} is a column of a table of trials, and frames have none; use a model without {0}")]
    NoChannel(&'static str),
}

/// Which taxels are classified, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct OnlineOptions {
    /// Name of the patch; the skin's first if `None`.
    pub patch: Option<String>,
    /// A taxel is in contact while its sensed force is above this, N.
    pub threshold_n: f64,
    /// From scores to verdicts.
    pub decision: Decision,
}

impl OnlineOptions {
    /// These options, with the threshold of [`TrialOptions::default`] unless one is given.
    pub fn new(patch: Option<String>, threshold_n: Option<f64>, decision: Decision) -> Self {
        let threshold_n = threshold_n.unwrap_or(TrialOptions::default().threshold_n);
        OnlineOptions { patch, threshold_n, decision }
    }

    /// The patch whose pose a classifier needs in every frame of this skin; `None` if it does not use motion.
    pub fn needs_pose_of(&self, classifier: &dyn Classifier, layout: &SkinLayout) -> Option<usize> {
        layout.chosen_patch(self.patch.as_deref()).filter(|_| classifier.features().contains(&MOTION))
    }
}

/// The verdict on one taxel in contact at the moment.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelVerdict {
    /// Index of the taxel in its patch.
    pub taxel: usize,
    /// Samples since its contact began, at least 1. After the samples that the classifier uses, the scores stay the
    /// same.
    pub samples: usize,
    /// Score of each category, nats, in the order of [`Classifier::categories`]; without priors.
    pub scores: Vec<f64>,
    /// The verdict from the samples so far.
    pub verdict: Verdict,
}

/// Scores each taxel of a patch from the start of its contact to its end (paper, section V-B), by any classifier.
///
/// After k samples of a contact its scores equal [`Classifier::scores_after`] k samples of the same trial, bit for bit.
/// With hidden Markov models nothing is allocated after the first frame, except for contact regions if a feature describes
/// them.
///
/// ```
/// use glam::DVec3;
/// use underbrush_classifier::baseline::NaiveBayes;
/// use underbrush_classifier::decision::Decision;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_classifier::feature::FeatureSet;
/// use underbrush_classifier::online::{OnlineClassifier, OnlineOptions};
/// use underbrush_recording::{Frame, Patch, Sample, SkinLayout, Taxel, TaxelReading, Trial};
///
/// // A classifier of forces: leaves press with 0.2 N, trunks with 4 N, and a little more each time.
/// let press = |category: &str, force_n: f64, k: u64| {
///     let sample = |t: u32| Sample {
///         time_s: 0.01 * f64::from(t),
///         force_n: force_n + 0.01 * (k as f64 + f64::from(t)),
///         ..Sample::default()
///     };
///     Trial { trial: k, category: Some(category.into()), samples: (0..20).map(sample).collect(), ..Trial::default() }
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.2, k), press("trunk", 4.0, k)]).collect();
/// let classifier = NaiveBayes { features: FeatureSet::FORCE, ..NaiveBayes::default() }.fit(&trials.iter().collect::<Vec<_>>())?;
///
/// // A skin of one taxel, and a frame in which it senses 3 N.
/// let taxel = Taxel { position_link: DVec3::ZERO, normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1e-4 };
/// let patch = Patch { name: "palm".into(), link: "hand".into(), grid: None, taxels: vec![taxel] };
/// let layout = SkinLayout { patches: vec![patch] };
/// let options = OnlineOptions::new(None, None, Decision::argmax());
/// let mut online = OnlineClassifier::new(classifier.as_ref(), &layout, &options)?;
/// let reading = TaxelReading { sensed_force_n: 4.1, ..TaxelReading::default() };
/// let pressed = Frame { taxels: vec![reading], ..Frame::blank(1) };
/// let names: Vec<String> = online.update(&pressed)?.map(|own| own.verdict.name().to_owned()).collect();
/// assert_eq!(names, ["trunk"]);
/// // The contact has ended.
/// assert_eq!(online.update(&Frame { time_s: 0.01, ..Frame::blank(1) })?.count(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct OnlineClassifier {
    scorer: Box<dyn OnlineScorer>,
    judge: Judge,
    image: PatchImage,
    /// Only if a feature describes the contact region.
    regions: Option<Regions>,
    /// Numbers of free contacts in the scorer. The smallest is used first, so that those in use are next to each other.
    free: BinaryHeap<Reverse<usize>>,
    /// One per taxel.
    contacts: Vec<Contact>,
}

/// The state of a taxel.
#[derive(Clone, Debug)]
struct Contact {
    /// Number of its contact in the scorer, if it is in contact.
    slot: Option<usize>,
    travel: Travel,
    /// Whether the sample of the current frame can change the scores.
    scored: bool,
    verdict: TaxelVerdict,
}

impl OnlineClassifier {
    /// A classifier for a stream of frames of this skin, without contacts so far.
    ///
    /// # Errors
    /// [`OnlineError`] if the patch is unknown, the threshold, the priors or the rule does not fit, or a feature
    /// describes the contact region and the patch has no grid, or is a channel.
    pub fn new(classifier: &dyn Classifier, layout: &SkinLayout, options: &OnlineOptions) -> Result<Self, OnlineError> {
        let categories = classifier.categories();
        let image = PatchImage::new(layout, options.patch.as_deref(), options.threshold_n)?;
        if let Some(feature) = classifier.features().channels().next() {
            return Err(OnlineError::NoChannel(feature.name));
        }
        let no_region = |feature| OnlineError::NoRegion { feature, patch: image.patch().name.clone() };
        let needs = classifier.features().of_region().next();
        let regions =
            needs.map(|feature| Regions::new(&image, None).map_err(|_| no_region(feature.name))).transpose()?;
        let taxels = image.patch().taxels.len();
        let contact = |taxel| {
            let scores = vec![0.0; categories.len()];
            let verdict = TaxelVerdict { taxel, samples: 0, scores, verdict: Verdict::Uncertain };
            Contact { slot: None, travel: Travel::from(DVec3::ZERO), scored: false, verdict }
        };
        Ok(OnlineClassifier {
            judge: options.decision.prepare(&categories)?,
            scorer: classifier.online_scorer(taxels),
            image,
            regions,
            free: (0..taxels).map(Reverse).collect(),
            contacts: (0..taxels).map(contact).collect(),
        })
    }

    /// Takes in the next frame and gives the verdict for each taxel in contact, in ascending order of taxels.
    ///
    /// # Errors
    /// [`OnlineError`] if the frame does not fit the skin or holds NaN or infinity (frames are numbered from 0, the
    /// first one given to this classifier), or if the classifier fails.
    pub fn update(&mut self, frame: &Frame) -> Result<impl Iterator<Item = &TaxelVerdict>, OnlineError> {
        self.image.read(frame)?;
        if let Some(regions) = &mut self.regions {
            regions.find(&self.image);
        }
        for taxel in 0..self.contacts.len() {
            if self.image.is_in_contact(taxel) {
                self.sense(taxel, frame.time_s)?;
            } else if let Some(slot) = self.contacts[taxel].slot.take() {
                self.free.push(Reverse(slot));
            }
        }
        self.scorer.advance();
        for contact in &mut self.contacts {
            if let Some(slot) = contact.slot.filter(|_| contact.scored) {
                self.scorer.scores(slot, &mut contact.verdict.scores)?;
                contact.verdict.verdict = self.judge.choose(&contact.verdict.scores);
            }
        }
        Ok(self.contacts.iter().filter(|contact| contact.slot.is_some()).map(|contact| &contact.verdict))
    }

    /// Gives the scorer the sample of a taxel in contact.
    fn sense(&mut self, taxel: usize, time_s: f64) -> Result<(), OnlineError> {
        let contact = &mut self.contacts[taxel];
        let position_world = self.image.position_world(taxel);
        let slot = match contact.slot {
            Some(slot) => slot,
            None => {
                // There are as many slots as taxels.
                let Some(Reverse(slot)) = self.free.pop() else { return Ok(()) };
                self.scorer.begin(slot);
                contact.slot = Some(slot);
                contact.travel = Travel::from(position_world);
                contact.verdict.samples = 0;
                slot
            }
        };
        contact.verdict.samples += 1;
        let sample = Sample {
            time_s,
            force_n: self.image.sensed_force_n(taxel),
            motion_m: Some(contact.travel.to(position_world)),
            region: self.regions.as_ref().and_then(|regions| regions.of(taxel)),
            ..Sample::default()
        };
        let pushed = self.scorer.push(slot, &sample);
        contact.scored = pushed.map_err(|fault| OnlineError::BadSample { taxel, fault })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
