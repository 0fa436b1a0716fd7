//! Naive Bayes over stream features.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use underbrush_recording::{InputError, Sample, Trial, math};

use super::file::{self, FITTED, POSITIVE, check_table};
use super::table::{Standardization, Table};
use crate::document::Document;
use crate::error::ModelError;
use crate::estimator::{Classifier, ClassifierKind, ContactScorer, Estimator, Independent, OnlineScorer};
use crate::feature::{FeatureSet, SampleFault};
use crate::stream_feature::{Selection, StreamFeatures};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = ClassifierKind {
    name: "naive-bayes",
    aliases: &[],
    summary: "Naive Bayes on statistics of the taxel's force and motion since contact",
    estimator: |features| Box::new(features.map_or(NaiveBayes::default(), |features| NaiveBayes { features })),
    load,
    schema: file::Fitted::<NaiveBayes, Parameters>::json_schema,
};

/// Gaussian naive Bayes over the stream features of the contact so far ([`crate::stream_feature`]): the score of a
/// category is the sum of the log-densities of its features.
///
/// Features are assumed to be independent and normally distributed within each category. They are not independent, so
/// margins between categories come out too large.
///
/// ```
/// use underbrush_classifier::baseline::NaiveBayes;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_recording::{Region, Sample, Trial};
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
///             region: Some(Region { taxels: 2, largest_force_n: newtons * 30.0, force_sum_n: newtons * 40.0 }),
///             touched: None,
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
///
/// let classifier = NaiveBayes::default().fit(&trials.iter().collect::<Vec<_>>())?;
/// // After three samples of a new contact:
/// let scores = &classifier.scores_after(&press("trunk", 0.25, 3), &[3])?[0];
/// assert!(scores[1] > scores[0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NaiveBayes {
    /// The features of each sample that stream features are computed from.
    pub features: FeatureSet,
}

impl Default for NaiveBayes {
    /// Force and motion of the taxel.
    fn default() -> Self {
        NaiveBayes { features: FeatureSet::FORCE_AND_MOTION }
    }
}

/// Minimum variance of a standardized feature, so that a feature that never varies within a category does not decide
/// alone. Choice: a tenth of the standard deviation over all categories.
const MIN_VARIANCE: f64 = 1e-2;

impl Estimator for NaiveBayes {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        let selection = Selection::of(self.features);
        let mut table = Table::of(trials, &selection)?;
        let standardization = Standardization::of(&mut table, &selection);
        let (mut mean, mut variance) = (Vec::new(), Vec::new());
        for category in 0..table.categories.len() {
            let rows = || table.rows.iter().filter(move |row| row.category == category);
            let total: f64 = rows().map(|row| row.weight).sum();
            let of_feature = |d: usize| {
                let mean = rows().map(|row| row.weight * row.features[d]).sum::<f64>() / total;
                let squares = rows().map(|row| row.weight * (row.features[d] - mean).powi(2));
                (mean, (squares.sum::<f64>() / total).max(MIN_VARIANCE))
            };
            let (means, variances): (Vec<f64>, Vec<f64>) = (0..selection.dimension()).map(of_feature).unzip();
            mean.push(means);
            variance.push(variances);
        }
        Ok(Box::new(NaiveBayesClassifier(Arc::new(Fitted {
            options: *self,
            selection,
            categories: table.categories,
            parameters: Parameters { standardization, mean, variance },
        }))))
    }
}

#[derive(Debug)]
struct Fitted {
    options: NaiveBayes,
    selection: Selection,
    categories: Vec<String>,
    parameters: Parameters,
}

#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NaiveBayesParameters")]
struct Parameters {
    standardization: Standardization,
    /// One row per category.
    mean: Vec<Vec<f64>>,
    variance: Vec<Vec<f64>>,
}

#[derive(Debug)]
struct NaiveBayesClassifier(Arc<Fitted>);

fn load(document: &Document) -> Result<Box<dyn Classifier>, InputError> {
    let file::Fitted { categories, options, parameters } =
        file::Fitted::<NaiveBayes, Parameters>::read(document, |_| Ok(()))?;
    let selection = Selection::of(options.features);
    let shape = (categories.len(), selection.dimension());
    let Parameters { standardization, mean, variance } = &parameters;
    standardization
        .check(selection.dimension())
        .map_err(|fault| fault.within("standardization"))
        .and_then(|()| check_table("mean", mean, shape, FITTED))
        .and_then(|()| check_table("variance", variance, shape, POSITIVE))
        .map_err(|fault| document.fault(fault.within("parameters")))?;
    Ok(Box::new(NaiveBayesClassifier(Arc::new(Fitted { options, selection, categories, parameters }))))
}

impl Classifier for NaiveBayesClassifier {
    fn name(&self) -> &'static str {
        KIND.name
    }

    fn features(&self) -> FeatureSet {
        self.0.options.features
    }

    fn categories(&self) -> Vec<String> {
        self.0.categories.clone()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        let fresh = Contact { fitted: Arc::clone(&self.0), state: StreamFeatures::default() };
        Box::new(Independent::new(fresh, contacts))
    }

    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        file::entries(&self.0.categories, &self.0.options, &self.0.parameters)
    }
}

#[derive(Clone, Debug)]
struct Contact {
    fitted: Arc<Fitted>,
    state: StreamFeatures,
}

impl ContactScorer for Contact {
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault> {
        self.fitted.selection.push(&mut self.state, sample)?;
        Ok(true)
    }

    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError> {
        let Parameters { standardization, mean, variance } = &self.fitted.parameters;
        let mut features = self.fitted.selection.values(&self.state);
        standardization.apply(&mut features);
        for ((score, mean), variance) in scores.iter_mut().zip(mean).zip(variance) {
            let gaussians = mean.iter().zip(variance).zip(&features);
            let densities = gaussians.map(|((mean, variance), feature)| {
                let squared = (feature - mean).powi(2) / variance;
                -0.5 * (squared + math::ln(std::f64::consts::TAU * variance))
            });
            *score = densities.sum();
        }
        Ok(())
    }
}
