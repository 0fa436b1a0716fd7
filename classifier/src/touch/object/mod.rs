//! Objects: contacts of one place, on any patch, belong to one object, which is the unit of the verdict `unknown`.
//!
//! | step | where |
//! |---|---|
//! | contacts that begin near each other are one object | [`ObjectTracker`] |
//! | the course of an object becomes features | [`ObjectCourse`], [`Fit`](fit::Fit), [`Response`](response::Response) |
//! | which known category it is | [`ObjectCategories`] |
//! | boosted trees for each category, and for each family of auxiliary unknown objects | [`Boosted`](crate::boosted::Boosted) |
//! | how stiff it is, and whether it gives way | [`Stiffness`], [`StiffnessTrees`], [`Mobility`] |
//! | scores become the share of known objects that are as unlike | [`UnknownObjects`] |

mod category;
mod course;
mod fit;
mod resistance;
mod response;
mod stiffness;
#[cfg(test)]
mod tests;
mod tracker;
mod training;
mod truth;
mod unknown;

pub use category::ObjectCategories;
pub use course::{OBJECT_FEATURE_COUNT, ObjectCourse};
pub use resistance::{Mobility, Stiffness};
pub use stiffness::StiffnessTrees;
pub use tracker::{ObjectTracker, TouchObject};
pub(super) use training::{ObjectExample, Open, fit_objects};
pub(super) use truth::add_votes;
pub(crate) use truth::{Followed, Votes, strongest, true_displacement_m, true_stiffness_n_per_m};
pub use unknown::UnknownObjects;
pub(super) use unknown::stage;
