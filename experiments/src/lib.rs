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
pub mod reaches;
pub mod resampled;
pub mod results;
pub mod run_folder;
pub mod session;
pub mod suite;
pub mod table_cell;
pub mod torque_balance;
pub mod training;
pub mod verdict_controller;

pub use accuracy::Accuracy;
pub use dataset::Campaign;
pub use definition::{Experiment, Unit};
pub use progress::{Counter, Progress, Silent, show_warnings};
pub use results::Results;
pub use session::Session;
pub use table_cell::{Cell, CellKey};
pub use verdict_controller::VerdictControl;

use session::in_parallel;

#[cfg(test)]
mod tests;
