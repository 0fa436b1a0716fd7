//! Classification while the arm moves: one new frame in, one verdict per taxel in contact out.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use thiserror::Error;
use underbrush_recording::{Frame, Sample, SkinLayout};

use crate::decision::{Choice, Decision, DecisionError, Judge, Verdict};
use crate::feature::{FeatureError, SampleFault};
use crate::hmm::{FilterBank, ScoreKind};
use crate::model_set::ModelSet;
use crate::trial::{PatchImage, Regions, Travel, TrialError};

/// Why online classification stops.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OnlineError {
    /// A skin or frame that does not fit.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// Priors or thresholds that make no sense for these models.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// A sample that the models cannot take.
    #[error(transparent)]
    Feature(#[from] FeatureError),
    /// A sample that cannot be used.
    #[error("taxel {taxel} {fault}")]
    BadSample {
        /// Index of the taxel in its patch.
        taxel: usize,
        /// What is wrong.
        fault: SampleFault,
    },
    /// The models need the contact region, and the taxels form no grid.
    #[error("the feature {feature} needs the contact region: {source}; use a model without {feature}")]
    NoRegion {
        /// Name of the feature.
        feature: &'static str,
        /// Why there is no region.
        source: TrialError,
    },
}

/// Which taxels are classified, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct OnlineOptions {
    /// Name of the patch; the skin's first if `None`.
    pub patch: Option<String>,
    /// A taxel is in contact where its sensed force is above this, N.
    pub threshold_n: f64,
    /// The running score.
    pub score: ScoreKind,
    /// From scores to verdicts.
    pub decision: Decision,
}

/// What one taxel in contact is taken for at the moment.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelVerdict {
    /// Index of the taxel in its patch.
    pub taxel: usize,
    /// Samples since its contact began, at least 1. Beyond the recipe's `max_samples` the score stands still.
    pub samples: usize,
    /// Running score under each model, nats, in the order of [`ModelSet::categories`]; without priors.
    pub log_likelihood: Vec<f64>,
    /// The verdict on what was felt so far.
    pub verdict: Verdict,
}

/// A filter per taxel and model: begins with a contact, ends with its break (paper, section V-B).
///
/// After k samples of a contact the scores equal those of [`ModelSet::score`] for a trial of these k samples, bit for
/// bit, since both run the same filter. Once a taxel was in contact, its state is kept and nothing more is allocated
/// for it (but for the name where its verdict changes).
#[derive(Clone, Debug)]
pub struct OnlineClassifier {
    models: ModelSet,
    judge: Judge,
    image: PatchImage,
    /// Only where the models need them: finding them allocates.
    regions: Option<Regions>,
    /// The features of the sample at hand.
    values: Vec<f64>,
    bank: FilterBank,
    /// Streams of the bank without a contact; the first go first, so that those in use stay side by side.
    free: BinaryHeap<Reverse<usize>>,
    /// One a taxel.
    contacts: Vec<Contact>,
    frames: usize,
}

/// What is known of a taxel.
#[derive(Clone, Debug)]
struct Contact {
    /// Its stream in the bank, while it is in contact.
    stream: Option<usize>,
    travel: Travel,
    /// Whether the frame at hand gave the filters a sample.
    scored: bool,
    choice: Choice,
    verdict: TaxelVerdict,
}

