//! One model per category: training and scoring.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;
use underbrush_recording::{Category, InputError, Trial};

use crate::decision::Decision;
use crate::feature::{FeatureError, FeatureSet, Observations, Scaling};
use crate::hmm::{
    GaussianHmm, RunningScore, ScoreKind, Scorer, TrainingError, TrainingHistory, TrainingOptions, equal_slice_start,
    train,
};
use crate::recipe::{Recipe, ScalingKind};

/// Why models cannot be trained, read or used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ModelError {
    /// A model file that cannot be read or is unsound.
    #[error(transparent)]
    Input(Box<InputError>),
    /// A trial that does not give the features asked for.
    #[error(transparent)]
    Feature(#[from] FeatureError),
    /// No trial has a category that can be trained.
    #[error(
        "none of {trials} trials has a category to train (blocks and outliers are never trained); \
         use trials with ground truth, such as leaf and trunk"
    )]
    NoCategories {
        /// Number of trials given.
        trials: usize,
    },
    /// A category of the start models has no trials.
    #[error("no trial has the category {category} of the start models; add such trials or drop that start model")]
    NoTrials {
        /// The category.
        category: String,
    },
    /// Training of one category's model failed.
    #[error("training the model of {category}: {source}")]
    Training {
        /// The category.
        category: String,
        /// What went wrong.
        source: TrainingError,
    },
    /// Models, features and scaling that do not fit together.
    #[error("{found}; allowed: {allowed}")]
    Mismatch {
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: String,
    },
}

impl From<InputError> for ModelError {
    fn from(error: InputError) -> Self {
        ModelError::Input(Box::new(error))
    }
}

/// One hidden Markov model per category, over the same features (paper, section III).
///
/// Made by [`ModelSet::train`], [`ModelSet::train_from`], [`ModelSet::load`] or [`ModelSet::new`]; all of them check it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSet {
    pub(crate) features: FeatureSet,
    /// Prepared for scoring once, when the set is made.
    pub(crate) models: BTreeMap<String, Scorer>,
    pub(crate) scaling: Option<Scaling>,
    /// What made the models, where known; foreign models have none.
    pub recipe: Option<Recipe>,
    /// How the training of each category went, where known.
    pub training: BTreeMap<String, TrainingHistory>,
    /// Priors and thresholds to classify with, where the file has them.
    pub decision: Option<Decision>,
    /// Where the models come from, free text by key (program, data set, seed).
    pub provenance: BTreeMap<String, String>,
}

/// How training went, to be printed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrainingReport {
    /// By category.
    pub categories: BTreeMap<String, TrainingHistory>,
    /// Trials left out, since they have no category or one that is never trained.
    pub skipped_trials: usize,
}

/// Choice: trials that one thread scores together, enough to find fours of like length.
const TOGETHER: usize = 64;

/// Whether models are made of a category: of any but [`Category::BLOCK`] and [`Category::OUTLIER`].
pub fn is_trained(category: &str) -> bool {
    !matches!(Category::from_name(category), Some(Category::BLOCK | Category::OUTLIER))
}

/// The categories to train that occur in trials, each with its trials in the order of the table.
pub(crate) fn trials_by_category<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> BTreeMap<String, Vec<&'a Trial>> {
    let mut by_category: BTreeMap<String, Vec<&Trial>> = BTreeMap::new();
    for trial in trials {
        if let Some(category) = trial.category.as_deref().filter(|category| is_trained(category)) {
            by_category.entry(category.to_owned()).or_default().push(trial);
        }
    }
    by_category
}

impl ModelSet {
    /// A set of models made elsewhere, without scaling, history or recipe.
    ///
    /// # Errors
    /// [`ModelError::Mismatch`] where there are no models or one has another number of features.
    pub fn new(features: FeatureSet, models: BTreeMap<String, GaussianHmm>) -> Result<Self, ModelError> {
        if models.is_empty() {
            return Err(ModelError::Mismatch {
                found: "no models".into(),
                allowed: "at least one model".into(),
            });
        }
        if let Some((category, model)) = models
            .iter()
            .find(|(_, model)| model.dimension() != features.dimension())
        {
            return Err(ModelError::Mismatch {
                found: format!("a model of {category} over {} features", model.dimension()),
                allowed: format!(
                    "models over the {} features {:?}",
                    features.dimension(),
                    features.columns()
                ),
            });
        }
        let (training, provenance) = (BTreeMap::new(), BTreeMap::new());
        Ok(ModelSet {
            features,
            models: prepared(models),
            scaling: None,
            recipe: None,
            training,
            decision: None,
            provenance,
        })
    }

