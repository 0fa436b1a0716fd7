//! One contact trial: what one taxel (or one connected component) felt from contact to break.

use serde::{Deserialize, Serialize};

use crate::limits::{self, Limits, short};

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
    /// Ground truth: whether an object truly pressed the taxel, or one of the component's taxels, in this sample. A
    /// sensor also reports forces where nothing touches it (noise, crosstalk, creep). `None` where unknown, as in tables
    /// of real robots. No model sees it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touched: Option<bool>,
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

/// How far the sum of a region's forces may miss what its parts allow, relative: some hundred forces added up in single
/// precision, or printed with five digits.
const ROUNDING: f64 = 1e-4;

impl Sample {
    /// What is wrong with the numbers, if anything: the column in a trials table, what was found and what is allowed.
    pub fn fault(&self) -> Option<(&'static str, String, String)> {
        let numbers: [(&'static str, Option<f64>, Limits); 3] = [
            ("time_s", Some(self.time_s), limits::TIME_S),
            ("force_n", Some(self.force_n), limits::FORCE_N),
            ("motion_m", self.motion_m, limits::MOTION_M),
        ];
        for (column, value, limits) in numbers {
            if let Some(value) = value
                && !limits.hold(value)
            {
                return Some((column, short(value), limits.to_string()));
            }
        }
        let region = self.region?;
        let (column, allowed) = region.fault()?;
        Some((column, format!("{region:?}"), allowed))
    }
}

impl Region {
    /// What is wrong with the numbers, if anything: the column in a trials table and what is allowed there.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        let taxels = f64::from(self.taxels);
        let (largest, sum) = (self.largest_force_n, self.force_sum_n);
        for (column, value, limits) in [
            ("region_taxels", taxels, limits::REGION_TAXELS),
            ("region_largest_force_n", largest, limits::REGION_LARGEST_FORCE_N),
            ("region_force_sum_n", sum, limits::REGION_FORCE_SUM_N),
        ] {
            if !limits.hold(value) {
                return Some((column, limits.to_string()));
            }
        }
        let most = largest * taxels;
        let holds = sum >= largest * (1.0 - ROUNDING) && sum <= most * (1.0 + ROUNDING);
        (!holds).then(|| {
            let allowed = format!(
                "{} to {} N: the largest force alone, or as much on each of the {} taxels",
                short(largest),
                short(most),
                self.taxels
            );
            ("region_force_sum_n", allowed)
        })
    }
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

impl Trial {
    /// Ground truth: whether an object truly pressed during at least one sample. `None` where that is unknown: where no
    /// sample is known to be touched and at least one is not known to be untouched.
    pub fn touched(&self) -> Option<bool> {
        let mut touched = Some(false);
        for sample in &self.samples {
            match sample.touched {
                Some(true) => return Some(true),
                Some(false) => {}
                None => touched = None,
            }
        }
        touched
    }
}
