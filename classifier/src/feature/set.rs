//! Ordered lists of features: the input of one classifier.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use underbrush_recording::{Sample, Trial};

use super::error::{FeatureError, SampleFault};
use super::list::{CHANNEL, FEATURES, FORCE, Feature, MOTION};
use super::observations::Observations;

/// The features that a classifier uses, in order: one or more, each listed once.
///
/// As text, the names are joined by `+`, as in `force+motion`. Commas are read as well. `column:NAME` is the column NAME of a
/// table of trials, whatever it holds; NAME has neither `+` nor `,`.
///
/// ```
/// use underbrush_classifier::feature::FeatureSet;
///
/// let features: FeatureSet = "force,area".parse()?;
/// assert_eq!(features.columns(), ["force_n", "region_taxels"]);
/// assert_eq!(features.to_string(), "force+area");
/// # Ok::<(), underbrush_classifier::feature::FeatureError>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct FeatureSet {
    /// The features come first, then `None`.
    features: [Option<&'static Feature>; MOST],
}

/// Most features of a set.
const MOST: usize = 24;

impl FeatureSet {
    /// Force alone, N (paper, section IV-C and IV-D).
    pub const FORCE: FeatureSet = FeatureSet::new([&FORCE]);
    /// Force, N, and contact motion, m (paper, section IV-C and IV-D).
    pub const FORCE_AND_MOTION: FeatureSet = FeatureSet::new([&FORCE, &MOTION]);

    /// A set that is known when the program is compiled. The caller makes sure that no feature is listed twice.
    pub(crate) const fn new<const N: usize>(listed: [&'static Feature; N]) -> Self {
        let mut features = [None; MOST];
        let mut index = 0;
        while index < N {
            features[index] = Some(listed[index]);
            index += 1;
        }
        FeatureSet { features }
    }

    /// The set of features with these names or columns, in this order.
    ///
    /// # Errors
    /// [`FeatureError`] if a name is unknown or given twice, or there is none.
    pub fn from_names<S: AsRef<str>>(names: &[S]) -> Result<FeatureSet, FeatureError> {
        let mut features = [None; MOST];
        for (index, name) in names.iter().enumerate() {
            let name = name.as_ref();
            let feature = Feature::find(name).ok_or_else(|| FeatureError::Unknown(name.to_owned()))?;
            if features.contains(&Some(feature)) {
                return Err(FeatureError::Repeated(feature.name));
            }
            *features.get_mut(index).ok_or(FeatureError::TooMany(MOST))? = Some(feature);
        }
        match features[0] {
            None => Err(FeatureError::NoFeatures),
            Some(_) => Ok(FeatureSet { features }),
        }
    }

    /// The built-in features that every sample of these trials has; `None` if there are none.
    pub fn of_all<'a>(trials: impl IntoIterator<Item = &'a Trial> + Clone) -> Option<FeatureSet> {
        let samples = || trials.clone().into_iter().flat_map(|trial| &trial.samples);
        let has = |feature: &&&Feature| samples().all(|sample| feature.read(sample).is_some());
        let names: Vec<&str> = FEATURES.iter().filter(has).map(|feature| feature.name).collect();
        FeatureSet::from_names(&names).ok()
    }

