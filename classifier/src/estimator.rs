//! The one interface of everything that learns categories from trials: the hidden Markov models, the baselines, and
//! whatever is to be compared with them.

use std::collections::BTreeMap;

use underbrush_recording::Trial;

use crate::hmm::TrainingHistory;
use crate::model_set::{ModelError, ModelSet};
use crate::recipe::Recipe;

/// Options of a classifier that can be fitted to labelled trials.
pub trait Estimator: Sync {
    /// A classifier fitted to these trials; the same bytes for the same trials, whatever the number of threads.
    ///
    /// Trials without a category, blocks and outliers teach nothing ([`crate::is_trained`]).
    ///
    /// # Errors
    /// [`ModelError`] where nothing can be fitted or a trial lacks what the estimator needs.
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError>;
}

/// Tells the categories apart, from what was felt so far.
pub trait Classifier: Send + Sync {
    /// The categories in alphabetical order: the order of all scores.
    fn categories(&self) -> Vec<String>;

    /// For each count of samples, in ascending order and from 1, one score a category for the trial's first samples: a
    /// log-likelihood, or a log-posterior under equal priors, in nats, so that priors can be added and differences are
    /// leads. A count beyond the trial's length stands for all of it.
    ///
    /// What comes after a count has no part in its scores: a classifier can always be asked while the contact lasts.
    ///
    /// # Errors
    /// [`ModelError`] where the trial is empty or lacks what the classifier needs.
    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError>;

    /// The scores of whole trials, one row a trial: [`Classifier::scores_after`] its last sample.
    ///
    /// # Errors
    /// As [`Classifier::scores_after`].
    fn scores_of_all(&self, trials: &[&Trial]) -> Result<Vec<Vec<f64>>, ModelError> {
        let of_trial = |trial: &&Trial| {
            let mut scores = self.scores_after(trial, &[trial.samples.len()])?;
            Ok(scores.pop().unwrap_or_default())
        };
        trials.iter().map(of_trial).collect()
    }

    /// How the training of each category went, for what is trained step by step.
    fn training(&self) -> Option<&BTreeMap<String, TrainingHistory>> {
        None
    }
}

impl dyn Classifier + '_ {
    /// The scores of a whole trial, one a category.
    ///
    /// # Errors
    /// As [`Classifier::scores_after`].
    pub fn scores(&self, trial: &Trial) -> Result<Vec<f64>, ModelError> {
        Ok(self.scores_of_all(&[trial])?.pop().unwrap_or_default())
    }
}

impl Estimator for Recipe {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        let (models, _) = ModelSet::train_on(trials.iter().copied(), self)?;
        Ok(Box::new(models))
    }
}

impl Classifier for ModelSet {
    fn categories(&self) -> Vec<String> {
        ModelSet::categories(self)
    }

    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        ModelSet::scores_after(self, trial, self.score_kind(), counts)
    }

    fn scores_of_all(&self, trials: &[&Trial]) -> Result<Vec<Vec<f64>>, ModelError> {
        self.score_all(trials, self.score_kind())
    }

    fn training(&self) -> Option<&BTreeMap<String, TrainingHistory>> {
        Some(&self.training)
    }
}
