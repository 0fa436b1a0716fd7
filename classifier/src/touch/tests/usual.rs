use nalgebra::{DMatrix, DVector};

use super::super::novelty::Usual;

/// Numbers that look random, from −1 to 1.
fn number(index: usize) -> f64 {
    (12.9898 * index as f64).sin() * 43758.5453 % 1.0
}

fn rows(shift: f64) -> Vec<[f64; 5]> {
    let row = |index: usize| {
        let own: [f64; 5] = std::array::from_fn(|place| number(5 * index + place));
        [own[0] + shift, own[1] + 0.5 * own[0], own[2] * 2.0, own[3] - shift, own[4]]
    };
    (0..300).map(row).collect()
}

/// The distance from the definition, with a dense inverse: √((x − m)ᵀ (C + 0.01 I)⁻¹ (x − m)).
fn mahalanobis(rows: &[[f64; 5]], point: &[f64; 5]) -> f64 {
    let matrix = DMatrix::from_fn(rows.len(), 5, |row, column| rows[row][column]);
    let mean = matrix.row_mean().transpose();
    let centred = DMatrix::from_fn(rows.len(), 5, |row, column| rows[row][column] - mean[column]);
    let covariance = centred.transpose() * &centred / rows.len() as f64 + DMatrix::identity(5, 5) * 0.01;
    let deviation = DVector::from_row_slice(point) - mean;
    (deviation.transpose() * covariance.try_inverse().unwrap() * &deviation)[0].sqrt()
}

/// Tests the distance from the nearest of two categories against the definition.
#[test]
fn distances_are_those_of_mahalanobis() {
    let categories = [rows(0.0), rows(4.0)];
    let usual = Usual::fit(&categories);
    for index in 0..50 {
        let point: [f64; 5] = std::array::from_fn(|place| 6.0 * number(1000 + 5 * index + place));
        let expected = categories.iter().map(|rows| mahalanobis(rows, &point)).fold(f64::INFINITY, f64::min);
        let found = usual.distance(&point);
        assert!((found - expected).abs() < 1e-9 * expected, "{found} {expected}");
    }
}

/// Tests the share of known contacts beyond a distance: for the distances 0.001, 0.002, … 1 it is 1 minus the distance,
/// down to the smallest share that is given.
#[test]
fn shares_beyond_are_those_of_the_distances() {
    let mut usual = Usual::fit(&[rows(0.0)]);
    usual.keep_distances((1..=1000).map(|index| f64::from(index) * 1e-3).rev().collect());
    for distance in [0.05, 0.3, 0.5, 0.9, 0.95, 0.99] {
        let share = usual.share_beyond(distance);
        // Between two quantiles, a quarter apart, the logarithm of the share is interpolated.
        assert!((share / (1.0 - distance) - 1.0).abs() < 0.05, "{share} at {distance}");
    }
    assert_eq!(usual.share_beyond(0.0), 1.0);
    assert!((usual.share_beyond(2.0) - 1e-3).abs() < 1e-12);
}
