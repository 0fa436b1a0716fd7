//! One contact trial: what one taxel (or one connected component) felt from contact to break.

use serde::{Deserialize, Serialize};

/// One sample of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s; since the start of the reach in data sets, any origin in foreign tables.
    pub time_s: f64,
    /// Sensed force, N: of the taxel, or the largest in the component.
    pub force_n: f64,
    /// Contact motion, m: distance in the world frame from where the contact began. `None` where a table has none.
    pub motion_m: Option<f64>,
}

/// One trial (paper, sections IV-C and IV-D): the unit that is trained on and classified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number of the trial in its table.
    pub trial: u64,
    /// Ground truth; any name in foreign tables, `None` where unknown.
    pub category: Option<String>,
    /// Index of the reach it comes from, for splits by reach.
    pub reach: Option<u64>,
    /// Name of the skin patch.
    pub patch: Option<String>,
    /// Index of the taxel in its patch; for a component, of its strongest taxel at first contact.
    pub taxel: Option<u32>,
    /// The samples in time order, never empty.
    pub samples: Vec<Sample>,
}
