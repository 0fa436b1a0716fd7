//! One contact trial: the samples of one taxel, or one connected component, from the beginning of a contact to its end.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::limits::{self, first_outside, short};
use crate::math::median;

/// The columns of a table of contact trials in the order in which they are written. Channels follow them and have other names.
pub const TRIAL_COLUMNS: [&str; 12] = [
    "trial",
    "category",
    "reach",
    "patch",
    "taxel",
    "time_s",
    "force_n",
    "motion_m",
    "region_taxels",
    "region_largest_force_n",
    "region_force_sum_n",
    "touched",
];

/// One sample of a trial.
///
/// ```
/// use underbrush_recording::Sample;
///
/// let sample = Sample { time_s: 0.3, force_n: 1.2, ..Sample::default() };
/// assert!(sample.fault().is_none());
/// let (column, found, _) = Sample { force_n: f64::NAN, ..sample }.fault().expect("NaN is no force");
/// assert_eq!((column, found.as_str()), ("force_n", "NaN"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Time, s: since the start of the reach in data sets, from any origin in tables of other programs.
    pub time_s: f64,
    /// Sensed force of the taxel, or the largest in the component, N.
    pub force_n: f64,
    /// Contact motion, m: length of the path that the contact has travelled in the world frame since it began. `None`
    /// if a table does not have it.
    pub motion_m: Option<f64>,
    /// The contact region of this sample. `None` if a table does not have it, or the patch has no grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Ground truth: whether an object truly pressed the taxel, or a taxel of the component, in this sample. Noise,
    /// crosstalk and creep give readings without contact. `None` if unknown, as in tables of real robots. Never an
    /// input of a classifier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touched: Option<bool>,
    /// What else was measured, for tables of other robots.
    #[serde(default, skip_serializing_if = "Channels::is_empty")]
    pub channels: Channels,
}

/// Numbers that a robot measures beside the force, such as shear or temperature, by the name of their column. The project
/// knows neither their units nor their meaning.
///
/// ```
/// use underbrush_recording::Channels;
///
/// let channels: Channels = [("shear_n", 0.2), ("temperature_k", 303.1)].into_iter().collect();
/// assert_eq!(channels.get("shear_n"), Some(0.2));
/// assert_eq!(channels.get("slip_m"), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Channels(Vec<(Arc<str>, f64)>);

impl Channels {
    /// The number of the channel with this name, if the sample has one.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(own, _)| **own == *name).map(|(_, number)| *number)
    }

    /// Names and numbers, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&Arc<str>, f64)> {
        self.0.iter().map(|(name, number)| (name, *number))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a channel after the others.
    pub fn push(&mut self, name: impl Into<Arc<str>>, number: f64) {
        self.0.push((name.into(), number));
    }
}

impl<Name: Into<Arc<str>>> FromIterator<(Name, f64)> for Channels {
    fn from_iter<I: IntoIterator<Item = (Name, f64)>>(channels: I) -> Self {
        Channels(channels.into_iter().map(|(name, number)| (name.into(), number)).collect())
    }
}

/// A contact region (paper, section III) at one instant: connected taxels in contact, whichever objects press them.
///
/// ```
/// use underbrush_recording::Region;
///
/// let region = Region { taxels: 3, largest_force_n: 2.0, force_sum_n: 4.5 };
/// assert_eq!(region.fault(), None);
/// // Three taxels cannot have more than three times the largest force.
/// let impossible = Region { force_sum_n: 7.0, ..region };
/// assert!(impossible.fault().is_some_and(|(column, _)| column == "region_force_sum_n"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Number of taxels.
    pub taxels: u32,
    /// Largest sensed force of a taxel, N.
    pub largest_force_n: f64,
    /// Sum of the sensed forces, N.
    pub force_sum_n: f64,
}

/// Relative tolerance for the sum of a region's forces: room for some hundred forces added in single precision, or
/// printed with five digits.
const ROUNDING: f64 = 1e-4;

