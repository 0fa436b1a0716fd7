//! Classifiers as an experiment file names them.

use underbrush_classifier::estimator::Estimator;
use underbrush_classifier::recipe::Recipe;

use crate::definition::{ClassifierEntry, Experiment, RecipeName, is_hmm};

/// The recipe with this name.
pub fn recipe(name: RecipeName) -> Recipe {
    match name {
        RecipeName::Authors => Recipe::authors(),
        RecipeName::Modern => Recipe::modern(),
    }
}

/// The experiment's first recipe, which is used wherever there is only one.
pub fn main_recipe(experiment: &Experiment) -> Recipe {
    recipe(main_recipe_name(experiment))
}

/// The name of the experiment's first recipe.
pub fn main_recipe_name(experiment: &Experiment) -> RecipeName {
    experiment.file.recipes.first().copied().unwrap_or(RecipeName::Authors)
}

/// The classifier that an entry describes; `recipe` is for hidden Markov models.
pub fn estimator(entry: &ClassifierEntry, recipe: &Recipe) -> Box<dyn Estimator> {
    if !is_hmm(entry) {
        return (entry.method.estimator)(entry.features);
    }
    Box::new(Recipe {
        states: entry.states.unwrap_or(recipe.states),
        features: entry.features.unwrap_or(recipe.features),
        ..recipe.clone()
    })
}