    /// Trains one model per category by `recipe`, in parallel; the same bytes whatever the number of threads.
    ///
    /// Trials without a category, blocks and outliers are skipped.
    ///
    /// # Errors
    /// [`ModelError`] where nothing can be trained, a trial lacks a feature, or a model cannot be estimated.
    pub fn train(trials: &[Trial], recipe: &Recipe) -> Result<(Self, TrainingReport), ModelError> {
        Self::train_on(trials, recipe)
    }

    /// [`ModelSet::train`] on trials from anywhere, for folds that borrow.
    pub(crate) fn train_on<'a>(
        trials: impl IntoIterator<Item = &'a Trial, IntoIter: Clone>,
        recipe: &Recipe,
    ) -> Result<(Self, TrainingReport), ModelError> {
        let trials = trials.into_iter();
        let count = trials.clone().count();
        let mut sequences = BTreeMap::new();
        for (category, trials) in trials_by_category(trials) {
            sequences.insert(category, observations(&trials, recipe.features, recipe.max_samples)?);
        }
        if sequences.is_empty() {
            return Err(ModelError::NoCategories { trials: count });
        }
        let scaling = match recipe.scaling {
            ScalingKind::Unscaled => None,
            ScalingKind::ZScore => {
                let scaling = Scaling::fit(recipe.features, sequences.values().flatten())?;
                sequences
                    .values_mut()
                    .flatten()
                    .for_each(|sequence| scaling.apply_all(sequence));
                Some(scaling)
            }
        };
        let options = &recipe.training;
        let trained = sequences.into_par_iter().map(|(category, sequences)| {
            let model = equal_slice_start(
                &sequences,
                recipe.states,
                recipe.topology,
                recipe.initial,
                options.variance_floor,
            )
            .and_then(|start| train(&start, &sequences, options));
            with_category(category, model)
        });
        let (models, report) = collect(trained.collect(), count)?;
        let set = ModelSet::new(recipe.features, models)?;
        let (recipe, training) = (Some(recipe.clone()), report.categories.clone());
        Ok((
            ModelSet {
                scaling,
                recipe,
                training,
                ..set
            },
            report,
        ))
    }

    /// Trains on from given models: Baum-Welch from their parameters, one model per category of `start`.
    ///
    /// Features, scaling and truncation stay those of `start`; trials of other categories are skipped.
    ///
    /// # Errors
    /// [`ModelError`] as for [`ModelSet::train`], and where a category of `start` has no trials.
    pub fn train_from(
        start: ModelSet,
        trials: &[Trial],
        options: &TrainingOptions,
    ) -> Result<(Self, TrainingReport), ModelError> {
        let max_samples = start.max_samples();
        let trained: Vec<_> = start
            .models
            .par_iter()
            .map(|(category, model)| {
                let own: Vec<&Trial> = trials
                    .iter()
                    .filter(|trial| trial.category.as_ref() == Some(category))
                    .collect();
                if own.is_empty() {
                    return Err(ModelError::NoTrials {
                        category: category.clone(),
                    });
                }
                let mut sequences = observations(&own, start.features, max_samples)?;
                if let Some(scaling) = &start.scaling {
                    sequences.iter_mut().for_each(|sequence| scaling.apply_all(sequence));
                }
                with_category(category.clone(), train(model.model(), &sequences, options))
            })
            .collect();
        let (models, report) = collect(trained, trials.len())?;
        let recipe = start.recipe.map(|recipe| Recipe {
            training: *options,
            ..recipe
        });
        Ok((
            ModelSet {
                models: prepared(models),
                recipe,
                training: report.categories.clone(),
                ..start
            },
            report,
        ))
    }

    /// What of a sample the models see.
    pub fn features(&self) -> FeatureSet {
        self.features
    }

    /// The models by category, prepared for scoring.
    pub fn models(&self) -> &BTreeMap<String, Scorer> {
        &self.models
    }

    /// The scaling of the features, where the models were trained on scaled ones.
    pub fn scaling(&self) -> Option<&Scaling> {
        self.scaling.as_ref()
    }

    /// The categories, in the order of all scores.
    pub fn categories(&self) -> Vec<String> {
        self.models.keys().cloned().collect()
    }

    /// The score that the recipe asks for; forward (eq. 2) where no recipe is known.
    pub fn score_kind(&self) -> ScoreKind {
        self.recipe.as_ref().map_or(ScoreKind::Forward, |recipe| recipe.score)
    }

    /// How many first samples of a trial count; `None`: all.
    pub(crate) fn max_samples(&self) -> Option<usize> {
        self.recipe.as_ref().and_then(|recipe| recipe.max_samples)
    }

    /// The score of a trial under each category's model, in nats, by category in alphabetical order.
    ///
    /// With scaling these are densities of the scaled features: differences between categories do not depend on it.
    ///
    /// # Errors
    /// [`ModelError::Feature`] where the trial does not give the models' features.
    pub fn score(&self, trial: &Trial, kind: ScoreKind) -> Result<Vec<(String, f64)>, ModelError> {
        let scores = self.score_all(&[trial], kind)?.pop().unwrap_or_default();
        Ok(self.models.keys().cloned().zip(scores).collect())
    }

    /// What [`ModelSet::score`] gives for each of many trials, in the order of [`ModelSet::categories`]: several times as
    /// fast as one by one, on all threads.
    ///
    /// # Errors
    /// [`ModelError::Feature`] where a trial does not give the models' features.
    pub fn score_all(&self, trials: &[&Trial], kind: ScoreKind) -> Result<Vec<Vec<f64>>, ModelError> {
        let score = |trials: &[&Trial]| {
            let sequences = trials.iter().map(|trial| self.sequence(trial, None));
            let sequences = sequences.collect::<Result<Vec<_>, FeatureError>>()?;
            let sequences: Vec<&Observations> = sequences.iter().collect();
            let mut scores = vec![Vec::with_capacity(self.models.len()); trials.len()];
            for model in self.models.values() {
                let of_model = model.log_probabilities(kind, &sequences)?;
                scores.iter_mut().zip(of_model).for_each(|(row, score)| row.push(score));
            }
            Ok(scores)
        };
        // Of several errors the first in the order of the trials, whatever the number of threads.
        let parts: Vec<Result<_, ModelError>> = trials.par_chunks(TOGETHER).map(score).collect();
        Ok(parts.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    }

    /// [`ModelSet::score`] after each of some counts of samples, ascending and from 1, without the names.
    pub(crate) fn scores_after(
        &self,
        trial: &Trial,
        kind: ScoreKind,
        counts: &[usize],
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        let sequence = self.sequence(trial, counts.last().copied())?;
        let mut scores = vec![Vec::with_capacity(self.models.len()); counts.len()];
        for model in self.models.values() {
            let mut running = RunningScore::new(kind, model);
            let mut samples = sequence.samples();
            for (row, &count) in scores.iter_mut().zip(counts) {
                for sample in samples.by_ref().take(count.saturating_sub(running.sample_count())) {
                    running.push(model, sample)?;
                }
                row.push(running.log_probability());
            }
        }
        Ok(scores)
    }

    /// What the models see of a trial, of its first `count` samples where that is given.
    fn sequence(&self, trial: &Trial, count: Option<usize>) -> Result<Observations, FeatureError> {
        let most = [self.max_samples(), count].into_iter().flatten().min();
        let mut sequence = self.features.observations(trial, most)?;
        if let Some(scaling) = &self.scaling {
            scaling.apply_all(&mut sequence);
        }
        Ok(sequence)
    }
}

