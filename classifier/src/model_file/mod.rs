//! Model files: JSON of format `underbrush-model/1`, one layout for all classifiers, exact to the last bit.
//!
//! The key `classifier` names the kind of classifier; a file without it holds hidden Markov models. The keys `decision`,
//! `provenance` and `blake3` mean the same in all files; the other keys belong to the classifier. Unknown keys are
//! skipped, so users can add their own.

use std::any::Any;
use std::fmt::Display;
use std::path::Path;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde_json::{Value, json};
use underbrush_recording::{InputError, Limits};

use crate::decision::{Decision, PRIOR, Rule};
use crate::document::{Document, FORMAT};
use crate::error::{ModelError, ValueFault, check_limits};
use crate::hmm_classifier::{self, HmmClassifier};
use crate::provenance::{DataSource, Provenance};
use crate::registry::{self, CLASSIFIERS};
use crate::{Classifier, ClassifierKind, ScoreKind, seal};

/// What a model file holds.
///
/// ```
/// use underbrush_classifier::Model;
/// use underbrush_classifier::registry;
/// use underbrush_recording::{Sample, Trial};
///
/// let press = |category: &str, newtons: f64, number: u64| Trial {
///     trial: number,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: (1..=20)
///         .map(|k| Sample {
///             time_s: 0.01 * f64::from(k),
///             force_n: newtons * f64::from(k) + 0.01 * number as f64,
///             motion_m: Some(0.001 * f64::from(k)),
///             ..Sample::default()
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
///
/// // Any classifier of the list by its name, here with its default options.
/// let kind = registry::find("naive-bayes").expect("it is in the list");
/// let classifier = (kind.estimator)(None).fit(&trials.iter().collect::<Vec<_>>())?;
/// let text = Model::new(classifier).save_string()?;
/// let model = Model::from_json("model.json", &text)?;
/// let scores = model.classifier.scores_of_all(&[&press("trunk", 0.25, 3)])?;
/// assert!(scores[0][1] > scores[0][0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Model {
    /// The fitted classifier.
    pub classifier: Box<dyn Classifier>,
    /// Priors and thresholds for classification, if the file has them.
    pub decision: Option<Decision>,
    /// Where the model comes from.
    pub provenance: Provenance,
}

/// A model file: the keys of all classifiers, and those of the classifier that the file names. Other keys are skipped.
/// Whether the sizes agree with each other is checked when the file is read.
#[derive(Deserialize, JsonSchema)]
#[schemars(rename = "ModelFile", transform = seal::describe)]
struct Head {
    /// The format of the file.
    #[schemars(extend("const" = FORMAT))]
    format: String,
    /// The kind of classifier; hidden Markov models if left out.
    #[serde(default)]
    #[schemars(schema_with = "classifier_schema")]
    classifier: Option<String>,
    /// Priors and thresholds to classify with.
    decision: Option<Decision>,
    /// Where the model comes from.
    #[serde(default)]
    provenance: Provenance,
}

impl Model {
    /// A model without decision and provenance.
    pub fn new(classifier: Box<dyn Classifier>) -> Self {
        Model { classifier, decision: None, provenance: Provenance::default() }
    }

    /// Reads and checks the text of a model file; `path` is for errors only. [`crate::any_model`] reads files.
    ///
    /// # Errors
    /// [`ModelError::Input`] with the field, such as `models.leaf.transition[2]`, and with the line if a value has the
    /// wrong type or the text is not JSON. A text whose content does not match its seal is refused.
    pub fn from_json(path: impl AsRef<Path>, text: &str) -> Result<Self, ModelError> {
        Self::read(&Document::of_format(path, text, FORMAT))
    }

    // Not generic, so that it is compiled once and not for each type of path.
    fn read(document: &Document) -> Result<Self, ModelError> {
        let head: Head = document.read()?;
        if head.format != FORMAT {
            let remedy = "use a model of this format";
            return Err(InputError::new(&document.path, "format", head.format, FORMAT, remedy).into());
        }
        let name = head.classifier.as_deref().unwrap_or(hmm_classifier::KIND.name);
        let kind = registry::find(name).ok_or_else(|| {
            let known = CLASSIFIERS.map(|kind| kind.name).join(", ");
            document.error("classifier", name, format!("one of {known}"))
        })?;
        let classifier = (kind.load)(document)?;
        document.check_names(&classifier.categories())?;
        if let Some(decision) = &head.decision {
            check_decision(document, decision, &classifier.categories())?;
        }
        document.check_seal()?;
        Ok(Model { classifier, decision: head.decision, provenance: head.provenance })
    }

    /// The text of the model file. It is read back here, to make sure that it gives the same model bit for bit.
    ///
    /// # Errors
    /// [`ModelError`] if a number set by hand, such as a threshold, is not finite or outside the range that model files
    /// allow.
    pub fn save_string(&self) -> Result<String, ModelError> {
        let text = self.text();
        // JSON numbers are the shortest that read back as the same double, so equal text means equal numbers.
        if Self::from_json("the model to be written", &text)?.text() == text {
            return Ok(text);
        }
        Err(ModelError::unwritable())
    }

