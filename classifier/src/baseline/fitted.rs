//! What all baselines have in common: how they are fitted, used, written and read.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use underbrush_recording::{InputError, Limits, Sample, Trial, math};

use crate::error::{ModelError, ValueFault, check_limits};
use crate::estimator::{
    Classifier, ClassifierKind, ContactScorer, Estimator, Independent, OnlineScorer, trials_by_category,
};
use crate::{Document, FeatureSet, SampleFault};

/// Trials by category, in alphabetical order.
pub(super) type TrialsByCategory<'a> = BTreeMap<String, Vec<&'a Trial>>;

/// The options of a baseline, and what it does with trials and samples.
pub(super) trait Baseline:
    Copy + Debug + Send + Sync + Serialize + DeserializeOwned + JsonSchema + 'static
{
    /// Name of the classifier.
    const NAME: &'static str;
    /// What is fitted, as it is used and as a file holds it.
    type Parameters: Debug + Send + Sync + Serialize + DeserializeOwned + JsonSchema;
    /// What is known of a contact so far. The default is a contact without samples.
    type Contact: Clone + Debug + Default + Send;

    /// The features of each sample.
    fn features(&self) -> FeatureSet;

    /// Checks the options.
    fn check(&self) -> Result<(), ValueFault> {
        Ok(())
    }

    /// Fits to trials.
    fn learn(&self, trials: &TrialsByCategory) -> Result<Self::Parameters, ModelError>;

    /// Checks what a file holds, for this many categories, and makes it ready for use.
    fn check_parameters(&self, parameters: &mut Self::Parameters, categories: usize) -> Result<(), ValueFault>;

    /// As [`ContactScorer::push`].
    fn push(
        &self,
        parameters: &Self::Parameters,
        contact: &mut Self::Contact,
        sample: &Sample,
    ) -> Result<bool, SampleFault>;

    /// As [`ContactScorer::scores`].
    fn scores(&self, parameters: &Self::Parameters, contact: &Self::Contact, scores: &mut [f64]);
}

/// The entry of a baseline in the list of classifiers.
pub(super) const fn kind<B: Baseline>(
    aliases: &'static [&'static str],
    summary: &'static str,
    estimator: fn(Option<FeatureSet>) -> Box<dyn Estimator>,
) -> ClassifierKind {
    let schema = Keys::<B, B::Parameters>::json_schema;
    ClassifierKind { name: B::NAME, aliases, summary, is_by_features: false, estimator, load: load::<B>, schema }
}

/// A fitted baseline.
#[derive(Debug)]
struct Fitted<B: Baseline> {
    options: B,
    categories: Vec<String>,
    parameters: B::Parameters,
}

impl<B: Baseline> Estimator for B {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        self.check()?;
        let trials = trials_by_category(trials.iter().copied())?;
        let parameters = self.learn(&trials)?;
        let categories = trials.into_keys().collect();
        Ok(Box::new(Arc::new(Fitted { options: *self, categories, parameters })))
    }
}

fn load<B: Baseline>(document: &Document) -> Result<Box<dyn Classifier>, InputError> {
    let Keys { categories, options, mut parameters } = document.read::<Keys<B, B::Parameters>>()?;
    document.check_names(&categories)?;
    options.check().map_err(|fault| document.fault(fault.within("options")))?;
    let checked = options.check_parameters(&mut parameters, categories.len());
    checked.map_err(|fault| document.fault(fault.within("parameters")))?;
    Ok(Box::new(Arc::new(Fitted { options, categories, parameters })))
}

impl<B: Baseline> Classifier for Arc<Fitted<B>> {
    fn name(&self) -> &'static str {
        B::NAME
    }

    fn features(&self) -> FeatureSet {
        self.options.features()
    }

    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        let fresh = Contact { fitted: Arc::clone(self), state: B::Contact::default() };
        Box::new(Independent::new(fresh, contacts))
    }

    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        let Fitted { options, categories, parameters } = &**self;
        vec![("categories", json!(categories)), ("options", json!(options)), ("parameters", json!(parameters))]
    }
}

#[derive(Clone, Debug)]
struct Contact<B: Baseline> {
    fitted: Arc<Fitted<B>>,
    state: B::Contact,
}

impl<B: Baseline> ContactScorer for Contact<B> {
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault> {
        self.fitted.options.push(&self.fitted.parameters, &mut self.state, sample)
    }

    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError> {
        self.fitted.options.scores(&self.fitted.parameters, &self.state, scores);
        Ok(())
    }
}

/// Fitted numbers of any kind. Choice: standardized features and forces stay far below; a larger number means a damaged
/// file.
pub(super) const FITTED: Limits = Limits::new(-1e12, 1e12, "");

/// Numbers that are used as divisors, such as variances. Choice, as [`FITTED`].
pub(super) const POSITIVE: Limits = Limits::new(1e-15, 1e12, "");

/// The keys of a fitted baseline.
#[derive(Deserialize, JsonSchema)]
#[schemars(rename = "{O}File")]
struct Keys<O, P> {
    /// Names in alphabetical order: the order of all scores.
    #[schemars(length(min = 1))]
    categories: Vec<String>,
    /// What the classifier was fitted with.
    options: O,
    /// What was fitted.
    parameters: P,
}

/// Checks that a list has this length and that all numbers are within limits.
pub(super) fn check_list(field: &str, values: &[f64], length: usize, limits: Limits) -> Result<(), ValueFault> {
    if values.len() != length {
        return Err(ValueFault::new(field, format!("{} numbers", values.len()), format!("{length} numbers")));
    }
    let mut places = values.iter().enumerate();
    places.try_for_each(|(index, value)| check_limits(format!("{field}[{index}]"), *value, limits))
}

/// Checks that a table has this many rows of this length and that all numbers are within limits. `shape` is the number
/// of rows and their length.
pub(super) fn check_table(
    field: &str,
    rows: &[Vec<f64>],
    shape: (usize, usize),
    limits: Limits,
) -> Result<(), ValueFault> {
    if rows.len() != shape.0 {
        return Err(ValueFault::new(field, format!("{} rows", rows.len()), format!("{} rows", shape.0)));
    }
    let mut places = rows.iter().enumerate();
    places.try_for_each(|(index, row)| check_list(&format!("{field}[{index}]"), row, shape.1, limits))
}

/// Readouts of a linear regression are not probabilities. They are clamped to this minimum before taking the logarithm.
const MIN_POSTERIOR: f64 = 1e-3;

/// The log-posterior that a linear regression to one or zero gives.
pub(super) fn log_of_readout(readout: f64) -> f64 {
    math::ln(readout.clamp(MIN_POSTERIOR, 1.0))
}

/// The columns of a matrix as rows of a table.
pub(super) fn columns(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.column_iter().map(|column| column.iter().copied().collect()).collect()
}

/// A matrix that files hold as the list of its columns.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>")]
#[schemars(inline)]
pub(super) struct Columns(pub(super) DMatrix<f64>);

impl TryFrom<Vec<Vec<f64>>> for Columns {
    type Error = &'static str;

    fn try_from(columns: Vec<Vec<f64>>) -> Result<Self, Self::Error> {
        let (length, count) = (columns.first().map_or(0, Vec::len), columns.len());
        let is_even = columns.iter().all(|column| column.len() == length);
        let matrix = || Columns(DMatrix::from_iterator(length, count, columns.iter().flatten().copied()));
        is_even.then(matrix).ok_or("must be lists of the same length")
    }
}

impl From<Columns> for Vec<Vec<f64>> {
    fn from(Columns(matrix): Columns) -> Self {
        columns(&matrix)
    }
}
