//! The paper's Table I, written down independently of the experiment file that holds it.

use underbrush_classifier::feature::FeatureSet;

use crate::definition::Unit::{self, Component, Taxel};

const FORCE: FeatureSet = FeatureSet::FORCE;
const FORCE_AND_MOTION: FeatureSet = FeatureSet::FORCE_AND_MOTION;

/// Table I of Bhattacharjee, Kapusta, Rehg, Kemp 2013: two-fold cross-validation accuracy in per cent, by unit,
/// features and number of hidden states, in the order in which it is printed.
pub const TABLE_ONE_PAPER: [(Unit, FeatureSet, usize, f64); 12] = [
    (Component, FORCE, 5, 61.76),
    (Component, FORCE, 10, 72.22),
    (Component, FORCE, 20, 70.75),
    (Component, FORCE_AND_MOTION, 5, 54.41),
    (Component, FORCE_AND_MOTION, 10, 55.55),
    (Component, FORCE_AND_MOTION, 20, 58.50),
    (Taxel, FORCE, 5, 72.91),
    (Taxel, FORCE, 10, 80.24),
    (Taxel, FORCE, 20, 81.40),
    (Taxel, FORCE_AND_MOTION, 5, 70.22),
    (Taxel, FORCE_AND_MOTION, 10, 71.98),
    (Taxel, FORCE_AND_MOTION, 20, 73.47),
];
