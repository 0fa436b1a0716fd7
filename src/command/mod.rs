//! The subcommands, one file each.

pub mod arrange;
pub mod benchmark;
pub mod check;
pub mod classify;
mod dataset_summary;
mod decision_arguments;
mod estimator_arguments;
pub mod evaluate;
pub mod export;
pub mod fit_skin;
pub mod generate;
pub mod import;
pub mod inspect;
pub mod merge;
mod overwrite;
mod pictures;
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
mod watched;
