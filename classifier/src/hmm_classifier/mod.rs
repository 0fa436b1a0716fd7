//! The paper's classifier: one hidden Markov model per category (section III).

mod file;
mod fit;

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde_json::{Value, json};
use underbrush_recording::{Sample, Trial, stop};

use crate::estimator::{Classifier, ClassifierKind, Estimator, OnlineScorer};
use crate::feature::{FeatureError, FeatureSet, Observations, SampleFault, Scaling};
use crate::hmm::{FilterBank, GaussianHmm, ScoreKind, Scorer, TrainingHistory};
use crate::{ModelError, Recipe};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = ClassifierKind {
    name: "hmm",
    aliases: &[],
    summary: "The paper's hidden Markov models, one per category",
    is_by_features: false,
    estimator: |features| {
        let recipe = Recipe::authors();
        Box::new(Recipe { features: features.unwrap_or(recipe.features), ..recipe })
    },
    load: |document| Ok(Box::new(HmmClassifier::read(document)?)),
    schema: file::HmmFile::json_schema,
};

/// One hidden Markov model per category, over the same features (paper, section III).
///
/// The options are a [`Recipe`]. Each category's model has Gaussian emissions and is trained by Baum-Welch on the
/// category's trials; a trial's score is the forward log-likelihood or the log-probability of the best state path
/// ([`ScoreKind`]). Samples are assumed to depend on each other only through the hidden state, and to come at a fixed
/// rate. If features are scaled, scores are densities of the scaled features; differences between categories do not depend on
/// the scaling.
///
/// ```
/// use underbrush_classifier::{Classifier, HmmClassifier};
/// use underbrush_classifier::recipe::Recipe;
/// use underbrush_recording::{Sample, Trial};
///
/// let press = |category: &str, newtons: f64, number: u64| Trial {
///     trial: number,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: (1..=20)
///         .map(|k| Sample {
///             time_s: 0.01 * f64::from(k),
///             force_n: newtons * f64::from(k) * (1.0 + 0.01 * number as f64),
///             ..Sample::default()
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
/// let recipe = Recipe { states: 3, ..Recipe::authors() };
/// let models = HmmClassifier::train(&trials, &recipe)?;
/// let scores = models.scores_of_all(&[&press("trunk", 0.25, 3)])?;
/// assert!(scores[0][1] > scores[0][0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// It is made by [`HmmClassifier::train`], [`HmmClassifier::train_from`] or [`HmmClassifier::new`], or read from a
/// model file. All of these check it.
#[derive(Clone, Debug, PartialEq)]
pub struct HmmClassifier {
    features: FeatureSet,
    /// Prepared for scoring once, when the classifier is made.
    models: BTreeMap<String, Scorer>,
    /// The scaling of the features, if the models were trained on scaled ones.
    pub(crate) scaling: Option<Scaling>,
    /// The kind of score that was chosen instead of the recipe's. Model files do not store this choice.
    pub score: Option<ScoreKind>,
    /// The recipe of the models, if known; models made elsewhere have none.
    pub recipe: Option<Recipe>,
    /// The training report of each category, if known.
    pub training: BTreeMap<String, TrainingHistory>,
}

/// Number of trials that one thread scores together. Choice: enough to find groups of four with similar length.
const TOGETHER: usize = 64;

impl HmmClassifier {
    /// Models made elsewhere, without scaling, history or recipe.
    ///
    /// # Errors
    /// [`ModelError::Mismatch`] if there are no models or one has another number of features.
    pub fn new(features: FeatureSet, models: BTreeMap<String, GaussianHmm>) -> Result<Self, ModelError> {
        if models.is_empty() {
            return Err(ModelError::mismatch("no models", "at least one model"));
        }
        if let Some((category, model)) = models.iter().find(|(_, model)| model.dimension() != features.dimension()) {
            let found = format!("a model of {category} over {} features", model.dimension());
            let allowed = format!("models over the {} features {:?}", features.dimension(), features.columns());
            return Err(ModelError::mismatch(found, allowed));
        }
        Ok(HmmClassifier {
            features,
            models: models.into_iter().map(|(category, model)| (category, model.into())).collect(),
            scaling: None,
            score: None,
            recipe: None,
            training: BTreeMap::new(),
        })
    }

