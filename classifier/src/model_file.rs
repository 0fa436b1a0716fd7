//! Model files: JSON, format `underbrush-model/1`, readable by a person and exact to the last bit.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use serde_json::{Value, json};
use underbrush_recording::InputError;

use crate::decision::Decision;
use crate::feature::{FEATURES, FeatureSet, Scaling};
use crate::hmm::{GaussianHmm, HmmParameters, TrainingHistory};
use crate::model_set::{ModelError, ModelSet};
use crate::recipe::Recipe;

mod check;

/// The format that this program reads and writes.
pub const FORMAT: &str = "underbrush-model/1";

/// A model file as it stands. Only the first three keys are needed; keys unknown to this program are passed over, so
/// that others can add their own.
#[derive(Deserialize)]
struct ModelFile {
    format: String,
    features: Vec<String>,
    models: BTreeMap<String, HmmParameters>,
    scaling: Option<Scaling>,
    recipe: Option<Recipe>,
    decision: Option<Decision>,
    #[serde(default)]
    training: BTreeMap<String, TrainingHistory>,
    #[serde(default)]
    provenance: BTreeMap<String, String>,
}

impl ModelSet {
    /// Reads and checks a model file.
    ///
    /// # Errors
    /// [`ModelError::Input`] with the field (such as `models.leaf.transition[2]`), and with the line where the JSON
    /// itself is at fault.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ModelError> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|error| {
            InputError::new(
                path,
                "file",
                error.to_string(),
                "a readable model file",
                "check the path",
            )
        })?;
        Self::from_json(path, &text)
    }

    /// Checks the text of a model file; `path` is for errors only.
    ///
    /// # Errors
    /// As [`ModelSet::load`].
    pub fn from_json(path: impl AsRef<Path>, text: &str) -> Result<Self, ModelError> {
        let path = path.as_ref();
        let file: ModelFile = serde_json::from_str(text).map_err(|error| json_error(path, text, &error))?;
        if file.format != FORMAT {
            return Err(InputError::new(path, "format", file.format, FORMAT, "use a model of this format").into());
        }
        let features = FeatureSet::from_names(&file.features).map_err(|error| {
            let columns = FEATURES.map(|feature| format!("{:?}", feature.column)).join(", ");
            let allowed = format!("a list of one or more of {columns}");
            InputError::new(path, "features", error.to_string(), allowed, "train on these features")
        })?;
        let mut models = BTreeMap::new();
        for (category, parameters) in file.models {
            let model = GaussianHmm::new(parameters).map_err(|error| {
                let field = format!("models.{category}.{}", error.field);
                InputError::new(path, field, error.found, error.allowed, error.remedy)
            })?;
            models.insert(category, model);
        }
        let set = ModelSet::new(features, models).map_err(|error| {
            let allowed = "one model per category, each over the features listed";
            InputError::new(
                path,
                "models",
                error.to_string(),
                allowed,
                "make models and features agree",
            )
        })?;
        if let Some(decision) = &file.decision {
            decision.prepare(&set.categories()).map_err(|error| {
                let allowed = "priors and thresholds that fit the models";
                InputError::new(
                    path,
                    "decision",
                    error.to_string(),
                    allowed,
                    "correct or remove the decision",
                )
            })?;
        }
        let set = ModelSet {
            scaling: file.scaling,
            recipe: file.recipe,
            decision: file.decision,
            training: file.training,
            provenance: file.provenance,
            ..set
        };
        check::check(path, &set)?;
        Ok(set)
    }

    /// The text of the model file; read back it gives the same models bit for bit, which is checked here.
    ///
    /// # Errors
    /// [`ModelError`] where a number that was set by hand (a threshold, a figure of the recipe) is not finite, which
    /// JSON cannot hold, or is otherwise such that the file could not be read again.
    pub fn save_string(&self) -> Result<String, ModelError> {
        let models: BTreeMap<_, _> = self
            .models
            .iter()
            .map(|(name, scorer)| (name, scorer.model().parameters()))
            .collect();
        let entries = [
            ("format", json!(FORMAT)),
            ("features", json!(self.features.columns())),
            ("recipe", json!(self.recipe)),
            ("decision", json!(self.decision)),
            ("scaling", json!(self.scaling)),
            ("models", json!(models)),
            ("training", json!(self.training)),
            ("provenance", json!(self.provenance)),
        ];
        let known = entries
            .iter()
            .filter(|(_, value)| !value.is_null() && *value != json!({}));
        let mut text = String::new();
        write_object(known.map(|(key, value)| (*key, value)), 0, &mut text);
        text.push('\n');
        if Self::from_json("the model to be written", &text)? == *self {
            return Ok(text);
        }
        Err(ModelError::Mismatch {
            found: "a recipe, training history or threshold that changes when it is written and read".into(),
            allowed: "finite numbers".into(),
        })
    }
}