impl OnlineClassifier {
    /// A classifier for streams of frames of this skin; no contact is open.
    ///
    /// # Errors
    /// [`OnlineError`] where the patch is unknown, or threshold, priors or rule make no sense.
    pub fn new(models: ModelSet, layout: &SkinLayout, options: &OnlineOptions) -> Result<Self, OnlineError> {
        let judge = options.decision.prepare(&models.categories())?;
        let image = PatchImage::new(layout, options.patch.as_deref(), options.threshold_n)?;
        let regions = match models.features().of_region().next() {
            None => None,
            Some(feature) => Some(Regions::new(&image, None).map_err(|source| OnlineError::NoRegion {
                feature: feature.name,
                source,
            })?),
        };
        let taxels = image.patch().taxels.len();
        let contact = |taxel| Contact {
            stream: None,
            travel: Travel::from(DVec3::ZERO),
            scored: false,
            choice: Choice::Uncertain,
            verdict: TaxelVerdict {
                taxel,
                samples: 0,
                log_likelihood: vec![0.0; models.models().len()],
                verdict: Verdict::Uncertain,
            },
        };
        Ok(OnlineClassifier {
            judge,
            image,
            regions,
            values: vec![0.0; models.features().dimension()],
            bank: FilterBank::new(options.score, models.models().values(), taxels),
            free: (0..taxels).map(Reverse).collect(),
            contacts: (0..taxels).map(contact).collect(),
            models,
            frames: 0,
        })
    }

    /// Takes in the next frame and gives the verdict for each taxel in contact, in ascending order of taxels.
    ///
    /// # Errors
    /// [`OnlineError`] where the frame does not fit the skin or holds NaN or infinity; its index counts the frames
    /// given to this classifier, from 0.
    pub fn update(&mut self, frame: &Frame) -> Result<impl Iterator<Item = &TaxelVerdict>, OnlineError> {
        self.image.read(self.frames, frame)?;
        self.frames += 1;
        if let Some(regions) = &mut self.regions {
            regions.find(&self.image);
        }
        for taxel in 0..self.contacts.len() {
            if self.image.is_in_contact(taxel) {
                self.sense(taxel, frame.time_s)?;
            } else if let Some(stream) = self.contacts[taxel].stream.take() {
                self.free.push(Reverse(stream));
            }
        }
        self.bank.advance(self.models.models().values());
        for contact in &mut self.contacts {
            if let Some(stream) = contact.stream.filter(|_| contact.scored) {
                contact
                    .verdict
                    .log_likelihood
                    .iter_mut()
                    .zip(self.bank.scores(stream))
                    .for_each(|(out, score)| *out = score);
                contact.decide(&self.judge);
            }
        }
        Ok(self
            .contacts
            .iter()
            .filter(|contact| contact.stream.is_some())
            .map(|contact| &contact.verdict))
    }

    /// Gives the filters of a taxel in contact its sample.
    fn sense(&mut self, taxel: usize, time_s: f64) -> Result<(), OnlineError> {
        let contact = &mut self.contacts[taxel];
        let position_world = self.image.position_world(taxel);
        let stream = match contact.stream {
            Some(stream) => stream,
            None => {
                // There are as many streams as taxels.
                let Some(Reverse(stream)) = self.free.pop() else {
                    return Ok(());
                };
                self.bank.begin(stream);
                contact.stream = Some(stream);
                contact.travel = Travel::from(position_world);
                contact.verdict.samples = 0;
                stream
            }
        };
        contact.verdict.samples += 1;
        contact.scored = self
            .models
            .max_samples()
            .is_none_or(|most| contact.verdict.samples <= most);
        if !contact.scored {
            return Ok(());
        }
        let sample = Sample {
            time_s,
            force_n: self.image.sensed_force_n(taxel),
            motion_m: Some(contact.travel.to(position_world)),
            region: self.regions.as_ref().and_then(|regions| regions.of(taxel)),
            touched: None,
        };
        let values = &mut self.values[..];
        let bad_sample = |fault| OnlineError::BadSample { taxel, fault };
        self.models.features().read(&sample, values).map_err(bad_sample)?;
        if let Some(scaling) = self.models.scaling() {
            scaling.apply(values);
        }
        Ok(self.bank.put(stream, values)?)
    }
}

impl Contact {
    fn decide(&mut self, judge: &Judge) {
        let choice = judge.choose(&self.verdict.log_likelihood);
        if choice != self.choice {
            self.choice = choice;
            self.verdict.verdict = judge.verdict(choice);
        }
    }
}

#[cfg(test)]
mod tests;
