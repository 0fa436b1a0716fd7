//! The subcommands, one file each.

pub mod arm;
pub mod arrange;
pub mod benchmark;
pub mod check;
pub mod classify;
pub mod completions;
mod estimator_arguments;
pub mod evaluate;
pub mod export;
pub mod fit_skin;
pub mod generate;
pub mod import;
pub mod inspect;
pub mod merge;
mod overwrite;
mod picture;
pub mod reach;
pub mod replay;
pub mod reproduce;
pub mod schema;
pub mod score;
mod touch;
pub mod train;
pub mod trials;
pub mod validate;
mod verdict_arguments;

pub use overwrite::Overwrite;

use estimator_arguments::EstimatorArguments;
use picture::PictureArguments;
use verdict_arguments::{DecisionArguments, VerdictArguments};