fn prepared(models: BTreeMap<String, GaussianHmm>) -> BTreeMap<String, Scorer> {
    let models = models.into_iter();
    models.map(|(category, model)| (category, model.into())).collect()
}

type Trained = (String, GaussianHmm, TrainingHistory);

fn with_category(
    category: String,
    outcome: Result<(GaussianHmm, TrainingHistory), TrainingError>,
) -> Result<Trained, ModelError> {
    match outcome {
        Ok((model, history)) => Ok((category, model, history)),
        Err(source) => Err(ModelError::Training { category, source }),
    }
}

/// Models and report; of several errors the first by category.
fn collect(
    trained: Vec<Result<Trained, ModelError>>,
    trials: usize,
) -> Result<(BTreeMap<String, GaussianHmm>, TrainingReport), ModelError> {
    let mut models = BTreeMap::new();
    let mut categories = BTreeMap::new();
    for outcome in trained {
        let (category, model, history) = outcome?;
        models.insert(category.clone(), model);
        categories.insert(category, history);
    }
    let used: usize = categories.values().map(|history| history.trials).sum();
    Ok((
        models,
        TrainingReport {
            categories,
            skipped_trials: trials - used,
        },
    ))
}

fn observations(
    trials: &[&Trial],
    features: FeatureSet,
    max_samples: Option<usize>,
) -> Result<Vec<Observations>, FeatureError> {
    trials
        .iter()
        .map(|trial| features.observations(trial, max_samples))
        .collect()
}
