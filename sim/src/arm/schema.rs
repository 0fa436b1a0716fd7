//! JSON Schemas of an arm's TOML files, for editors and for the tables in `docs/arms.md`. They are derived from the
//! types that read the files, so they cannot disagree with the reader.

use schemars::Schema;
use schemars::transform::Transform;
use underbrush_recording::Limits;

/// Puts the range and the unit of a number, or of every number in an array, into its schema.
pub(super) struct Within(pub(super) Limits);

impl Transform for Within {
    fn transform(&mut self, schema: &mut Schema) {
        if let Some(items) = schema.get_mut("items").and_then(|items| <&mut Schema>::try_from(items).ok()) {
            return self.transform(items);
        }
        schema.insert("minimum".into(), self.0.min.into());
        schema.insert("maximum".into(), self.0.max.into());
        if !self.0.unit.is_empty() {
            schema.insert("unit".into(), self.0.unit.into());
        }
    }
}
