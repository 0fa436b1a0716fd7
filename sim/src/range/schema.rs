//! JSON Schema of a [`Draw`], for editors.

use schemars::transform::Transform;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use underbrush_recording::Limits;

use super::Draw;

impl JsonSchema for Draw {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Quantity".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = json_schema!({ "type": "number" });
        let mut schema = forms(&number, &number);
        schema.insert("description".into(), "A number, or a range to draw from.".into());
        schema
    }
}

/// The three forms of a quantity whose values and standard deviation have these schemas.
fn forms(value: &Schema, deviation: &Schema) -> Schema {
    let pair = |second: &Schema| json_schema!({ "type": "array", "prefixItems": [value, second], "items": false, "minItems": 2, "maxItems": 2 });
    let range = |key: &str, pair: Schema| json_schema!({ "type": "object", "properties": { key: pair }, "required": [key], "additionalProperties": false });
    json_schema!({ "oneOf": [value, range("uniform", pair(value)), range("normal", pair(deviation))] })
}

/// The schema of a quantity with these limits.
pub fn schema_within(Limits { min, max, .. }: Limits) -> Schema {
    let value = json_schema!({ "type": "number", "minimum": min, "maximum": max });
    let deviation = json_schema!({ "type": "number", "minimum": 0.0, "maximum": max - min });
    forms(&value, &deviation)
}

/// The schema of the entries of an array or a map.
fn entries(schema: &mut Schema) -> Option<&mut Schema> {
    let key = if schema.get("items").is_some() { "items" } else { "additionalProperties" };
    <&mut Schema>::try_from(schema.get_mut(key)?).ok()
}

/// Puts a field's limits into its schema: those of a [`Draw`], or of a number or every number of an array or a map, with their
/// unit. A value that switches an effect off is within the limits.
pub struct Within(pub Limits);

impl Transform for Within {
    fn transform(&mut self, schema: &mut Schema) {
        let mut forms = schema_within(self.0);
        if schema.remove("$ref").is_some() {
            if let Some(forms) = forms.remove("oneOf") {
                schema.insert("oneOf".into(), forms);
            }
        } else if let Some(first) = schema.get_mut("anyOf").and_then(|kinds| kinds.get_mut(0)) {
            *first = forms.into();
        } else if let Some(entries) = entries(schema) {
            self.transform(entries);
        } else {
            let Limits { min, max, off, unit } = self.0;
            schema.insert("minimum".into(), off.map_or(min, |off| off.min(min)).into());
            if off.is_none_or(f64::is_finite) {
                schema.insert("maximum".into(), max.into());
            }
            if !unit.is_empty() {
                schema.insert("unit".into(), unit.into());
            }
        }
    }
}