    /// Warns of what is lost or doubtful if these models, read from `name`, are trained further with these data, called `subject`.
    pub fn warn_of_further_training(&self, name: impl Display, subject: impl Display, data: &[DataSource]) {
        self.provenance.warn_of_rates(subject, data);
        if self.decision.is_some() {
            let remedy = "because scores change in training; give classify --decision and --prior";
            log::warn!("warning: {name}: its priors and thresholds are not kept, {remedy}");
        }
    }

    /// Warns of a fit that cannot tell anything apart, or that has more parameters than data.
    pub fn warn_of_little_data(&self) {
        warn_of_one_category(&self.classifier.categories());
        let (Ok(models), Some(training)) = (self.hmm(), self.classifier.training()) else { return };
        for (category, scorer) in models.models() {
            let samples = training.get(category).map_or(usize::MAX, |history| history.samples);
            let states = scorer.model.states;
            if states > samples {
                log::warn!(
                    "warning: the model of {category} has {states} states and was fitted to {samples} samples; \
                     use fewer states or more trials"
                );
            }
        }
    }

    fn text(&self) -> String {
        let mut entries = self.classifier.file_entries();
        let name = self.classifier.name();
        // Files of hidden Markov models existed before this key, and stay as they were.
        if name != hmm_classifier::KIND.name {
            entries.push(("classifier", json!(name)));
        }
        entries.push(("format", json!(FORMAT)));
        entries.push(("decision", json!(self.decision)));
        entries.push(("provenance", json!(self.provenance)));
        seal::sealed(entries)
    }

    /// The hidden Markov models.
    ///
    /// # Errors
    /// [`ModelError::Mismatch`] if the classifier is of another kind.
    pub fn hmm(&self) -> Result<&HmmClassifier, ModelError> {
        (&*self.classifier as &dyn Any).downcast_ref().ok_or_else(|| not_hmm(self.classifier.name()))
    }

    /// Chooses the kind of score of hidden Markov models.
    ///
    /// # Errors
    /// [`ModelError::Mismatch`] if the classifier is of another kind.
    pub fn score_by(&mut self, kind: ScoreKind) -> Result<(), ModelError> {
        let name = self.classifier.name();
        let hmm = (&mut *self.classifier as &mut dyn Any).downcast_mut::<HmmClassifier>();
        hmm.ok_or_else(|| not_hmm(name))?.score = Some(kind);
        Ok(())
    }
}

/// The JSON Schema of the key `classifier`.
fn classifier_schema(_: &mut SchemaGenerator) -> Schema {
    let names: Vec<&str> = CLASSIFIERS.into_iter().flat_map(ClassifierKind::names).collect();
    json_schema!({ "type": "string", "enum": names })
}

/// The JSON Schema of model files. It is derived from the types that read them: the keys of all files, and the keys of
/// each classifier in the list.
pub fn schema() -> Schema {
    let mut generator = SchemaSettings::default().into_generator();
    let of_kind = |kind: &ClassifierKind| {
        let names: Vec<&str> = kind.names().collect();
        // Only hidden Markov models may leave the key out.
        let required = if kind.name == hmm_classifier::KIND.name { vec![] } else { vec!["classifier"] };
        json!({
            "if": { "properties": { "classifier": { "enum": names } }, "required": required },
            "then": (kind.schema)(&mut generator),
        })
    };
    let kinds: Vec<Value> = CLASSIFIERS.into_iter().map(of_kind).collect();
    let mut schema = generator.into_root_schema_for::<Head>();
    schema.insert("allOf".into(), kinds.into());
    schema
}

/// Warns of a model that knows a single category.
pub(crate) fn warn_of_one_category(categories: &[String]) {
    if let [category] = categories {
        log::warn!(
            "warning: all trials or contacts that were fitted are of the category {category}, so the model calls \
             everything {category}; add data of another category"
        );
    }
}

fn not_hmm(name: &str) -> ModelError {
    ModelError::mismatch(format!("a model of the classifier {name}"), "hidden Markov models (hmm)")
}

/// Margins: more than a day at 100 Hz with a hundred nats per sample.
const MARGIN_NATS: Limits = Limits::new(0.0, 1e9, "nats");

/// Checks that a decision fits the categories and that its numbers are within their ranges.
fn check_decision(document: &Document, decision: &Decision, categories: &[String]) -> Result<(), InputError> {
    numbers(decision).map_err(|fault| document.fault(fault.within("decision")))?;
    decision.prepare(categories).map_err(|error| {
        let allowed = "priors and thresholds that fit the categories";
        let remedy = "correct or remove the decision";
        InputError::new(&document.path, "decision", error.to_string(), allowed, remedy)
    })?;
    Ok(())
}

fn numbers(decision: &Decision) -> Result<(), ValueFault> {
    let mut priors = decision.prior.iter();
    priors.try_for_each(|(category, prior)| check_limits(format!("prior.{category}"), *prior, PRIOR))?;
    let margins = match decision.rule {
        Rule::Argmax => vec![],
        Rule::UncertainBelow { margin } => vec![("margin", margin)],
        Rule::OutlierBand { uncertain_below, category_above } => {
            vec![("uncertain_below", uncertain_below), ("category_above", category_above)]
        }
    };
    margins.into_iter().try_for_each(|(key, margin)| check_limits(format!("rule.{key}"), margin, MARGIN_NATS))
}

#[cfg(test)]
mod tests;
