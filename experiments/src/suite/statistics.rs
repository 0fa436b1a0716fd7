//! The margin of a blessed bound.
//!
//! A suite runs the same seeds again and again, so the same program finds the same numbers, bit for bit. The margin is
//! for programs that should be equally good but draw or round differently. Their reaches are other draws of the same
//! scenes. If values of reaches are independent and roughly normal, with standard deviation s over n reaches, then the
//! mean of n new reaches exceeds the mean of the n blessed ones by more than t s √(1/n + 1/n) with probability α, where
//! t is the 1 − α quantile of Student's t distribution with n − 1 degrees of freedom (the prediction interval for a
//! future mean; for example Hahn and Meeker, Statistical Intervals, 1991, section 4.7).

use crate::accuracy::Spread;
use underbrush_recording::math;

/// Smallest margin, relative to the mean. Choice: differences of one per cent are not worth a failure, however little
/// the reaches of a pinned scene vary.
const SMALLEST_MARGIN: f64 = 0.01;

/// The margin on one side of the mean of these values, one per reach, which reaches of another seed exceed with
/// probability `probability`. `None` for fewer than two values.
pub fn margin(values: &[f64], probability: f64) -> Option<f64> {
    let spread = Spread::of(values);
    let deviation = spread.standard_deviation?;
    let count = values.len() as f64;
    let quantile = student_t_quantile(1.0 - probability, values.len() - 1);
    let margin = quantile * deviation * (2.0 / count).sqrt();
    Some(margin.max(SMALLEST_MARGIN * spread.mean.abs()))
}

/// The margin with one more reach of the value `other`, for values that are counted, such as goals. A small number of
/// reaches says little about rare events: after 24 goals that were all reached, the next one may well be missed. It is never
/// smaller than [`margin`].
pub fn margin_with_one_more(values: &[f64], other: f64, probability: f64) -> Option<f64> {
    match values.len() {
        0 | 1 => None,
        _ => Some(margin(&[values, &[other]].concat(), probability)?.max(margin(values, probability)?)),
    }
}

/// The quantile of Student's t distribution for a probability above one half.
fn student_t_quantile(probability: f64, degrees: usize) -> f64 {
    let mut high = 1.0;
    while student_t_probability(high, degrees) < probability && high < 1e9 {
        high *= 2.0;
    }
    let mut low = 0.0;
    // Halving to the last bit: 64 steps for a double.
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        let is_below = student_t_probability(middle, degrees) < probability;
        (low, high) = if is_below { (middle, high) } else { (low, middle) };
    }
    high
}

/// The probability that Student's t is at most `t` ≥ 0, by the finite series for whole degrees of freedom (Abramowitz
/// and Stegun, equations 26.7.3 and 26.7.4).
fn student_t_probability(t: f64, degrees: usize) -> f64 {
    let angle = math::atan(t / (degrees as f64).sqrt());
    let (sine, cosine) = math::sin_cos(angle);
    let is_odd = degrees % 2 == 1;
    let mut term = if is_odd { cosine } else { 1.0 };
    let mut sum = 0.0;
    // Powers of the cosine up to degrees − 2, odd ones or even ones.
    for power in (degrees % 2..degrees.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cosine * cosine * (power + 1) as f64 / (power + 2) as f64;
    }
    let within = if is_odd { (angle + sine * sum) * 2.0 / std::f64::consts::PI } else { sine * sum };
    0.5 + 0.5 * within
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    /// Tests the quantiles against a published table (Abramowitz and Stegun, table 26.10).
    #[test]
    fn quantiles_are_those_of_the_table() {
        for (probability, degrees, published) in [
            (0.975, 1, 12.706),
            (0.995, 2, 9.925),
            (0.975, 10, 2.228),
            (0.995, 23, 2.807),
            (0.9995, 24, 3.745),
            (0.9995, 7, 5.408),
            (0.975, 120, 1.980),
        ] {
            let found = student_t_quantile(probability, degrees);
            assert!((found - published).abs() < 6e-4, "{probability} {degrees}: {found}, published {published}");
        }
    }

    /// Tests that new means exceed the margin as often as promised: among 20000 pairs of means of 12 normal values, the
    /// second mean lies above the first by more than the margin in 5 % of the pairs. The tolerance of 0.6 % is four
    /// standard errors.
    #[test]
    fn new_means_exceed_the_margin_as_often_as_promised() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut normal = || (0..12).map(|_| random.random_range(0.0..1.0)).sum::<f64>() - 6.0 + 10.0;
        let pairs = 20_000;
        let mut exceeded = 0;
        for _ in 0..pairs {
            let [first, second]: [Vec<f64>; 2] = std::array::from_fn(|_| (0..12).map(|_| normal()).collect());
            let mean = |values: &[f64]| Spread::of(values).mean;
            if mean(&second) > mean(&first) + margin(&first, 0.05).unwrap() {
                exceeded += 1;
            }
        }
        let share = f64::from(exceeded) / f64::from(pairs);
        assert!((share - 0.05).abs() < 0.006, "{share}");
    }

    /// Tests that equal values still leave a margin: one per cent for a force, and for counted values the margin with
    /// one more reach that differs. One value alone has no margin.
    #[test]
    fn equal_values_leave_a_margin() {
        assert_eq!(margin(&[2.0; 8], 0.01), Some(0.02));
        let expected = margin(&[1.0, 1.0, 1.0, 1.0, 0.0], 0.01);
        assert_eq!(margin_with_one_more(&[1.0; 4], 0.0, 0.01), expected);
        let spread = [1.0, 1.0, 103.0, 1.0, 1.0];
        assert_eq!(margin_with_one_more(&spread, 22.4, 0.01), margin(&spread, 0.01));
        assert_eq!(margin(&[1.0], 0.01), None);
        assert_eq!(margin_with_one_more(&[1.0], 0.0, 0.01), None);
        assert_eq!(margin_with_one_more(&[], 0.0, 0.01), None);
    }
}
