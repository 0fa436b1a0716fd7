//! Hidden Markov models with one full-covariance Gaussian per state.
//!
//! [`HmmParameters`] are the numbers as they appear in a file. [`GaussianHmm::new`] checks them, so every model is
//! valid. [`train()`] fits models by Baum-Welch. A [`Scorer`] is a model prepared for scoring: it scores whole
//! sequences, and a `FilterBank` follows streams sample by sample with the same code.

mod filter;
mod gaussian;
mod model;
mod start;
mod statistics;
mod tile;
mod topology;
mod train;

pub(crate) use filter::FilterBank;
pub use filter::{ScoreKind, Scorer};
pub use model::{GaussianHmm, HmmParameters, ParameterError};
pub use start::equal_slice_start;
pub use topology::{InitialDistribution, Topology};
pub use train::{Stop, TrainingError, TrainingHistory, TrainingOptions, train};