fn json_error(path: &Path, text: &str, error: &serde_json::Error) -> InputError {
    let field = match serde_json::from_str::<Value>(text) {
        Ok(value) => field_at_fault(&value),
        Err(_) => "JSON".to_owned(),
    };
    let remedy = "correct the file, or write it again with the training program";
    InputError::new(
        path,
        field,
        error.to_string(),
        "a model file of format underbrush-model/1",
        remedy,
    )
    .at_line(error.line())
}

/// Whether a value is what a field must hold.
type Fits = fn(&Value) -> bool;

/// Which field of a file that is JSON, but no model file, does not have its type: serde names only the line.
fn field_at_fault(file: &Value) -> String {
    fn fits<T: serde::de::DeserializeOwned>(value: &Value) -> bool {
        T::deserialize(value).is_ok()
    }
    let nothing = Value::Null;
    let at = |key: &str| file.get(key).unwrap_or(&nothing);
    let tests: [(&str, Fits); 6] = [
        ("format", fits::<String>),
        ("features", fits::<Vec<String>>),
        ("scaling", fits::<Option<Scaling>>),
        ("recipe", fits::<Option<Recipe>>),
        ("decision", fits::<Option<Decision>>),
        ("models", Value::is_object),
    ];
    if let Some((key, _)) = tests.iter().find(|(key, fits)| !fits(at(key))) {
        return (*key).to_owned();
    }
    let tests: [(&str, Fits); 4] = [
        ("initial", fits::<f64>),
        ("transition", fits::<Vec<f64>>),
        ("mean", fits::<Vec<f64>>),
        ("covariance", fits::<Vec<Vec<f64>>>),
    ];
    for (category, model) in at("models").as_object().into_iter().flatten() {
        for (key, fits) in tests {
            let Some(rows) = model.get(key).and_then(Value::as_array) else {
                return format!("models.{category}.{key}");
            };
            if let Some(row) = rows.iter().position(|row| !fits(row)) {
                return format!("models.{category}.{key}[{row}]");
            }
        }
        if !fits::<HmmParameters>(model) {
            return format!("models.{category}");
        }
    }
    if fits::<Option<BTreeMap<String, String>>>(at("provenance")) {
        "training".to_owned()
    } else {
        "provenance".to_owned()
    }
}

/// Pretty JSON in which a list of plain values stays on one line, so that a matrix looks like one.
fn write_value(value: &Value, indent: usize, text: &mut String) {
    match value {
        Value::Object(object) if !object.is_empty() => {
            write_object(object.iter().map(|(key, value)| (key.as_str(), value)), indent, text);
        }
        Value::Array(items) if items.iter().any(|item| item.is_array() || item.is_object()) => {
            text.push('[');
            for (index, item) in items.iter().enumerate() {
                new_line(index > 0, indent + 1, text);
                write_value(item, indent + 1, text);
            }
            new_line(false, indent, text);
            text.push(']');
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(Value::to_string).collect();
            text.push_str(&format!("[{}]", items.join(", ")));
        }
        plain => text.push_str(&plain.to_string()),
    }
}

fn write_object<'a>(entries: impl Iterator<Item = (&'a str, &'a Value)>, indent: usize, text: &mut String) {
    text.push('{');
    for (index, (key, value)) in entries.enumerate() {
        new_line(index > 0, indent + 1, text);
        text.push_str(&format!("{}: ", Value::from(key)));
        write_value(value, indent + 1, text);
    }
    new_line(false, indent, text);
    text.push('}');
}

fn new_line(comma: bool, indent: usize, text: &mut String) {
    text.push_str(if comma { ",\n" } else { "\n" });
    text.push_str(&"  ".repeat(indent));
}

#[cfg(test)]
mod tests;
