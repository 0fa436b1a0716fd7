//! Features: the numbers that a classifier uses of each sample.
//!
//! [`FEATURES`] lists all of them, with name, unit and how each is read. A [`FeatureSet`] is an ordered choice from
//! that list. All classifiers read samples through [`FeatureSet::read`], which checks them.

mod error;
mod list;
mod observations;
mod set;

pub use error::{FeatureError, SampleFault};
pub use list::{AREA, FEATURES, FORCE, Feature, MOTION, REGION_FORCE_SUM, REGION_MAX_FORCE};
pub use observations::{Observations, Scaling};
pub use set::FeatureSet;
pub(crate) use set::feature_list_schema;

#[cfg(test)]
mod tests;
