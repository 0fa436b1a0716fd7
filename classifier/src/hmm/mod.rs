//! Hidden Markov models with one Gaussian of full covariance per state.
//!
//! [`HmmParameters`] are numbers as they stand in a file; only [`GaussianHmm::new`] turns them into a model that can
//! score and be trained, so whatever scores is known to be sound. Training is [`train()`], scores are
//! [`GaussianHmm::log_probability`] for whole sequences and [`RunningScore`] sample by sample; both run the same code.

mod bank;
mod density;
mod emission;
mod filter;
mod linear;
mod model;
mod score;
mod start;
mod statistics;
mod tile;
mod topology;
mod train;

pub(crate) use bank::FilterBank;
pub use model::{GaussianHmm, HmmParameters, ParameterError};
pub use score::{RunningScore, ScoreKind};
pub use start::equal_slice_start;
pub use topology::{InitialDistribution, Topology};
pub use train::{Stop, TrainingError, TrainingHistory, TrainingOptions, train};
