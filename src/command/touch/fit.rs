//! Fitting touch models to reaches.

use std::path::PathBuf;

use underbrush_classifier::ModelError;
use underbrush_classifier::touch::{RiskLimits, TouchExamples, TouchModel, TouchOptions};

use crate::failure::Failure;

/// A model fitted to these rows.
pub(super) fn fit(
    examples: &TouchExamples,
    options: &TouchOptions,
    limits: &RiskLimits,
) -> Result<TouchModel, Failure> {
    examples.fit_within(limits).map_err(|error| match error {
        ModelError::NoCategories { .. } => {
            let patch = options.patch.as_ref();
            let patch = patch.map_or("the first patch".into(), |name| format!("patch {name}"));
            Failure::usage(format!(
                "nothing of a category to fit, such as leaf or trunk, touches {patch} above {} N in {} reaches (blocks and \
                 outliers are never fitted); lower --threshold-n, choose another --patch, or generate more reaches",
                options.threshold_n,
                examples.rows().reaches
            ))
        }
        other => other.into(),
    })
}

/// Adds the path of the input to a failure, if there is only one input.
pub(super) fn about(failure: Failure, paths: &[PathBuf]) -> Failure {
    match paths {
        [path] => failure.about(path),
        _ => failure,
    }
}
