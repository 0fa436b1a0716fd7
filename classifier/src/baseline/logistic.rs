//! Multinomial logistic regression over stream features.

use nalgebra::DMatrix;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Limits, Sample, math, stop};

use super::fitted::{self, Baseline, FITTED, TrialsByCategory, check_table};
use super::table::{Row, Standardization, Table};
use crate::error::{ModelError, ValueFault, check_limits};
use crate::stream_feature::{Selection, StreamFeatures, TAXEL_AND_REGION};
use crate::{ClassifierKind, FeatureSet, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<Logistic>(
    &[],
    "Logistic regression on statistics of the forces on taxel and contact region since contact",
    |features| Box::new(Logistic { features: features.unwrap_or(DEFAULT.features), ..DEFAULT }),
);

/// [`KIND`] without the contact region: it sees what hidden Markov models of force and motion see.
pub(crate) const TAXEL_KIND: ClassifierKind = ClassifierKind {
    name: "logistic-taxel",
    summary: "The same without the contact region: logistic with the features force,motion",
    is_by_features: true,
    estimator: |features| Box::new(Logistic { features: features.unwrap_or(FeatureSet::FORCE_AND_MOTION), ..DEFAULT }),
    ..KIND
};

/// Penalties. Choice: without a penalty the minimum may not exist, and above 1e6 all weights are zero.
const PENALTY: Limits = Limits::new(1e-12, 1e6, "nats");

/// Multinomial logistic regression: the log-posterior of each category is a weighted sum of the stream features of the
/// contact so far ([`crate::stream_feature`]), up to normalization.
///
/// The weights minimize the mean cross-entropy plus a quadratic penalty, by Newton's method. Each training contact is
/// used at several times ([`crate::stream_feature::SAMPLE_COUNTS`]), so that scores are meaningful at any time.
/// Categories are assumed to be separable by a linear function of the stream features.
///
/// ```
/// use underbrush_classifier::baseline::Logistic;
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
///             ..Sample::default()
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
///
/// let classifier = Logistic::default().fit(&trials.iter().collect::<Vec<_>>())?;
/// // After three samples of a new contact:
/// let scores = &classifier.scores_after(&press("trunk", 0.25, 3), &[3])?[0];
/// assert!(scores[1] > scores[0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Logistic {
    /// The features of each sample that stream features are computed from.
    pub features: FeatureSet,
    /// Weight of half the squared norm of the weights, relative to the mean cross-entropy, nats; above 0.
    #[schemars(range(min = PENALTY.min, max = PENALTY.max))]
    pub penalty: f64,
}

const DEFAULT: Logistic = Logistic { features: TAXEL_AND_REGION, penalty: 1e-3 };

impl Default for Logistic {
    /// The features of taxel and region. Choice: a penalty of 0.001; between 0.0001 and 0.01 the accuracy on held-out
    /// reaches changes by less than its confidence interval.
    fn default() -> Self {
        DEFAULT
    }
}

impl Baseline for Logistic {
    const NAME: &'static str = "logistic";
    type Parameters = Parameters;
    type Contact = StreamFeatures;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn check(&self) -> Result<(), ValueFault> {
        check_limits("penalty", self.penalty, PENALTY)
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let selection = Selection::of(self.features);
        let mut table = Table::of(trials, &selection)?;
        let standardization = Standardization::of(&mut table, &selection);
        table.rows.iter_mut().for_each(|row| row.features.push(1.0));
        let weights = minimize(&table, selection.dimension() + 1, self.penalty)?;
        Ok(Parameters { standardization, weights: fitted::columns(&weights.transpose()) })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let dimension = Selection::of(self.features).dimension();
        parameters.standardization.check(dimension).map_err(|fault| fault.within("standardization"))?;
        check_table("weights", &parameters.weights, (categories, dimension + 1), FITTED)
    }

    fn push(&self, _: &Parameters, contact: &mut StreamFeatures, sample: &Sample) -> Result<bool, SampleFault> {
        Selection::of(self.features).push(contact, sample).map(|()| true)
    }

