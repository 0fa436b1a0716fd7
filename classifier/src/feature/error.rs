//! Errors in the input of a classifier: in samples, trials and lists of features.

use thiserror::Error;
use underbrush_recording::{TRIAL_COLUMNS, Trial};

use super::list::{FEATURES, Feature};

/// Why a sample cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SampleFault {
    /// The sample lacks a value.
    #[error(
        "has no {column}, which the feature {name} needs; {remedy}, or choose features without {name}",
        column = .0.column, name = .0.name, remedy = remedy(.0)
    )]
    Missing(&'static Feature),
    /// A value is NaN or infinite.
    #[error("has {column} = {value}; remove the sample or correct the value")]
    NotFinite {
        /// Column of the value in trial tables.
        column: &'static str,
        /// The value.
        value: f64,
    },
}

impl SampleFault {
    /// The value of a column, if it is finite.
    pub(crate) fn finite(column: &'static str, value: f64) -> Result<f64, Self> {
        if value.is_finite() { Ok(value) } else { Err(SampleFault::NotFinite { column, value }) }
    }

    /// The fault in a sample of a trial.
    pub(crate) fn at(self, trial: &Trial, sample: usize) -> FeatureError {
        FeatureError::BadSample { trial: trial.trial, sample, fault: self }
    }
}

fn remedy(feature: &Feature) -> String {
    if feature.of_region {
        let columns = FEATURES.into_iter().filter(|feature| feature.of_region);
        let columns: Vec<&str> = columns.map(|feature| feature.column).collect();
        format!(
            "fill the columns {} (underbrush trials writes them for a patch whose taxels form a grid)",
            columns.join(", ")
        )
    } else {
        format!("give every row a number in the column {}", feature.column)
    }
}

/// What is wrong with a trial, a matrix of observations or a list of features.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FeatureError {
    /// The trial of this number in its table has no samples.
    #[error("trial {0} has no samples; remove it from the table")]
    Empty(u64),
    /// A sample cannot be used.
    #[error("trial {trial}, sample {sample} (from 0) {fault}")]
    BadSample {
        /// Number of the trial in its table.
        trial: u64,
        /// Index of the sample in the trial.
        sample: usize,
        /// What is wrong with it.
        fault: SampleFault,
    },
    /// The length of a flat matrix is not a positive multiple of its dimension, or it holds NaN or infinity.
    #[error("{found}; observations are finite numbers, {dimension} per sample; check how the matrix was built")]
    BadMatrix {
        /// What was found.
        found: String,
        /// Expected numbers per sample.
        dimension: usize,
    },
    /// A feature with this column that never varies cannot be divided by its standard deviation.
    #[error("{0} has the same value in all samples, so it cannot be z-scored; use unscaled features or leave it out")]
    Constant(String),
    /// A name that no feature has.
    #[error("the feature {0:?} is unknown; known features are {list}", list = known())]
    Unknown(String),
    /// A feature of this name that is listed twice.
    #[error("the feature {0} is listed twice; list each feature once")]
    Repeated(&'static str),
    /// More features than this number, which is the most that a classifier can have.
    #[error("too many features are listed; list at most {0}")]
    TooMany(usize),
    /// An empty list.
    #[error("no features are listed; list at least one of {}", known())]
    NoFeatures,
}

/// The names of all features, as a list in a sentence.
fn known() -> String {
    let listed = FEATURES.map(|feature| feature.name).join(", ");
    let others: Vec<&str> = TRIAL_COLUMNS.into_iter().filter(|name| Feature::find(name).is_none()).collect();
    format!(
        "{listed}, and column:NAME for any column of a table of trials without + and comma in its name, except {}",
        others.join(", ")
    )
}
