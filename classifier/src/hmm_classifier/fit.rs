//! Training: one model per category.

use std::collections::BTreeMap;

use rayon::prelude::*;
use underbrush_recording::Trial;

use super::HmmClassifier;
use crate::error::ModelError;
use crate::estimator::trials_by_category;
use crate::feature::Scaling;
use crate::hmm::{GaussianHmm, TrainingError, TrainingHistory, TrainingOptions, equal_slice_start, train};
use crate::recipe::{Recipe, ScalingKind, check_training};

impl HmmClassifier {
    /// Trains one model per category by `recipe`, in parallel. The result is bit for bit the same for any number of
    /// threads.
    ///
    /// Trials without a category, blocks and outliers are skipped.
    ///
    /// # Errors
    /// [`ModelError`] if the recipe is outside its ranges, no trial has a category, a trial lacks a feature, or
    /// training fails.
    pub fn train<'a>(trials: impl IntoIterator<Item = &'a Trial>, recipe: &Recipe) -> Result<Self, ModelError> {
        recipe.check()?;
        let mut sequences = BTreeMap::new();
        for (category, trials) in trials_by_category(trials)? {
            let own = trials.iter().map(|trial| recipe.features.observations(trial, recipe.max_samples));
            sequences.insert(category, own.collect::<Result<Vec<_>, _>>()?);
        }
        let scaling = match recipe.scaling {
            ScalingKind::Unscaled => None,
            ScalingKind::ZScore => {
                let scaling = Scaling::fit(&recipe.features.columns(), sequences.values().flatten())?;
                sequences.values_mut().flatten().for_each(|sequence| scaling.apply_all(sequence));
                Some(scaling)
            }
        };
        let options = &recipe.training;
        let trained = sequences.into_par_iter().map(|(category, sequences)| {
            let model =
                equal_slice_start(&sequences, recipe.states, recipe.topology, recipe.initial, options.variance_floor)
                    .and_then(|start| train(&start, &sequences, options));
            with_category(category, model)
        });
        // The first error in alphabetical order of categories is returned, for any number of threads.
        let trained: Vec<Result<Trained, ModelError>> = trained.collect();
        let (models, training): (BTreeMap<_, _>, BTreeMap<_, _>) = trained.into_iter().collect::<Result<_, _>>()?;
        let set = HmmClassifier::new(recipe.features, models)?;
        Ok(HmmClassifier { scaling, recipe: Some(recipe.clone()), training, ..set })
    }

    /// Continues training from given models, one per category of `start`.
    ///
    /// Features, scaling and truncation are taken from `start`; the kind of score is the recipe's again. Trials of other
    /// categories are skipped.
    ///
    /// # Errors
    /// [`ModelError`] as for [`HmmClassifier::train`] (the options have the ranges that they have in a recipe), and if
    /// a category of `start` has no trials.
    pub fn train_from(start: &HmmClassifier, trials: &[Trial], options: &TrainingOptions) -> Result<Self, ModelError> {
        check_training(options)?;
        let trained = start.models.par_iter().map(|(category, model)| {
            let own = trials.iter().filter(|trial| trial.category.as_ref() == Some(category));
            let sequences = own.map(|trial| start.sequence(trial)).collect::<Result<Vec<_>, _>>()?;
            if sequences.is_empty() {
                return Err(ModelError::NoTrials(category.clone()));
            }
            with_category(category.clone(), train(&model.model, &sequences, options))
        });
        let trained: Vec<Result<Trained, ModelError>> = trained.collect();
        let (models, training): (BTreeMap<_, _>, BTreeMap<_, _>) = trained.into_iter().collect::<Result<_, _>>()?;
        let recipe = start.recipe.clone().map(|recipe| Recipe { training: *options, ..recipe });
        let set = HmmClassifier::new(start.features, models)?;
        Ok(HmmClassifier { scaling: start.scaling.clone(), recipe, training, ..set })
    }
}

type Trained = ((String, GaussianHmm), (String, TrainingHistory));

fn with_category(
    category: String,
    outcome: Result<(GaussianHmm, TrainingHistory), TrainingError>,
) -> Result<Trained, ModelError> {
    let (model, history) = outcome.map_err(|source| ModelError::Training { category: category.clone(), source })?;
    Ok(((category.clone(), model), (category, history)))
}