    fn scores(&self, parameters: &Parameters, contact: &StreamFeatures, scores: &mut [f64]) {
        let mut features = Selection::of(self.features).values(contact);
        parameters.standardization.apply(&mut features);
        features.push(1.0);
        // In the order of `times`, so that a fit and its scores have the same bits.
        let score = |row: &Vec<f64>| row.iter().zip(&features).fold(0.0, |sum, (weight, x)| sum + weight * x);
        scores.copy_from_slice(&normalized(parameters.weights.iter().map(score).collect()));
    }
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "LogisticParameters")]
pub(super) struct Parameters {
    standardization: Standardization,
    /// One row per category.
    // In a row: a weight per stream feature, then the constant.
    weights: Vec<Vec<f64>>,
}

/// ln P(category | features), one per category, for features that end with 1.
fn log_posterior(weights: &DMatrix<f64>, features: &[f64]) -> Vec<f64> {
    normalized(times(weights, features))
}

/// The log-posteriors with these differences.
fn normalized(scores: Vec<f64>) -> Vec<f64> {
    let largest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let total = largest + math::ln(scores.iter().map(|score| math::exp(score - largest)).sum::<f64>());
    scores.into_iter().map(|score| score - total).collect()
}

/// The product of a matrix and a vector.
fn times(matrix: &DMatrix<f64>, vector: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; matrix.nrows()];
    for (column, x) in matrix.column_iter().zip(vector) {
        product.iter_mut().zip(&column).for_each(|(sum, own)| *sum += own * x);
    }
    product
}

/// Adds the product of a column and a row.
fn add_product(matrix: &mut DMatrix<f64>, column: &[f64], row: &[f64]) {
    for (mut own, x) in matrix.column_iter_mut().zip(row) {
        own.iter_mut().zip(column).for_each(|(entry, factor)| *entry += factor * x);
    }
}

/// The weights that minimize mean cross-entropy plus penalty. The problem is strictly convex, so Newton's method with a
/// backtracking line search finds its only minimum. Its steps come from conjugate gradients, because the Hessian of many
/// categories and features is too large to be factorized.
fn minimize(table: &Table, columns: usize, penalty: f64) -> Result<DMatrix<f64>, ModelError> {
    let categories = table.categories;
    let objective = |weights: &DMatrix<f64>| {
        let entropy: f64 =
            table.rows.iter().map(|row| -row.weight * log_posterior(weights, &row.features)[row.category]).sum();
        entropy + 0.5 * penalty * weights.norm_squared()
    };
    let mut weights = DMatrix::zeros(categories, columns);
    let mut value = objective(&weights);
    // Newton's method doubles the number of correct digits in each iteration; it usually takes a dozen iterations.
    for _ in 0..100 {
        stop::check();
        let step = NewtonStep::of(table, &weights, penalty);
        let direction = step.direction();
        // The quadratic model predicts a further decrease of half of this, in nats.
        let decrement = step.gradient.dot(&direction);
        if !decrement.is_finite() {
            let found = format!("a logistic regression with penalty {penalty} that has no minimum");
            return Err(ModelError::mismatch(found, "finite features and a positive penalty"));
        }
        if decrement < 1e-14 {
            break;
        }
        let mut length = 1.0;
        loop {
            let next = &weights - length * &direction;
            let found = objective(&next);
            if found <= value - 1e-4 * length * decrement {
                (weights, value) = (next, found);
                break;
            }
            length *= 0.5;
            // No step decreases the objective: only rounding is left.
            if length < 1e-10 {
                return Ok(weights);
            }
        }
    }
    Ok(weights)
}

/// Derivatives of the objective. All matrices have a row for each category, and a column for each feature and the constant.
struct NewtonStep<'a> {
    table: &'a Table,
    penalty: f64,
    /// Probabilities of the categories, for each row of the table in turn.
    posteriors: Vec<Vec<f64>>,
    gradient: DMatrix<f64>,
    /// The diagonal of the Hessian.
    diagonal: DMatrix<f64>,
}

