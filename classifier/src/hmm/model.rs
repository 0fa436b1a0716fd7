//! The model: parameters as written in a file, and the same parameters checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::gaussian::Gaussians;

/// Unchecked parameters of a hidden Markov model with N states and D features (paper, eq. 1: λ = (A, B, π)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HmmParameters {
    /// N initial probabilities π.
    pub initial: Vec<f64>,
    /// N × N transition probabilities A; row: from, column: to.
    pub transition: Vec<Vec<f64>>,
    /// N × D means of the states' Gaussians, in the features' units.
    pub mean: Vec<Vec<f64>>,
    /// N × D × D covariances of the states' Gaussians.
    pub covariance: Vec<Vec<Vec<f64>>>,
}

/// Which parameter is invalid, and why.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{field}: found {found}; allowed: {allowed}; remedy: {remedy}")]
pub struct ParameterError {
    /// The parameter, for instance `transition[2]`.
    pub field: String,
    /// What was found.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
    /// What to do.
    pub remedy: String,
}

/// How far the sum of a row of probabilities may be from 1.
const ROW_SUM_TOLERANCE: f64 = 1e-6;

/// A model with checked parameters. To score with it, make a [`super::Scorer`].
///
/// ```
/// use underbrush_classifier::feature::Observations;
/// use underbrush_classifier::hmm::{GaussianHmm, HmmParameters, ScoreKind, Scorer};
///
/// // One state: the log-likelihood is that of independent normal samples.
/// let model = GaussianHmm::new(HmmParameters {
///     initial: vec![1.0],
///     transition: vec![vec![1.0]],
///     mean: vec![vec![0.0]],
///     covariance: vec![vec![vec![1.0]]],
/// })?;
/// let observations = Observations::new(1, vec![0.0, 1.0])?;
/// let found = Scorer::from(model).log_probability(ScoreKind::Forward, &observations)?;
/// assert!((found + std::f64::consts::TAU.ln() + 0.5).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianHmm {
    /// Number of states N.
    pub states: usize,
    parameters: HmmParameters,
    /// Means and covariances as densities need them; checking the covariances computes them anyway.
    pub(super) gaussians: Gaussians,
}

impl GaussianHmm {
    /// Checks parameters.
    ///
    /// # Errors
    /// [`ParameterError`] if sizes disagree, a number is not finite, a probability is outside 0 … 1, a row does not sum
    /// to 1 within 1e-6, or a covariance is not symmetric and positive definite.
    pub fn new(parameters: HmmParameters) -> Result<Self, ParameterError> {
        let states = parameters.initial.len();
        if states == 0 {
            return Err(error("initial", "no states", "at least one state", "give one number per state"));
        }
        check_probabilities("initial", &parameters.initial)?;
        check_length("transition", "rows", parameters.transition.len(), states)?;
        for (i, row) in parameters.transition.iter().enumerate() {
            check_length(&format!("transition[{i}]"), "numbers", row.len(), states)?;
            check_probabilities(&format!("transition[{i}]"), row)?;
        }
        check_length("mean", "rows", parameters.mean.len(), states)?;
        let dimension = parameters.mean[0].len();
        if dimension == 0 {
            return Err(error("mean[0]", "no numbers", "one number per feature", "give a mean per feature"));
        }
        for (i, row) in parameters.mean.iter().enumerate() {
            check_length(&format!("mean[{i}]"), "numbers", row.len(), dimension)?;
            check_finite(&format!("mean[{i}]"), row)?;
        }
        check_length("covariance", "matrices", parameters.covariance.len(), states)?;
        for (i, matrix) in parameters.covariance.iter().enumerate() {
            check_covariance(&format!("covariance[{i}]"), matrix, dimension)?;
        }
        let mean = parameters.mean.concat();
        let covariance: Vec<f64> = parameters.covariance.iter().flatten().flatten().copied().collect();
        let gaussians = Gaussians::new(dimension, &mean, &covariance).map_err(|state| {
            let (found, allowed) = ("a matrix that is not positive definite", "positive definite covariances");
            let remedy = "train with a variance floor above 0, or raise the diagonal";
            error(format!("covariance[{state}]"), found, allowed, remedy)
        })?;
        Ok(GaussianHmm { states, parameters, gaussians })
    }

    /// Number of features D.
    pub fn dimension(&self) -> usize {
        self.gaussians.dimension
    }

    /// The parameters in the form that is written to a file.
    pub fn parameters(&self) -> &HmmParameters {
        &self.parameters
    }
}

