//! What touches the skin: a verdict for each taxel and each contact region, in every frame, that a controller can act
//! on.
//!
//! A taxel that senses a force is touched or has a spurious reading. A region of touched taxels is pressed by something
//! of a known category, such as leaf or trunk, or by something unknown. The answers are probabilities. A decision with
//! costs turns them into verdicts ([`TouchDecision`]).
//!
//! The paper's hidden Markov models see forces and how far a contact has travelled. Here the motion of the skin along
//! its own normal counts as well: how far an object gives way under a force tells a leaf from a trunk, at any stiffness
//! or speed of the arm.
//!
//! | step | where |
//! |---|---|
//! | taxels in contact form regions, followed from frame to frame | [`Region`], [`SkinTracker`] |
//! | the course of a contact becomes features | [`REGION_FEATURES`], [`TaxelCourse::NAMES`] |
//! | contacts of one place are one object; unlike what is known, it is unknown | [`ObjectTracker`], [`UnknownObjects`] |
//! | networks are fitted to recordings with ground truth, and calibrated | [`TouchExamples`] |
//! | frames become verdicts | [`TouchClassifier`] |

mod batch_scores;
mod compress;
mod contact_history;
mod decision;
mod example;
mod fit;
mod frame;
mod held_out;
mod model;
mod network;
mod object;
mod online;
mod region;
mod training_rows;

pub use contact_history::{Course, Measure, REGION_FEATURE_COUNT, REGION_FEATURES};
pub use decision::{TouchDecision, TouchVerdict};
pub use frame::{SkinTracker, TAXEL_FEATURE_COUNT, TaxelCourse, TouchOptions};
pub use held_out::{check_limit, check_share};
pub use model::{TOUCH_FORMAT, TouchModel};
pub(crate) use object::{Followed, Votes, strongest, true_displacement_m, true_stiffness_n_per_m};
pub use object::{
    Mobility, OBJECT_FEATURE_COUNT, ObjectCategories, ObjectCourse, ObjectTracker, Stiffness, StiffnessTrees,
    TouchObject, UnknownObjects,
};
pub use online::{ObjectReport, ObjectTouch, RegionTouch, TaxelTouch, TouchClassifier};
pub use region::Region;
pub use training_rows::{TouchExamples, TouchRows};

#[cfg(test)]
mod tests;