    /// The features in order.
    pub fn iter(&self) -> impl Iterator<Item = &'static Feature> {
        self.features.iter().map_while(|feature| *feature)
    }

    /// Names as on the command line.
    pub fn names(&self) -> Vec<&'static str> {
        self.iter().map(|feature| feature.name).collect()
    }

    /// Names as in model files: the columns of trial tables, and channels as `column:NAME`.
    pub fn columns(&self) -> Vec<&'static str> {
        self.iter().map(Feature::key).collect()
    }

    /// Number of features.
    pub fn dimension(&self) -> usize {
        self.iter().count()
    }

    /// Whether a feature is in the set.
    pub fn contains(&self, feature: &Feature) -> bool {
        self.iter().any(|own| own == feature)
    }

    /// The channels, which only tables of trials have.
    pub fn channels(&self) -> impl Iterator<Item = &'static Feature> {
        self.iter().filter(|feature| feature.is_channel())
    }

    /// The features that describe the contact region.
    pub fn of_region(&self) -> impl Iterator<Item = &'static Feature> {
        self.iter().filter(|feature| feature.of_region)
    }

    /// Reads the features of one sample into `values`, which has [`FeatureSet::dimension`] places. Every classifier
    /// reads its samples here. Nothing is allocated.
    ///
    /// # Errors
    /// [`SampleFault`] if the sample lacks a feature, or one is NaN or infinite.
    pub fn read(&self, sample: &Sample, values: &mut [f64]) -> Result<(), SampleFault> {
        for (feature, place) in self.iter().zip(values) {
            let value = feature.read(sample).ok_or(SampleFault::Missing(feature))?;
            *place = SampleFault::finite(feature.column, value)?;
        }
        Ok(())
    }

    /// Checks values that were read and then scaled, which can make one infinite.
    ///
    /// # Errors
    /// [`SampleFault::NotFinite`] for the first that is.
    pub(crate) fn check_scaled(&self, values: &[f64]) -> Result<(), SampleFault> {
        let mut scaled = self.iter().zip(values);
        scaled.try_for_each(|(feature, value)| SampleFault::finite(feature.column, *value).map(|_| ()))
    }

    /// Appends the features of one sample to those of the samples before it, unless there are `window` samples already.
    /// Returns whether it did.
    ///
    /// # Errors
    /// As [`FeatureSet::read`]; `samples` then stays as it was.
    pub(crate) fn push_within(
        &self,
        window: usize,
        samples: &mut Vec<f64>,
        sample: &Sample,
    ) -> Result<bool, SampleFault> {
        let (length, dimension) = (samples.len(), self.dimension());
        if length == window * dimension {
            return Ok(false);
        }
        samples.resize(length + dimension, 0.0);
        let read = self.read(sample, &mut samples[length..]);
        if read.is_err() {
            samples.truncate(length);
        }
        read.map(|()| true)
    }

    /// The observation matrix of a trial, or of its first `max_samples` samples (paper, section V-C).
    ///
    /// # Errors
    /// [`FeatureError`] if the trial is empty, lacks a feature, or holds NaN or infinity.
    pub fn observations(&self, trial: &Trial, max_samples: Option<usize>) -> Result<Observations, FeatureError> {
        let count = trial.samples.len().min(max_samples.unwrap_or(usize::MAX));
        if count == 0 {
            return Err(FeatureError::Empty(trial.trial));
        }
        let dimension = self.dimension();
        let mut values = vec![0.0; count * dimension];
        let rows = values.chunks_exact_mut(dimension);
        for (index, (sample, row)) in trial.samples.iter().zip(rows).enumerate() {
            self.read(sample, row).map_err(|fault| fault.at(trial, index))?;
        }
        Observations::new(dimension, values)
    }
}

impl fmt::Display for FeatureSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.names().join("+"))
    }
}

impl fmt::Debug for FeatureSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl FromStr for FeatureSet {
    type Err = FeatureError;

    fn from_str(text: &str) -> Result<Self, FeatureError> {
        let names: Vec<&str> = text.split([',', '+']).map(str::trim).collect();
        FeatureSet::from_names(&names)
    }
}

impl Serialize for FeatureSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for FeatureSet {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(D::Error::custom)
    }
}

/// All names and columns of features.
fn known_names() -> Vec<&'static str> {
    FEATURES.into_iter().flat_map(|feature| [feature.name, feature.column]).collect()
}

/// The JSON Schema of a list of features that [`FeatureSet::from_names`] reads.
pub(crate) fn feature_list_schema(_: &mut SchemaGenerator) -> Schema {
    let names = known_names();
    let channel = json_schema!({ "type": "string", "pattern": format!("^{CHANNEL}[^+,]+$") });
    let item = json_schema!({ "anyOf": [{ "enum": names }, channel] });
    json_schema!({ "type": "array", "items": item, "minItems": 1, "uniqueItems": true })
}

impl JsonSchema for FeatureSet {
    fn schema_name() -> Cow<'static, str> {
        "FeatureSet".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let name = format!(r"\s*({}|{CHANNEL}[^+,]+)\s*", known_names().join("|"));
        json_schema!({
            "description": "One or more features, none twice, joined by `+`.",
            "type": "string",
            "pattern": format!("^{name}([+,]{name})*$"),
        })
    }
}
