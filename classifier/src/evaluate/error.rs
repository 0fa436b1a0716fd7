//! Why an evaluation fails.

use thiserror::Error;

use crate::decision::DecisionError;
use crate::error::ModelError;

/// Why an evaluation fails.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EvaluateError {
    /// A classifier cannot be fitted or applied.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Priors or thresholds are invalid.
    #[error(transparent)]
    Decision(#[from] DecisionError),
    /// Cross-validation needs at least two folds.
    #[error("{found} folds; cross-validation needs at least 2")]
    FoldCount {
        /// The number asked for.
        found: usize,
    },
    /// A category is too small to be in every fold.
    #[error(
        "category {category} {}, fewer than the {folds} folds; {}",
        counted(*found, unit),
        remedy(*folds, unit)
    )]
    TooFew {
        /// The category.
        category: String,
        /// How many there are.
        found: usize,
        /// What was counted: trials or reaches.
        unit: &'static str,
        /// Folds requested.
        folds: usize,
    },
    /// Folds by reach need every trial's reach.
    #[error("trial {trial} names no reach; fill the column reach, or group by position")]
    NoReach {
        /// Number of the trial in its table.
        trial: u64,
    },
    /// A fold by reach holds all trials of a category.
    #[error(
        "without fold {fold} of {folds}, only {} of the categories {} are left to fit to; {remedy}",
        left.join(", "),
        all.join(", ")
    )]
    FewCategories {
        /// The fold that is tested, from 1.
        fold: usize,
        /// Number of folds.
        folds: usize,
        /// The categories that are left.
        left: Vec<String>,
        /// All categories.
        all: Vec<String>,
        /// What can be done.
        remedy: &'static str,
    },
    /// More folds of whole reaches than reaches.
    #[error("{reaches} {unit} are fewer than the {folds} folds; use {}more {unit}", if *reaches < 2 { "" } else { "fewer folds or " })]
    FewReaches {
        /// Number of reaches.
        reaches: usize,
        /// What was counted: reaches or auxiliary reaches.
        unit: &'static str,
        /// Number of folds.
        folds: usize,
    },
    /// A fold leaves no trial of a category that is long enough to fit on.
    #[error(
        "without fold {fold}, no trial of category {category} has the {samples} samples required for \
         fitting; lower the required length or use more data"
    )]
    TooShort {
        /// The category.
        category: String,
        /// The fold that is tested, from 1.
        fold: usize,
        /// Samples required of a trial for fitting.
        samples: usize,
    },
    /// There is nothing to evaluate on.
    #[error("none of the trials has a category; use trials with ground truth")]
    NoTruth,
}

fn counted(found: usize, unit: &str) -> String {
    let (has, one) = if unit == "reaches" { ("is in", "reach") } else { ("has", "trial") };
    format!("{has} {found} {}", if found == 1 { one } else { unit })
}

/// Thresholds are chosen on two folds if there is little data, and only an evaluation lets the user choose the folds.
fn remedy(folds: usize, unit: &str) -> String {
    let data = if folds <= 2 { "use more data" } else { "use fewer folds or more data" };
    let position = if unit == "reaches" { "; an evaluation can also group by position" } else { "" };
    format!("{data}{position}")
}
