//! Ridge regression to categories.

use nalgebra::DMatrix;
use underbrush_recording::Trial;
use underbrush_recording::vector::vectorized;

use super::fitted::TrialsByCategory;
use crate::error::ModelError;

/// The share of a trial's weight that its last row has: the whole contact counts as much as all times before. Choice.
const END_SHARE: f64 = 0.5;
/// Variances below this count as this, so that a value that never varies has no weight. Values are shares, of order one.
const LEAST_VARIANCE: f64 = 1e-9;

/// Fits weights W, one column for each category, to the rows φ of this size that `rows` makes of a trial: values of order one,
/// followed by a 1. The last row is that of the whole trial. All categories weigh the same, and so do the trials of a category.
///
/// W minimizes the weighted mean of |y − Wᵀφ|² plus the penalty times Σ v W², where y is 1 for the row's own category and 0 for
/// the others, and v is the variance of a value. The constant has no penalty.
pub(super) fn fit(
    by_category: &TrialsByCategory,
    size: usize,
    penalty: f64,
    rows: impl Fn(&Trial) -> Result<Vec<Vec<f64>>, ModelError>,
) -> Result<DMatrix<f64>, ModelError> {
    // Σ w φ φᵀ, the lower triangle, and Σ w φ yᵀ.
    let mut products = DMatrix::zeros(size, size);
    let mut targets = DMatrix::zeros(size, by_category.len());
    for (category, trials) in by_category.values().enumerate() {
        for trial in trials {
            let rows = rows(trial)?;
            let of_trial = 1.0 / (by_category.len() * trials.len()) as f64;
            let before = rows.len() - 1;
            let end_share = if before == 0 { 1.0 } else { END_SHARE };
            let weighted = |(place, values)| {
                let share = if place == before { end_share } else { (1.0 - end_share) / before as f64 };
                (share * of_trial, values)
            };
            let rows: Vec<(f64, Vec<f64>)> = rows.into_iter().enumerate().map(weighted).collect();
            vectorized(
                #[inline(always)]
                || add(&mut products, &rows),
            );
            for (weight, values) in &rows {
                let mut column = targets.column_mut(category);
                column.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
    solve(products, &targets, penalty)
        .ok_or_else(|| ModelError::no_solution(penalty, "finite features and a positive penalty"))
}

/// Adds weighted rows, four at a time, because the sums are too many for the fastest memory.
#[inline(always)]
fn add(products: &mut DMatrix<f64>, rows: &[(f64, Vec<f64>)]) {
    let (fours, rest) = rows.as_chunks::<4>();
    for (place, mut column) in products.column_iter_mut().enumerate() {
        let below = &mut column.as_mut_slice()[place..];
        let factor = |(weight, values): &(f64, Vec<f64>)| weight * values[place];
        for four in fours {
            let factors = four.each_ref().map(factor);
            if factors == [0.0; 4] {
                continue;
            }
            let [first, second, third, fourth] = four.each_ref().map(|(_, values)| &values[place..]);
            let values = first.iter().zip(second).zip(third.iter().zip(fourth));
            for (sum, ((first, second), (third, fourth))) in below.iter_mut().zip(values) {
                *sum = *sum + factors[0] * first + factors[1] * second + factors[2] * third + factors[3] * fourth;
            }
        }
        for row in rest.iter().filter(|row| row.1[place] != 0.0) {
            let factor = factor(row);
            below.iter_mut().zip(&row.1[place..]).for_each(|(sum, value)| *sum += factor * value);
        }
    }
}

fn solve(mut products: DMatrix<f64>, targets: &DMatrix<f64>, penalty: f64) -> Option<DMatrix<f64>> {
    let constant = products.nrows() - 1;
    for place in 0..constant {
        let mean = products[(constant, place)];
        let variance = products[(place, place)] - mean * mean;
        products[(place, place)] += penalty * variance.max(LEAST_VARIANCE);
    }
    Some(products.cholesky()?.solve(targets))
}

#[cfg(test)]
mod tests {
    use super::*;
    use underbrush_recording::vector::with_baseline;

    /// Tests the weights against their definition: all derivatives of weighted squared error plus penalty are zero, computed
    /// from the rows by central differences. With another penalty they are not. Every processor finds the same weights.
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
            (1..=6).map(|age| vec![0.1 * n, (n * f64::from(age) * 0.37).fract(), 0.5, 1.0]).collect()
        };
        let weights = fit(&by_category, 4, 0.1, |trial| Ok(rows_of(trial))).unwrap();
        let anywhere = with_baseline(|| fit(&by_category, 4, 0.1, |trial| Ok(rows_of(trial))));
        assert_eq!(anywhere.unwrap(), weights);
        let mut rows: Vec<(usize, f64, Vec<f64>)> = Vec::new();
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                let shares = [0.1, 0.1, 0.1, 0.1, 0.1, 0.5].map(|share| share / (2 * trials.len()) as f64);
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
        assert!(largest_slope(0.1) < 1e-9 && largest_slope(0.2) > 1e-3, "{}", largest_slope(0.1));
    }
}
