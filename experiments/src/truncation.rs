//! Accuracy of truncated trials (paper, section V-C, Fig. 13).

use rayon::prelude::*;
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::{Folds, cross_validate};
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::Trial;

use crate::accuracy::Accuracy;
use crate::data::TRUNCATIONS;
use crate::error::ExperimentError;
use crate::results::Truncated;

/// Cross-validates taxels by force with 10 and 20 states on whole trials and on ever shorter ones.
pub fn run(taxel_trials: &[Trial]) -> Result<Vec<Truncated>, ExperimentError> {
    let lengths = std::iter::once(None).chain(TRUNCATIONS.into_iter().map(Some));
    let cases: Vec<(usize, Option<usize>)> = lengths.flat_map(|most| [(10, most), (20, most)]).collect();
    let found: Vec<Result<Truncated, ExperimentError>> = cases
        .into_par_iter()
        .map(|(states, max_samples)| {
            let recipe = Recipe {
                states,
                max_samples,
                ..Recipe::authors()
            };
            let evaluation = cross_validate(taxel_trials, &recipe, Folds::paper(), &Decision::argmax())?;
            Ok(Truncated {
                states,
                max_samples,
                accuracy: Accuracy::of(&evaluation),
            })
        })
        .collect();
    found.into_iter().collect()
}
