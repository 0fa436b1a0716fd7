//! Bounds as a suite file writes them, with their places in its text.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde_json::{Map, Value, json};
use toml::Spanned;

use super::metric::METRICS;

/// Bounds of one number: `{ at_least = 0.7, at_most = 0.9, blessed = 0.8 }`. If both `at_least` and `at_most` are
/// missing, the next `--bless` sets them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a bound, with keys among at_least, at_most and blessed")]
pub struct Bound {
    /// Smallest value that is allowed.
    pub at_least: Option<f64>,
    /// Largest value that is allowed.
    pub at_most: Option<f64>,
    /// The value from which `--bless` computed the bounds. It does not decide anything.
    pub blessed: Option<f64>,
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
        let properties: Map<String, Value> = METRICS
            .iter()
            .map(|metric| {
                let own = if metric.by_category {
                    json!({ "type": "object", "additionalProperties": bound, "description": metric.summary })
                } else {
                    json!({ "allOf": [bound], "description": metric.summary })
                };
                (metric.name.to_owned(), own)
            })
            .collect();
        json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}
