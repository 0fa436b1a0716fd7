//! One contact trial: what one taxel (or one connected component) felt from contact to break.

use serde::{Deserialize, Serialize};

/// One sample of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s; since the start of the reach in data sets, any origin in foreign tables.
    pub time_s: f64,
    /// Sensed force, N: of the taxel, or the largest in the component.
    pub force_n: f64,
    /// Contact motion, m: how far the contact has travelled in the world frame since it began, along its path. `None`
    /// where a table has none.
    pub motion_m: Option<f64>,
    /// The contact region that this sample is part of. `None` where a table has none, or the patch has no grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
}

/// A contact region (paper, section III) at one instant: the taxels in contact that hang together, whatever presses them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Number of its taxels.
    pub taxels: u32,
    /// The largest sensed force of its taxels, N.
    pub largest_force_n: f64,
    /// The sum of the sensed forces of its taxels, N.
    pub force_sum_n: f64,
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