    /// The models by category, prepared for scoring.
    pub fn models(&self) -> &BTreeMap<String, Scorer> {
        &self.models
    }

    /// The kind of score: the one in [`HmmClassifier::score`]; if none was chosen, the recipe's; without a
    /// recipe, forward (eq. 2).
    pub fn score_kind(&self) -> ScoreKind {
        self.score.unwrap_or_else(|| self.own_score_kind())
    }

    /// The kind of score of the recipe; forward (eq. 2) if no recipe is known. Thresholds in the model file were chosen
    /// for scores of this kind.
    pub fn own_score_kind(&self) -> ScoreKind {
        self.recipe.as_ref().map_or(ScoreKind::Forward, |recipe| recipe.score)
    }

    /// Number of samples used at the start of each trial; `None` for all.
    pub(crate) fn max_samples(&self) -> Option<usize> {
        self.recipe.as_ref().and_then(|recipe| recipe.max_samples)
    }

    /// The features of a trial as the models see them.
    fn sequence(&self, trial: &Trial) -> Result<Observations, FeatureError> {
        let mut sequence = self.features.observations(trial, self.max_samples())?;
        if let Some(scaling) = &self.scaling {
            scaling.apply_all(&mut sequence);
            for (index, sample) in sequence.samples().enumerate() {
                self.features.check_scaled(sample).map_err(|fault| fault.at(trial, index))?;
            }
        }
        Ok(sequence)
    }
}

impl Classifier for HmmClassifier {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn categories(&self) -> Vec<String> {
        self.models.keys().cloned().collect()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        let models = self.models.values().cloned().collect();
        Box::new(HmmOnlineScorer {
            features: self.features,
            scaling: self.scaling.clone(),
            max_samples: self.max_samples().unwrap_or(usize::MAX),
            bank: FilterBank::new(self.score_kind(), models, contacts),
            samples: vec![0; contacts],
            values: vec![0.0; self.features.dimension()],
        })
    }

    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        let models: BTreeMap<_, _> = self.models.iter().map(|(name, own)| (name, own.model.parameters())).collect();
        vec![
            ("features", json!(self.features.columns())),
            ("recipe", json!(self.recipe)),
            ("scaling", json!(self.scaling)),
            ("models", json!(models)),
            ("training", json!(self.training)),
        ]
    }

    /// This uses all threads and is several times as fast as scoring the trials one by one.
    fn scores_of_all(&self, trials: &[&Trial]) -> Result<Vec<Vec<f64>>, ModelError> {
        let kind = self.score_kind();
        let score = |trials: &[&Trial]| {
            stop::check();
            let sequences = trials.iter().map(|trial| self.sequence(trial));
            let sequences = sequences.collect::<Result<Vec<_>, FeatureError>>()?;
            let sequences: Vec<&Observations> = sequences.iter().collect();
            let mut scores = vec![Vec::with_capacity(self.models.len()); trials.len()];
            for model in self.models.values() {
                let of_model = model.log_probabilities(kind, &sequences)?;
                for (row, score) in scores.iter_mut().zip(of_model) {
                    row.push(score);
                }
            }
            Ok(scores)
        };
        // If there are several errors, the first in the order of the trials is returned, for any number of threads.
        let parts: Vec<Result<_, ModelError>> = trials.par_chunks(TOGETHER).map(score).collect();
        Ok(parts.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn training(&self) -> Option<&BTreeMap<String, TrainingHistory>> {
        Some(&self.training)
    }
}

/// A bank of filters, one per contact and model. Nothing is allocated after it is made.
#[derive(Debug)]
struct HmmOnlineScorer {
    features: FeatureSet,
    scaling: Option<Scaling>,
    max_samples: usize,
    bank: FilterBank,
    /// Samples of each contact so far.
    samples: Vec<usize>,
    /// The features of the current sample.
    values: Vec<f64>,
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

impl Estimator for Recipe {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        Ok(Box::new(HmmClassifier::train(trials.iter().copied(), self)?))
    }
}

#[cfg(test)]
mod tests;
