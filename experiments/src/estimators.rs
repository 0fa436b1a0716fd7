//! Classifiers as an experiment file names them.

use underbrush_classifier::baseline::{EchoStateNetwork, Logistic, NaiveBayes, NearestNeighbours};
use underbrush_classifier::estimator::Estimator;
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;

use crate::definition::{ClassifierEntry, Experiment, Feature, Method, RecipeName};

/// Name of the recipe in tables.
pub fn recipe_name(name: RecipeName) -> &'static str {
    match name {
        RecipeName::Authors => "authors",
        RecipeName::Modern => "modern",
    }
}

/// The recipe of a name.
pub fn recipe(name: RecipeName) -> Recipe {
    match name {
        RecipeName::Authors => Recipe::authors(),
        RecipeName::Modern => Recipe::modern(),
    }
}

/// The recipe that is used wherever only one is: the experiment's first.
pub fn main_recipe(experiment: &Experiment) -> Recipe {
    recipe(main_recipe_name(experiment))
}

/// Its name.
pub fn main_recipe_name(experiment: &Experiment) -> RecipeName {
    experiment.file.recipes.first().copied().unwrap_or(RecipeName::Authors)
}

/// The features of hidden Markov models as an experiment file names them.
pub fn features(named: &[Feature]) -> FeatureSet {
    match named.contains(&Feature::Motion) {
        true => FeatureSet::FORCE_AND_MOTION,
        false => FeatureSet::FORCE,
    }
}

/// The same by name.
pub fn feature_names(features: FeatureSet) -> &'static [Feature] {
    match features == FeatureSet::FORCE {
        true => &[Feature::Force],
        false => &[Feature::Force, Feature::Motion],
    }
}

/// The classifier that an entry describes; `recipe` is that of hidden Markov models.
pub fn estimator(entry: &ClassifierEntry, recipe: &Recipe) -> Box<dyn Estimator> {
    match entry.method {
        Method::Hmm => Box::new(Recipe {
            states: entry.states.unwrap_or(recipe.states),
            features: features(&entry.features),
            ..recipe.clone()
        }),
        Method::NearestNeighbours => Box::new(NearestNeighbours::default()),
        Method::NaiveBayes => Box::new(NaiveBayes::default()),
        Method::EchoStateNetwork => Box::new(EchoStateNetwork::default()),
        Method::LogisticRegression if entry.features.contains(&Feature::Region) => Box::new(Logistic::default()),
        Method::LogisticRegression => Box::new(Logistic {
            features: FeatureSet::FORCE_AND_MOTION,
            ..Logistic::default()
        }),
    }
}
