//! Hidden Markov models in model files.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};
use underbrush_recording::InputError;

use super::{HmmClassifier, check};
use crate::feature::{FEATURES, FeatureSet, Scaling, feature_list_schema};
use crate::hmm::{GaussianHmm, HmmParameters, TrainingHistory};
use crate::{Document, Recipe};

/// The keys of hidden Markov models in a file. Only the first two are required.
#[derive(Deserialize, JsonSchema)]
pub(super) struct HmmFile {
    /// The features of each sample, in the order of the models' numbers.
    #[schemars(schema_with = "feature_list_schema")]
    features: Vec<String>,
    /// One model per category.
    #[schemars(extend("minProperties" = 1))]
    models: BTreeMap<String, HmmParameters>,
    /// How features are scaled before the models see them; none if left out.
    scaling: Option<Scaling>,
    /// The recipe of the models, if known.
    recipe: Option<Recipe>,
    /// The training report of each category, if known.
    #[serde(default)]
    training: BTreeMap<String, TrainingHistory>,
}

impl HmmClassifier {
    /// Reads and checks the models of a file.
    pub(super) fn read(document: &Document) -> Result<Self, InputError> {
        let file: HmmFile = document.read()?;
        let features = FeatureSet::from_names(&file.features).map_err(|error| {
            let columns = FEATURES.map(|feature| format!("{:?}", feature.column)).join(", ");
            let allowed = format!("a list of one or more of {columns}");
            InputError::new(&document.path, "features", error.to_string(), allowed, "train on these features")
        })?;
        let mut models = BTreeMap::new();
        for (category, parameters) in file.models {
            let model = GaussianHmm::new(parameters).map_err(|error| {
                let field = format!("models.{category}.{}", error.field);
                InputError::new(&document.path, field, error.found, error.allowed, error.remedy)
            })?;
            models.insert(category, model);
        }
        let classifier = HmmClassifier::new(features, models).map_err(|error| {
            let allowed = "one model per category, each over the listed features";
            let remedy = "make models and features agree";
            InputError::new(&document.path, "models", error.to_string(), allowed, remedy)
        })?;
        let classifier =
            HmmClassifier { scaling: file.scaling, recipe: file.recipe, training: file.training, ..classifier };
        check::check(&classifier).map_err(|fault| document.fault(fault))?;
        Ok(classifier)
    }

    pub(super) fn entries(&self) -> Vec<(&'static str, Value)> {
        let models = self.models.iter().map(|(name, scorer)| (name, scorer.model.parameters()));
        vec![
            ("features", json!(self.features.columns())),
            ("recipe", json!(self.recipe)),
            ("scaling", json!(self.scaling)),
            ("models", json!(models.collect::<BTreeMap<_, _>>())),
            ("training", json!(self.training)),
        ]
    }
}
