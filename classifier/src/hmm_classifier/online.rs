//! Scores of many contacts at once, without allocation.

use underbrush_recording::Sample;

use super::HmmClassifier;
use crate::error::ModelError;
use crate::estimator::OnlineScorer;
use crate::feature::{FeatureSet, SampleFault, Scaling};
use crate::hmm::FilterBank;

/// A bank of filters, one per contact and model. Nothing is allocated after it is made.
#[derive(Debug)]
pub(super) struct HmmOnlineScorer {
    features: FeatureSet,
    scaling: Option<Scaling>,
    max_samples: usize,
    bank: FilterBank,
    /// Samples of each contact so far.
    samples: Vec<usize>,
    /// The features of the current sample.
    values: Vec<f64>,
}

impl HmmOnlineScorer {
    pub(super) fn new(classifier: &HmmClassifier, contacts: usize) -> Self {
        let models = classifier.models.values().cloned().collect();
        HmmOnlineScorer {
            features: classifier.features,
            scaling: classifier.scaling.clone(),
            max_samples: classifier.max_samples().unwrap_or(usize::MAX),
            bank: FilterBank::new(classifier.score_kind(), models, contacts),
            samples: vec![0; contacts],
            values: vec![0.0; classifier.features.dimension()],
        }
    }
}

impl OnlineScorer for HmmOnlineScorer {
    fn begin(&mut self, contact: usize) {
        self.samples[contact] = 0;
        self.bank.begin(contact);
    }

    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault> {
        if self.samples[contact] >= self.max_samples {
            return Ok(false);
        }
        self.features.read(sample, &mut self.values)?;
        if let Some(scaling) = &self.scaling {
            scaling.apply(&mut self.values);
        }
        self.features.check_scaled(&self.values)?;
        self.bank.put(contact, &self.values);
        self.samples[contact] += 1;
        Ok(true)
    }

    fn advance(&mut self) {
        self.bank.advance();
    }

    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError> {
        let found = self.bank.scores(contact);
        scores.iter_mut().zip(found).for_each(|(place, score)| *place = score);
        Ok(())
    }
}
