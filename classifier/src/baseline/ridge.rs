//! Ridge regression to categories, whose penalty is chosen by cross-validation.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use underbrush_recording::Trial;

use super::fitted::TrialsByCategory;
use crate::error::ModelError;

/// Penalties to choose from, as shares of each value's variance. Choice: from one that only keeps the regression well
/// posed to one that leaves a tenth of the weights.
const PENALTIES: [f64; 5] = [1e-3, 1e-2, 1e-1, 1.0, 10.0];
/// The share of a trial's weight that its last row has: the whole contact counts as much as all times before. Choice.
const END_SHARE: f64 = 0.5;
/// Parts for cross-validation.
const FOLDS: usize = 5;
/// Variances below this count as this, so that a value that never varies has no weight. Values are shares, of order one.
const LEAST_VARIANCE: f64 = 1e-9;

/// Sums over rows: all that a regression needs to know of them.
#[derive(Clone)]
struct Sums {
    /// Σ w φ φᵀ, the lower triangle. The last value of φ is 1.
    products: DMatrix<f64>,
    /// Σ w φ yᵀ, one column for each category; y is 1 for the row's own category and 0 for the others.
    targets: DMatrix<f64>,
}

impl Sums {
    fn new(dimension: usize, categories: usize) -> Self {
        Sums { products: DMatrix::zeros(dimension, dimension), targets: DMatrix::zeros(dimension, categories) }
    }

    fn add(&mut self, values: &[f64], category: usize, weight: f64) {
        for (place, value) in values.iter().enumerate() {
            if *value != 0.0 {
                let mut column = self.products.column_mut(place);
                let below = &mut column.as_mut_slice()[place..];
                below.iter_mut().zip(&values[place..]).for_each(|(sum, other)| *sum += weight * value * other);
            }
        }
        let mut column = self.targets.column_mut(category);
        column.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }

    /// The weights W, one column for each category, that minimize Σ w |y − Wᵀφ|² + penalty Σ v W², where v is the
    /// variance of each value. The constant has no penalty.
    fn solve(&self, penalty: f64) -> Option<DMatrix<f64>> {
        let constant = self.products.nrows() - 1;
        let total = self.products[(constant, constant)];
        let mut penalized = self.products.clone();
        for place in 0..constant {
            let mean = self.products[(constant, place)] / total;
            let variance = self.products[(place, place)] / total - mean * mean;
            penalized[(place, place)] += penalty * total * variance.max(LEAST_VARIANCE);
        }
        Some(penalized.cholesky()?.solve(&self.targets))
    }

    /// Σ w |y − Wᵀφ|² up to a constant.
    fn squared_error(&self, weights: &DMatrix<f64>) -> f64 {
        let of_category = |(weights, targets): (DVector<f64>, DVector<f64>)| {
            let mut products = DVector::zeros(weights.len());
            products.sygemv(1.0, &self.products, &weights, 0.0);
            weights.dot(&products) - 2.0 * weights.dot(&targets)
        };
        let columns = weights.column_iter().zip(self.targets.column_iter());
        columns.map(|(weights, targets)| of_category((weights.into_owned(), targets.into_owned()))).sum()
    }
}

