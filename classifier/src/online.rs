//! Classification while the arm moves: one new frame in, one verdict per taxel in contact out.

use glam::DVec3;
use thiserror::Error;
use underbrush_recording::{Frame, SkinLayout};

use crate::decision::{Choice, Decision, DecisionError, Judge, Verdict};
use crate::feature::{FeatureError, FeatureSet};
use crate::hmm::{RunningScore, ScoreKind};
use crate::model_set::ModelSet;
use crate::trial::{PatchImage, TrialError};

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
}

/// Which taxels are classified, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct OnlineOptions {
    /// Name of the patch.
    pub patch: String,
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
    score: ScoreKind,
    image: PatchImage,
    contacts: Vec<Option<Contact>>,
    frames: usize,
}

/// A taxel that is or was in contact.
#[derive(Clone, Debug)]
struct Contact {
    active: bool,
    start_world: DVec3,
    scores: Vec<RunningScore>,
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
        let image = PatchImage::new(layout, &options.patch, options.threshold_n)?;
        let contacts = vec![None; image.patch().taxels.len()];
        Ok(OnlineClassifier {
            models,
            judge,
            score: options.score,
            image,
            contacts,
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
        for (taxel, slot) in self.contacts.iter_mut().enumerate() {
            if !self.image.is_in_contact(taxel) {
                if let Some(contact) = slot {
                    contact.active = false;
                }
                continue;
            }
            let contact = slot.get_or_insert_with(|| Contact::new(taxel, &self.models, self.score));
            let position_world = self.image.position_world(taxel);
            if !contact.active {
                contact.begin(position_world);
            }
            contact.verdict.samples += 1;
            if self
                .models
                .max_samples()
                .is_none_or(|most| contact.verdict.samples <= most)
            {
                contact.score(&self.models, self.image.sensed_force_n(taxel), position_world)?;
                contact.decide(&self.judge);
            }
        }
        Ok(self
            .contacts
            .iter()
            .flatten()
            .filter(|contact| contact.active)
            .map(|contact| &contact.verdict))
    }
}

impl Contact {
    fn new(taxel: usize, models: &ModelSet, score: ScoreKind) -> Self {
        let scores = models.running_scores(score);
        let log_likelihood = vec![0.0; scores.len()];
        let verdict = TaxelVerdict {
            taxel,
            samples: 0,
            log_likelihood,
            verdict: Verdict::Uncertain,
        };
        Contact {
            active: false,
            start_world: DVec3::ZERO,
            scores,
            choice: Choice::Uncertain,
            verdict,
        }
    }

    fn begin(&mut self, position_world: DVec3) {
        self.active = true;
        self.start_world = position_world;
        self.scores.iter_mut().for_each(RunningScore::reset);
        self.verdict.samples = 0;
    }

    fn score(&mut self, models: &ModelSet, force_n: f64, position_world: DVec3) -> Result<(), FeatureError> {
        let mut sample = [force_n, position_world.distance(self.start_world)];
        let sample = match models.features() {
            FeatureSet::Force => &mut sample[..1],
            FeatureSet::ForceAndMotion => &mut sample[..],
        };
        if let Some(scaling) = models.scaling() {
            scaling.apply(sample);
        }
        let filters = self.scores.iter_mut().zip(models.models().values());
        for ((score, model), out) in filters.zip(&mut self.verdict.log_likelihood) {
            score.push(model, sample)?;
            *out = score.log_probability();
        }
        Ok(())
    }

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