impl<'a> NewtonStep<'a> {
    fn of(table: &'a Table, weights: &DMatrix<f64>, penalty: f64) -> Self {
        let posterior = |row: &Row| log_posterior(weights, &row.features).into_iter().map(math::exp).collect();
        let posteriors: Vec<Vec<f64>> = table.rows.par_iter().map(posterior).collect();
        let (categories, columns) = weights.shape();
        let mut gradient = penalty * weights;
        let mut diagonal = DMatrix::from_element(categories, columns, penalty);
        for (row, posterior) in table.rows.iter().zip(&posteriors) {
            let truth = |category| f64::from(u8::from(category == row.category));
            let misses: Vec<f64> = (0..categories).map(|own| row.weight * (posterior[own] - truth(own))).collect();
            let bends: Vec<f64> = posterior.iter().map(|own| row.weight * own * (1.0 - own)).collect();
            let squares: Vec<f64> = row.features.iter().map(|x| x * x).collect();
            add_product(&mut gradient, &misses, &row.features);
            add_product(&mut diagonal, &bends, &squares);
        }
        NewtonStep { table, penalty, posteriors, gradient, diagonal }
    }

    /// The Hessian times this.
    fn bend(&self, along: &DMatrix<f64>) -> DMatrix<f64> {
        // Parts of the rows are summed in order, so the result is the same for any number of threads.
        let part = |(rows, posteriors): (&[Row], &[Vec<f64>])| {
            let mut sum = DMatrix::zeros(along.nrows(), along.ncols());
            for (row, posterior) in rows.iter().zip(posteriors) {
                let scores = times(along, &row.features);
                let mean: f64 = posterior.iter().zip(&scores).map(|(probability, score)| probability * score).sum();
                let factor = |(probability, score): (&f64, &f64)| row.weight * probability * (score - mean);
                let factors: Vec<f64> = posterior.iter().zip(&scores).map(factor).collect();
                add_product(&mut sum, &factors, &row.features);
            }
            sum
        };
        let parts: Vec<_> = self.table.rows.par_chunks(ROWS).zip(self.posteriors.par_chunks(ROWS)).map(part).collect();
        parts.into_iter().fold(self.penalty * along, |sum, part| sum + part)
    }

    /// The step of Newton's method, by conjugate gradients that are preconditioned with the diagonal. It is the more accurate the
    /// smaller the gradient is, so that the number of correct digits still grows from step to step.
    fn direction(&self) -> DMatrix<f64> {
        let mut direction = DMatrix::zeros(self.gradient.nrows(), self.gradient.ncols());
        let mut residual = self.gradient.clone();
        let mut scaled = residual.component_div(&self.diagonal);
        let mut along = scaled.clone();
        let mut size = residual.dot(&scaled);
        let enough = size * size.sqrt().min(0.01);
        for _ in 0..2 * self.gradient.len() {
            if size <= enough {
                break;
            }
            let bend = self.bend(&along);
            let length = size / along.dot(&bend);
            direction += length * &along;
            residual -= length * bend;
            scaled = residual.component_div(&self.diagonal);
            let next = residual.dot(&scaled);
            along = &scaled + next / size * along;
            size = next;
        }
        direction
    }
}

/// Number of rows that are summed by one thread.
const ROWS: usize = 512;

/// The largest derivative of the objective at the fitted weights, by central differences.
#[cfg(test)]
pub(super) fn largest_slope(trials: &[&underbrush_recording::Trial], estimator: &Logistic) -> f64 {
    let features = Selection::of(estimator.features);
    let trials = crate::estimator::trials_by_category(trials.iter().copied()).unwrap();
    let mut table = Table::of(&trials, &features).unwrap();
    Standardization::of(&mut table, &features);
    table.rows.iter_mut().for_each(|row| row.features.push(1.0));
    let weights = minimize(&table, features.dimension() + 1, estimator.penalty).unwrap();
    let objective = |weights: &DMatrix<f64>| {
        let entropies = table.rows.iter().map(|row| {
            let scores: Vec<f64> = (0..weights.nrows())
                .map(|c| (0..weights.ncols()).map(|d| weights[(c, d)] * row.features[d]).sum())
                .collect();
            let total: f64 = scores.iter().map(|score: &f64| math::exp(*score)).sum();
            -row.weight * math::ln(math::exp(scores[row.category]) / total)
        });
        entropies.sum::<f64>() + 0.5 * estimator.penalty * weights.iter().map(|w| w * w).sum::<f64>()
    };
    let slope = |index: usize| {
        let (mut up, mut down) = (weights.clone(), weights.clone());
        up[index] += 1e-4;
        down[index] -= 1e-4;
        ((objective(&up) - objective(&down)) / 2e-4).abs()
    };
    (0..weights.len()).map(slope).fold(0.0, f64::max)
}
