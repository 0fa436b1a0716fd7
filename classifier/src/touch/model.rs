//! The fitted classifier and its file.

use std::path::Path;

use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::json;
use underbrush_recording::InputError;
use underbrush_recording::limits::{self, Limits};

use super::batch_scores::FeatureRows;
use super::contact_history::REGION_FEATURE_COUNT;
use super::decision::{EARLY, TouchDecision};
use super::frame::{TAXEL_FEATURE_COUNT, TouchOptions};
use super::network::{FITTED, Network, softmax};
use super::object::{ObjectCategories, StiffnessTrees, UnknownObjects};
use crate::document::{Document, Head};
use crate::error::{ModelError, check_limits};
use crate::model_file::warn_of_one_category;
use crate::provenance::Provenance;
use crate::seal;

/// Forces above which a taxel is in contact.
const THRESHOLD_N: Limits = Limits::new(0.0, limits::FORCE_N.max, "N");

/// The format of the file.
pub const TOUCH_FORMAT: &str = "underbrush-touch/1";

/// The parts of a touch model: two networks, what judges objects, and a decision. Other keys of a file are skipped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(transform = seal::describe)]
pub struct TouchModel {
    /// The format of the file.
    #[schemars(extend("const" = TOUCH_FORMAT))]
    pub(super) format: String,
    /// How readings become contacts.
    pub(super) options: TouchOptions,
    /// Names in alphabetical order: the order of all probabilities.
    #[schemars(length(min = 1))]
    pub(super) categories: Vec<String>,
    /// From probabilities to verdicts.
    pub decision: TouchDecision,
    /// Where the model comes from.
    #[serde(default)]
    pub provenance: Provenance,
    /// From the features of a taxel to the probabilities of nothing and of a touch.
    pub(super) touched: Calibrated,
    /// From the features of a touched region to the probabilities of the categories.
    pub(super) category: Calibrated,
    /// From the features of an object to the probabilities of the categories; left out if few objects were trained on, so that the
    /// network judges them alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) of_objects: Option<ObjectCategories>,
    /// What finds unknown objects; left out if the model was trained without auxiliary sets. The key differs from that of earlier
    /// builds, whose trees this program does not know.
    #[serde(default, rename = "unknown_objects", skip_serializing_if = "Option::is_none")]
    pub(super) unknown: Option<UnknownObjects>,
    /// What estimates the stiffness of objects; left out if the model was trained without auxiliary sets.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) stiffness: Option<StiffnessTrees>,
}

/// A network, and the factor that its scores are multiplied by so that its probabilities are right on held-out reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Calibrated {
    pub(super) sharpness: f64,
    pub(super) network: Network,
}

impl Calibrated {
    /// Whether all numbers are within their limits and as many as needed for this many features and classes.
    fn is_sound(&self, inputs: usize, classes: usize) -> bool {
        self.network.is_sound(inputs, classes) && self.sharpness > 0.0 && FITTED.hold(self.sharpness)
    }

    /// Writes the probabilities of the classes for one row after the other. Nothing is allocated if `classes` has room
    /// for them.
    pub(super) fn probabilities<const INPUTS: usize>(&self, rows: &FeatureRows<INPUTS>, classes: &mut Vec<f64>) {
        self.network.scores_of(rows, classes);
        for classes in classes.chunks_exact_mut(self.network.output.len()) {
            classes.iter_mut().for_each(|score| *score *= self.sharpness);
            softmax(classes);
        }
    }
}

impl TouchModel {
    /// Warns of a fit that cannot tell anything apart, or that calls nothing unknown although it was trained on unknown objects.
    pub fn warn_of_little_data(&self) {
        warn_of_one_category(&self.categories);
        let share = self.decision.unknown_share;
        if self.least_unknown_share().is_some_and(|least| share < least) {
            log::warn!(
                "warning: the model calls nothing unknown, because it was trained on too few known objects for an unknown share \
                 of {share}; train on more reaches, or give classify and evaluate a larger --unknown-share"
            );
        }
    }

    /// The smallest [`TouchDecision::unknown_share`] with which any object can be called unknown. The fewer known objects the
    /// model was trained on, the larger it is. `None` if the model was trained without auxiliary sets.
    pub fn least_unknown_share(&self) -> Option<f64> {
        let shares = self.unknown.as_ref()?.least_shares();
        let limits = shares.enumerate().map(|(stage, share)| if stage == 0 { EARLY * share } else { share });
        Some(limits.fold(1.0, f64::min))
    }

    /// The known categories in alphabetical order: the order of all probabilities.
    pub fn categories(&self) -> &[String] {
        &self.categories
    }

    /// How readings become contacts.
    pub fn options(&self) -> &TouchOptions {
        &self.options
    }

    /// The families of auxiliary unknown objects that it was trained on. Without any it calls nothing unknown.
    pub fn families(&self) -> Vec<&str> {
        self.unknown.iter().flat_map(UnknownObjects::families).collect()
    }

    /// The model as the text of its file. It is read back here, to make sure that it gives the same model bit for bit.
    ///
    /// # Errors
    /// [`ModelError`] if a number set by hand is not finite or outside the range that model files allow.
    pub fn save_string(&self) -> Result<String, ModelError> {
        let model = json!(self);
        let entries = model.as_object().into_iter().flatten();
        let text = seal::sealed(entries.map(|(key, value)| (key.as_str(), value.clone())).collect());
        if Self::from_json("the model to be written", &text)? == *self {
            return Ok(text);
        }
        Err(ModelError::unwritable())
    }

    /// Reads and checks the text of a file; the path is for errors only.
    ///
    /// # Errors
    /// [`InputError`] with line and field.
    pub fn from_json(path: impl AsRef<Path>, text: &str) -> Result<Self, InputError> {
        Self::read(&Document::of_format(path, text, TOUCH_FORMAT))
    }

    // Not generic, so that it is compiled once and not for each type of path.
    fn read(document: &Document) -> Result<Self, InputError> {
        // A file of another format has other keys, so its format is read first.
        let Head { format } = document.read()?;
        if format != TOUCH_FORMAT {
            let remedy = "use a touch model, which `underbrush train --classifier touch` makes";
            return Err(InputError::new(&document.path, "format", format, TOUCH_FORMAT, remedy));
        }
        let model: TouchModel = document.read()?;
        document.check_names(&model.categories)?;
        model.decision.check().map_err(|fault| document.fault(fault.within("decision")))?;
        check_limits("options.threshold_n", model.options.threshold_n, THRESHOLD_N)
            .map_err(|fault| document.fault(fault))?;
        let classes = model.categories.len();
        let parts = [
            ("touched", model.touched.is_sound(TAXEL_FEATURE_COUNT, 2)),
            ("category", model.category.is_sound(REGION_FEATURE_COUNT, classes)),
            ("of_objects", model.of_objects.as_ref().is_none_or(|own| own.is_sound(classes))),
            ("stiffness", model.stiffness.as_ref().is_none_or(StiffnessTrees::is_sound)),
            ("unknown_objects", model.unknown.as_ref().is_none_or(|unknown| unknown.is_sound(classes))),
        ];
        if let Some((part, _)) = parts.into_iter().find(|(_, is_sound)| !is_sound) {
            let allowed =
                format!("numbers from {FITTED}, as many as {classes} categories and this program's features need");
            return Err(document.error(part, "other sizes, or a number out of range", allowed));
        }
        document.check_seal()?;
        Ok(model)
    }

    /// The JSON Schema of the file.
    pub fn schema() -> Schema {
        schemars::schema_for!(TouchModel)
    }
}
