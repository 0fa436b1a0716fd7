//! Thresholds chosen from the training data, and what any threshold would do.

use std::collections::BTreeMap;

use underbrush_classifier::HmmClassifier;
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::{
    ChosenThresholds, FoldBy, Folds, RocCurve, ThresholdTargets, category_roc, choose_thresholds, cross_validate,
    evaluate, outlier_roc,
};
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::Trial;

use crate::campaign::Trials;
use crate::data;
use crate::error::ExperimentError;
use crate::reaches::Found;

/// Chosen thresholds and the curves.
pub struct Thresholds {
    /// Why there are none is a sentence.
    pub chosen: Result<ChosenThresholds, String>,
    /// Leaf against trunk on held-out training trials.
    pub category_roc: Option<RocCurve>,
    /// The outlier against leaf and trunk, on the trials of the outlier reaches: no part in any choice.
    pub outlier_roc: Option<RocCurve>,
}

/// Chooses thresholds on taxel trials held out by whole reaches; the outlier reaches only show what comes of it.
pub fn choose(taxel_trials: &[Trial], models: &HmmClassifier, outlier: &Found) -> Result<Thresholds, ExperimentError> {
    let folds = Folds {
        count: 2,
        by: FoldBy::Reach,
    };
    let argmax = Decision::argmax();
    let held_out = cross_validate(taxel_trials, &Recipe::authors(), folds, &argmax)?;
    let targets = ThresholdTargets {
        false_positive_rate: data::FALSE_POSITIVE_RATE,
        outlier_prior: data::OUTLIER_PRIOR,
    };
    let chosen = choose_thresholds(&held_out, &BTreeMap::new(), targets).map_err(|error| error.to_string());
    let mut trials = Trials::default();
    for (place, recording) in outlier.reaches.iter().enumerate() {
        trials.append(place, Trials::cut(recording, &data::trial_options())?);
    }
    let outlier_roc = match trials.taxel.iter().any(|trial| trial.category.is_some()) {
        false => None,
        true => {
            let judge = argmax.prepare(&models.categories())?;
            // No trial is left uncertain: the smallest margins are called outliers, up to every threshold.
            outlier_roc(&evaluate(models, &trials.taxel, &argmax)?, &judge, 0.0)
        }
    };
    Ok(Thresholds {
        chosen,
        category_roc: category_roc(&held_out, "leaf"),
        outlier_roc,
    })
}
