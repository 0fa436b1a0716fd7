//! The paper's experiments and ours: from scenes to reaches, trials, classifiers and figures, as typed results.
//!
//! Nothing here prints or draws. `data` says which reaches; `campaign`, `reaches`, `online`, `thresholds`, `truncation`,
//! `classifiers`, `splits` and `ablation` measure; `comparison` compares with the paper; `kept` keeps results between
//! runs; `results` holds all numbers.
#![allow(missing_docs, reason = "the restructuring that follows documents what stays public")]

pub mod ablation;
pub mod accuracy;
pub mod analysis;
pub mod audit;
pub mod campaign;
pub mod classifiers;
pub mod comparison;
pub mod data;
pub mod dataset;
pub mod ends;
mod error;
pub mod example;
pub mod files;
pub mod kept;
pub mod measurement;
pub mod online;
pub mod plan;
mod progress;
pub mod reaches;
pub mod results;
mod sealed;
pub mod snapshot;
pub mod splits;
pub mod thresholds;
pub mod timing;
pub mod truncation;

pub use error::ExperimentError;
pub use progress::{Counter, Progress, Silent};

#[cfg(test)]
mod tests;
