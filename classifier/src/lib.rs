//! classifier
pub mod decision;
pub mod feature;
pub mod hmm;
mod model_file;
mod model_set;
pub mod online;
pub mod recipe;
pub mod trial;
pub use model_set::{ModelError, ModelSet, TrainingReport, is_trained};
