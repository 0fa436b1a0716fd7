//! classifier
pub mod decision;
pub mod feature;
pub mod hmm;
mod model_file;
mod model_set;
mod recipe;
pub use model_set::{ModelError, ModelSet, TrainingReport, is_trained};
pub use recipe::*;