impl Sample {
    /// The first number that is out of range: its column in a trials table, what was found and what is allowed.
    pub fn fault(&self) -> Option<(&'static str, String, String)> {
        let always = [("time_s", self.time_s, limits::TIME_S), ("force_n", self.force_n, limits::FORCE_N)];
        let motion = self.motion_m.map(|motion_m| ("motion_m", motion_m, limits::MOTION_M));
        if let Some(fault) = first_outside(always.into_iter().chain(motion)) {
            return Some(fault);
        }
        if let Some((_, number)) = self.channels.iter().find(|(_, number)| !number.is_finite()) {
            return Some(("channels", number.to_string(), "finite numbers".into()));
        }
        let region = self.region?;
        let (column, allowed) = region.fault()?;
        Some((column, format!("{region:?}"), allowed))
    }
}

impl Region {
    /// The first number that is out of range: its column in a trials table, and what is allowed there.
    pub fn fault(&self) -> Option<(&'static str, String)> {
        let taxels = f64::from(self.taxels);
        let (largest, sum) = (self.largest_force_n, self.force_sum_n);
        let numbers = [
            ("region_taxels", taxels, limits::REGION_TAXELS),
            ("region_largest_force_n", largest, limits::REGION_LARGEST_FORCE_N),
            ("region_force_sum_n", sum, limits::REGION_FORCE_SUM_N),
        ];
        if let Some((column, _, allowed)) = first_outside(numbers) {
            return Some((column, allowed));
        }
        let max_sum = largest * taxels;
        let holds = sum >= largest * (1.0 - ROUNDING) && sum <= max_sum * (1.0 + ROUNDING);
        (!holds).then(|| {
            let (largest, most) = (short(largest), short(max_sum));
            let bound = format!("between the largest force and {} times that, one for each taxel", self.taxels);
            let allowed = format!("{largest} to {most} N: {bound}");
            ("region_force_sum_n", allowed)
        })
    }
}

/// One trial (paper, sections IV-C and IV-D): the unit of training and classification.
///
/// ```
/// use underbrush_recording::{Sample, Trial};
///
/// let sample = |time_s, touched| Sample { time_s, force_n: 0.5, touched, ..Sample::default() };
/// let trial = Trial { samples: vec![sample(0.0, Some(false)), sample(0.01, None)], ..Trial::default() };
/// // The second sample may have been a contact.
/// assert_eq!(trial.touched(), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Number of the trial in its table.
    pub trial: u64,
    /// Ground truth. In tables of other programs, any name but [`crate::Category::UNCERTAIN`]; `None` if unknown.
    pub category: Option<String>,
    /// Index of the reach that it comes from, for grouping by reach.
    pub reach: Option<u64>,
    /// Name of the skin patch.
    pub patch: Option<String>,
    /// Index of the taxel in its patch. For a component: of the taxel with the largest force at first contact.
    pub taxel: Option<u32>,
    /// The samples in order of time; never empty.
    pub samples: Vec<Sample>,
}

impl Trial {
    /// Ground truth: whether there was true contact in at least one sample. `None` if that is unknown: no sample is
    /// known to be in contact, and for at least one it is not known.
    pub fn touched(&self) -> Option<bool> {
        let any = |touched| self.samples.iter().any(|sample| sample.touched == touched);
        match (any(Some(true)), any(None)) {
            (true, _) => Some(true),
            (false, true) => None,
            (false, false) => Some(false),
        }
    }
}

/// The median time between two samples of a trial, s; `None` if no trial has two.
pub fn period_s<'a>(trials: impl IntoIterator<Item = &'a Trial>) -> Option<f64> {
    let pairs = trials.into_iter().flat_map(|trial| trial.samples.windows(2));
    median(pairs.map(|pair| pair[1].time_s - pair[0].time_s).collect())
}
