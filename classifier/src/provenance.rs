//! Where a model comes from.

use std::collections::BTreeMap;
use std::fmt::Display;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use underbrush_recording::FRAME_PERIOD_S;

use crate::trial::Unit;

/// Where a model comes from. A file may hold further keys, for instance of a user's own.
///
/// ```
/// use underbrush_classifier::Provenance;
///
/// let provenance: Provenance = serde_json::from_str(r#"{ "program": "mine 1.0", "robot": "left arm" }"#)?;
/// assert_eq!(provenance.program.as_deref(), Some("mine 1.0"));
/// // Keys of a user's own are kept.
/// assert_eq!(provenance.further["robot"], "left arm");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Name and version of the program that trained the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// Options of the training that are not elsewhere in the file, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub options: BTreeMap<String, Value>,
    /// The data that the model was fitted to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub data: Vec<DataSource>,
    /// Further keys.
    #[serde(flatten)]
    pub further: BTreeMap<String, Value>,
}

/// How much the rate of frames may differ from that of a model's data, relatively.
const RATE_TOLERANCE: f64 = 0.1;

/// Whether two rates differ by more than the tolerance.
fn differ((own_hz, rate_hz): (f64, f64)) -> bool {
    (rate_hz / own_hz - 1.0).abs() > RATE_TOLERANCE
}

/// A rate as it is printed, Hz.
fn shown(rate_hz: f64) -> f64 {
    (100.0 * rate_hz).round() / 100.0
}

impl Provenance {
    /// Warns if frames come at another rate, Hz, than all data that the model was fitted to, and says whether it did. `subject`
    /// names the frames. Nothing is said if either rate is unknown.
    pub fn warn_of_rate(&self, subject: impl Display, rate_hz: Option<f64>) -> bool {
        let mut rates = self.data.iter().filter_map(|data| data.known_rate_hz().zip(rate_hz));
        let Some((own, rate)) = rates.clone().next().filter(|_| rates.all(differ)) else { return false };
        let [own, rate] = [own, rate].map(shown);
        log::warn!(
            "warning: {subject}: frames at {rate} Hz, but the model was fitted to frames at {own} Hz; classifiers count \
             samples, so do not trust its verdicts here; use a model that was fitted to data of this rate"
        );
        true
    }

    /// Warns, as [`Self::warn_of_rate`], of the first of these data that has another rate.
    pub fn warn_of_rates(&self, subject: impl Display, data: &[DataSource]) {
        for own in data {
            if self.warn_of_rate(&subject, own.known_rate_hz()) {
                return;
            }
        }
    }

    /// Warns if trials, called `subject`, are made of something else than those that the model was fitted to. Nothing is said if
    /// either is unknown.
    pub fn warn_of_unit(&self, subject: impl Display, unit: Option<Unit>) {
        let fitted = self.options.get("by").and_then(Value::as_str);
        let (Some(own), Some(fitted)) = (unit.map(Unit::name), fitted) else { return };
        if own != fitted {
            log::warn!(
                "warning: {subject}: trials by {own}, but the model was fitted to trials by {fitted}, so do not trust its verdicts \
                 here; use trials by {fitted}"
            );
        }
    }

    /// Warns if the data that the model was fitted to have several rates.
    pub fn warn_of_several_rates(&self) {
        let mut rates = self.data.iter().filter_map(DataSource::known_rate_hz);
        let Some(first) = rates.next() else { return };
        if let Some(other) = rates.find(|rate| differ((first, *rate))) {
            let [first, other] = [first, other].map(shown);
            log::warn!(
                "warning: the model is fitted to frames at {first} Hz and at {other} Hz; classifiers count samples, so use data of \
                 one rate"
            );
        }
    }
}

/// Data that a model was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DataSource {
    /// What the data are.
    pub kind: DataKind,
    /// Name of the folder or file, without the folders that it is in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// BLAKE3 hash, hexadecimal: of a file; of a data set's frames and ground truth, as `inspect` shows it; or of the
    /// numbers of what was in memory.
    pub blake3: String,
    /// Seed of the reaches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Number of reaches of each scene.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reaches: BTreeMap<String, usize>,
    /// Frames per second, Hz; for a table of trials by the median time between two samples. Unknown for what was in memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
}

impl DataSource {
    /// Frames per second, Hz. Models of early builds do not say it of data sets, which all have the rate of the simulation.
    fn known_rate_hz(&self) -> Option<f64> {
        self.rate_hz.or((self.kind == DataKind::DataSet).then_some(1.0 / FRAME_PERIOD_S))
    }
}

/// A kind of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DataKind {
    /// A data set.
    DataSet,
    /// A recording.
    Recording,
    /// A table of trials.
    Trials,
}