fn error(field: impl Into<String>, found: impl Into<String>, allowed: &str, remedy: &str) -> ParameterError {
    ParameterError { field: field.into(), found: found.into(), allowed: allowed.to_owned(), remedy: remedy.to_owned() }
}

fn check_length(field: &str, what: &str, found: usize, expected: usize) -> Result<(), ParameterError> {
    if found == expected {
        return Ok(());
    }
    let (found, allowed) = (format!("{found} {what}"), format!("{expected} {what}"));
    Err(error(field, found, &allowed, "make all sizes agree: initial N, transition N×N, mean N×D, covariance N×D×D"))
}

fn check_finite(field: &str, numbers: &[f64]) -> Result<(), ParameterError> {
    match numbers.iter().find(|number| !number.is_finite()) {
        None => Ok(()),
        Some(number) => Err(error(field, number.to_string(), "finite numbers", "train the model again")),
    }
}

fn check_probabilities(field: &str, row: &[f64]) -> Result<(), ParameterError> {
    check_finite(field, row)?;
    if let Some(p) = row.iter().find(|&&p| !(0.0..=1.0 + ROW_SUM_TOLERANCE).contains(&p)) {
        return Err(error(field, p.to_string(), "probabilities from 0 to 1", "correct the number"));
    }
    let sum: f64 = row.iter().sum();
    if (sum - 1.0).abs() > ROW_SUM_TOLERANCE {
        let found = format!("a sum of {sum}");
        return Err(error(field, found, "a sum of 1 within 1e-6", "divide the numbers by their sum"));
    }
    Ok(())
}

fn check_covariance(field: &str, matrix: &[Vec<f64>], dimension: usize) -> Result<(), ParameterError> {
    check_length(field, "rows", matrix.len(), dimension)?;
    for (i, row) in matrix.iter().enumerate() {
        check_length(&format!("{field}[{i}]"), "numbers", row.len(), dimension)?;
        check_finite(&format!("{field}[{i}]"), row)?;
    }
    for i in 0..dimension {
        for j in 0..i {
            let (below, above) = (matrix[i][j], matrix[j][i]);
            if (below - above).abs() > 1e-9 * (matrix[i][i] * matrix[j][j]).abs().sqrt() {
                let found = format!("{below} at [{i}][{j}] and {above} at [{j}][{i}]");
                return Err(error(field, found, "a symmetric matrix", "use the mean of the two"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn valid() -> HmmParameters {
        HmmParameters {
            initial: vec![0.5, 0.5],
            transition: vec![vec![0.9, 0.1], vec![0.0, 1.0]],
            mean: vec![vec![0.0, 1.0], vec![2.0, 3.0]],
            covariance: vec![vec![vec![1.0, 0.1], vec![0.1, 1.0]]; 2],
        }
    }

    /// Tests that every kind of invalid parameter is refused, and that the error names the field.
    #[test]
    fn each_fault_names_its_field() {
        type Break = fn(&mut HmmParameters);
        let faults: [(&str, Break); 13] = [
            ("initial", |p| p.initial.clear()),
            ("initial", |p| p.initial[0] = f64::NAN),
            ("initial", |p| p.initial = vec![-0.5, 1.5]),
            ("transition", |p| {
                p.transition.pop();
            }),
            ("transition[1]", |p| p.transition[1].push(0.0)),
            ("transition[0]", |p| p.transition[0][0] = 0.90001),
            ("mean", |p| p.mean.truncate(1)),
            ("mean[1]", |p| p.mean[1].truncate(1)),
            ("mean[0]", |p| p.mean[0].clear()),
            ("mean[1]", |p| p.mean[1][0] = f64::INFINITY),
            ("covariance[1]", |p| p.covariance[1][0][1] = 0.2),
            ("covariance[0][1]", |p| p.covariance[0][1][0] = f64::NAN),
            ("covariance[1]", |p| p.covariance[1] = vec![vec![1.0, 2.0], vec![2.0, 1.0]]),
        ];
        for (field, break_it) in faults {
            let mut parameters = valid();
            break_it(&mut parameters);
            assert_eq!(GaussianHmm::new(parameters).unwrap_err().field, field);
        }
    }

    /// Tests that checking changes no number.
    #[test]
    fn parameters_come_back_as_they_went_in() {
        let model = GaussianHmm::new(valid()).unwrap();
        assert_eq!(*model.parameters(), valid());
        assert_eq!((model.states, model.dimension()), (2, 2));
    }
}
