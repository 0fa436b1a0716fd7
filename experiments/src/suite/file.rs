//! The keys of a suite file, with the places of bounds in its text, and the model that it names.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use toml::Spanned;
use underbrush_classifier::any_model::{self, AnyModel, OnlineModel};
use underbrush_classifier::{Decision, ModelError, Rule};
use underbrush_recording::Fault;
use underbrush_sim::controller::ControllerKind;

use super::metric::{METRICS, Metric};
use crate::files::Source;

/// The keys of a suite file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteFile {
    /// One sentence on what the suite checks.
    pub summary: String,
    /// Seed of all reaches.
    #[serde(default)]
    pub seed: u64,
    /// Controller to use instead of each scene's.
    pub controller: Option<ControllerKind>,
    /// The classifier whose verdicts are bounded.
    pub model: Option<ModelSection>,
    /// How `--bless` computes bounds.
    #[serde(default)]
    pub bless: BlessSection,
    /// The scenes.
    pub scenes: Vec<SceneEntry>,
}

/// A classifier, used online on every reach.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelSection {
    /// Model file of any classifier, relative to the suite file. A touch model has its own patch, threshold and
    /// decision.
    pub file: String,
    /// Patch of skin that is classified; the first if not given.
    pub patch: Option<String>,
    /// A taxel is in contact where its sensed force is above this, N; as for `underbrush train` and `classify` if not
    /// given.
    pub threshold_n: Option<f64>,
    /// Rule to use instead of the model's own: `"argmax"`, `{ uncertain_below = { margin = NATS } }` or
    /// `{ outlier_band = { uncertain_below = NATS, category_above = NATS } }`. A model without one uses `argmax`.
    pub rule: Option<Rule>,
}

impl ModelSection {
    /// Reads the model; `folder` is the folder of the suite file.
    pub(super) fn load(&self, folder: &Path, source: &Source) -> Result<OnlineModel, Fault> {
        let loaded = any_model::load(&folder.join(&self.file)).map_err(|error| match error {
            ModelError::Input(error) => Fault::from(source.field("model.file", &self.file).named(*error)),
            error => error.into(),
        });
        match loaded? {
            AnyModel::Touch(model) => {
                let given = [
                    ("model.patch", self.patch.is_some()),
                    ("model.threshold_n", self.threshold_n.is_some()),
                    ("model.rule", self.rule.is_some()),
                ];
                // A touch model would ignore such keys.
                if let Some((key, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
                    let allowed =
                        "no such key with a touch model, whose file has its own patch, threshold and decision";
                    return Err(source.field(key, "").fault("a value", allowed).into());
                }
                Ok(OnlineModel::Touch(Arc::from(model)))
            }
            AnyModel::OfTrials(mut model) => {
                let decision = model.decision.get_or_insert(Decision::argmax());
                decision.rule = self.rule.unwrap_or(decision.rule);
                Ok(OnlineModel::of_trials(model, self.patch.clone(), self.threshold_n))
            }
        }
    }
}

/// How `--bless` computes bounds.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BlessSection {
    /// The probability that reaches of another seed break any of the suite's bounds on means and shares.
    pub false_alarm: f64,
    /// A bound on the largest value of all reaches is this many times what was found.
    pub largest_factor: f64,
}

impl Default for BlessSection {
    /// Choices: a program that only draws other random numbers is refused once in a hundred times. A largest value, for
    /// which there is no such theory, may grow by half.
    fn default() -> Self {
        BlessSection { false_alarm: 0.01, largest_factor: 1.5 }
    }
}

/// A scene with its bounds.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneEntry {
    /// Scene: the name of one that ships, such as mixed, or a scene file, relative to the suite file.
    pub scene: String,
    /// Number of reaches: indices 0, 1, … of the suite's seed, each a draw of its own.
    pub reaches: u64,
    /// The bounds, by metric.
    #[serde(default)]
    pub bounds: Bounds,
}

/// Bounds of one number: `{ at_least = 0.7, at_most = 0.9, blessed = 0.8 }`. If both `at_least` and `at_most` are
/// missing, the next `--bless` sets them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a bound, with keys among at_least, at_most and blessed")]
pub struct Bound {
    /// Smallest value that is allowed.
    pub at_least: Option<f64>,
    /// Largest value that is allowed.
    pub at_most: Option<f64>,
    /// The value from which `--bless` computed the bounds. It does not decide anything.
    pub blessed: Option<f64>,
}

impl Bound {
    /// Whether it bounds the number on any side.
    pub(super) fn is_given(&self) -> bool {
        self.at_least.is_some() || self.at_most.is_some()
    }
}

/// The bounds of one scene, by metric.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct Bounds(pub BTreeMap<String, Spanned<Entry>>);

/// The value of a metric's key.
#[derive(Clone, Debug)]
pub enum Entry {
    /// A bound.
    Bound(Bound),
    /// A bound for each of some categories, by name.
    ByCategory(BTreeMap<String, Spanned<Bound>>),
}

impl<'de> Deserialize<'de> for Entry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EntryVisitor;
        impl<'de> Visitor<'de> for EntryVisitor {
            type Value = Entry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a bound such as { at_least = 0.7, at_most = 0.9 }, or one for each category")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entry, A::Error> {
                let (mut bound, mut categories) = (Bound::default(), BTreeMap::new());
                let mut own_keys = false;
                while let Some(key) = map.next_key::<String>()? {
                    let value = match key.as_str() {
                        "at_least" => &mut bound.at_least,
                        "at_most" => &mut bound.at_most,
                        "blessed" => &mut bound.blessed,
                        _ => {
                            categories.insert(key, map.next_value()?);
                            continue;
                        }
                    };
                    *value = Some(map.next_value()?);
                    own_keys = true;
                }
                match (own_keys, categories.keys().next()) {
                    (true, Some(key)) => Err(A::Error::unknown_field(key, &["at_least", "at_most", "blessed"])),
                    (false, Some(_)) => Ok(Entry::ByCategory(categories)),
                    (_, None) => Ok(Entry::Bound(bound)),
                }
            }
        }
        deserializer.deserialize_map(EntryVisitor)
    }
}

impl JsonSchema for Bounds {
    fn schema_name() -> Cow<'static, str> {
        "Bounds".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let bound = generator.subschema_for::<Bound>();
        let property = |metric: &Metric| {
            let own = if metric.by_category {
                json!({ "type": "object", "additionalProperties": bound, "description": metric.summary })
            } else {
                json!({ "allOf": [bound], "description": metric.summary })
            };
            (metric.name.to_owned(), own)
        };
        let properties: Map<String, Value> = METRICS.iter().map(property).collect();
        json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}