/// Fits weights, one column for each category, to the rows that `rows` makes of a trial: values of order one, followed by
/// a 1. The last row is that of the whole trial. All categories weigh the same, and so do the trials of a category. The
/// penalty has the least squared error in cross-validation by reach, or by trial where reaches are not known.
pub(super) fn fit<F>(by_category: &TrialsByCategory, dimension: usize, rows: F) -> Result<DMatrix<f64>, ModelError>
where
    F: Fn(&Trial) -> Result<Vec<Vec<f64>>, ModelError> + Sync,
{
    let mut groups = BTreeMap::new();
    for trial in by_category.values().flatten() {
        groups.entry((trial.reach.is_none(), trial.reach.unwrap_or(trial.trial))).or_insert(0);
    }
    groups.values_mut().enumerate().for_each(|(place, fold)| *fold = place % FOLDS);
    let sums = |fold: usize| -> Result<Sums, ModelError> {
        let mut sums = Sums::new(dimension, by_category.len());
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                if groups[&(trial.reach.is_none(), trial.reach.unwrap_or(trial.trial))] == fold {
                    let rows = rows(trial)?;
                    let of_trial = 1.0 / (by_category.len() * trials.len()) as f64;
                    if let Some((end, before)) = rows.split_last() {
                        let share = if before.is_empty() { 1.0 } else { END_SHARE };
                        sums.add(end, category, share * of_trial);
                        let weight = (1.0 - share) * of_trial / before.len().max(1) as f64;
                        before.iter().for_each(|values| sums.add(values, category, weight));
                    }
                }
            }
        }
        Ok(sums)
    };
    let parts: Vec<Sums> = (0..FOLDS).into_par_iter().map(sums).collect::<Result<_, _>>()?;
    let mut all = Sums::new(dimension, by_category.len());
    for part in &parts {
        all.products += &part.products;
        all.targets += &part.targets;
    }
    let unsolvable = || ModelError::Mismatch {
        found: "a regression that has no solution".into(),
        allowed: "finite features of trials".into(),
    };
    let error = |penalty: &f64| -> Option<f64> {
        let of_part = |part: &Sums| {
            let others = Sums { products: &all.products - &part.products, targets: &all.targets - &part.targets };
            // All reaches in one part: nothing to validate on.
            if others.products[(dimension - 1, dimension - 1)] < 1e-12 {
                return Some(0.0);
            }
            Some(part.squared_error(&others.solve(*penalty)?))
        };
        parts.iter().map(of_part).sum()
    };
    let errors: Option<Vec<f64>> = PENALTIES.par_iter().map(error).collect();
    let errors = errors.ok_or_else(unsolvable)?;
    let best = PENALTIES.iter().zip(&errors).min_by(|a, b| a.1.total_cmp(b.1));
    best.and_then(|(penalty, _)| all.solve(*penalty)).ok_or_else(unsolvable)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the weights against their definition: for a penalty of the list, all derivatives of weighted squared error
    /// plus penalty are zero, computed from the rows by central differences.
    #[test]
    fn weights_minimize_the_penalized_error() {
        let trial = |number: u64, category: &str| {
            let category = Some(category.to_owned());
            Trial { trial: number, category, reach: Some(number / 2), patch: None, taxel: None, samples: Vec::new() }
        };
        let trials: Vec<Trial> = (0..9).map(|n| trial(n, if n % 3 == 0 { "leaf" } else { "trunk" })).collect();
        let by_category = crate::estimator::trials_by_category(&trials).unwrap();
        let rows_of = |trial: &Trial| -> Vec<Vec<f64>> {
            let n = trial.trial as f64;
            (1..=3).map(|age| vec![0.1 * n, (n * f64::from(age) * 0.37).fract(), 0.5, 1.0]).collect()
        };
        let weights = fit(&by_category, 4, |trial| Ok(rows_of(trial))).unwrap();
        let mut rows: Vec<(usize, f64, Vec<f64>)> = Vec::new();
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                let shares = [0.25, 0.25, 0.5].map(|share| share / (2 * trials.len()) as f64);
                rows.extend(rows_of(trial).into_iter().zip(shares).map(|(row, share)| (category, share, row)));
            }
        }
        let mean = |place: usize| rows.iter().map(|(_, weight, row)| weight * row[place]).sum::<f64>();
        let variance = |place: usize| {
            rows.iter().map(|(_, weight, row)| weight * (row[place] - mean(place)).powi(2)).sum::<f64>().max(1e-9)
        };
        let variances = [variance(0), variance(1), variance(2)];
        let objective = |weights: &DMatrix<f64>, penalty: f64| {
            let error = |(category, share, row): &(usize, f64, Vec<f64>)| {
                let of = |c: usize| {
                    let value: f64 = (0..4).map(|place| weights[(place, c)] * row[place]).sum();
                    (f64::from(u8::from(c == *category)) - value).powi(2)
                };
                share * (of(0) + of(1))
            };
            let penalties = (0..3).map(|place| variances[place] * weights.row(place).norm_squared());
            rows.iter().map(error).sum::<f64>() + penalty * penalties.sum::<f64>()
        };
        let largest_slope = |penalty: f64| {
            let slope = |index: usize| {
                let (mut up, mut down) = (weights.clone(), weights.clone());
                up[index] += 1e-4;
                down[index] -= 1e-4;
                ((objective(&up, penalty) - objective(&down, penalty)) / 2e-4).abs()
            };
            (0..weights.len()).map(slope).fold(0.0, f64::max)
        };
        let slopes = PENALTIES.map(largest_slope);
        assert_eq!(slopes.iter().filter(|slope| **slope < 1e-9).count(), 1, "{slopes:?}");
    }
}
