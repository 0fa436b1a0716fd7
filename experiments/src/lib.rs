//! Experiments: from scenes to reaches, trials, classifiers and figures, as typed results.
//!
//! An experiment file ([`definition`]) says what to train and test on. A [`session`] runs it: training data
//! ([`training`]), test reaches ([`reaches`]), models and online verdicts are computed once and shared, and each file
//! in [`experiment`] makes one figure or table from them. [`benchmark`] judges models and controllers on frozen scenes.
//! Nothing here prints or draws; [`Progress`] reports how a run is going.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod accuracy;
pub mod audit;
pub mod benchmark;
pub mod contact_trials;
pub mod dataset;
pub mod definition;
pub mod experiment;
pub mod files;
pub mod frame_verdicts;
pub mod inspection;
pub mod model_data;
pub mod online_models;
mod progress;
pub mod reach_ends;
pub mod reaches;
pub mod resampled;
pub mod result_cache;
pub mod results;
pub mod run_folder;
pub mod session;
mod source;
pub mod suite;
pub mod table_cell;
pub mod thresholds;
pub mod torque_balance;
pub mod training;
pub mod verdict_controller;
pub mod verdict_transfer;
mod warnings;

pub use accuracy::Accuracy;
pub use dataset::Campaign;
pub use definition::{Experiment, Unit};
pub use progress::{Counter, Progress, Silent};
pub use results::Results;
pub use session::Session;
pub use table_cell::{Cell, CellKey, unit_name};
pub use verdict_controller::VerdictControl;
pub use warnings::show_warnings;

#[cfg(test)]
mod tests;
