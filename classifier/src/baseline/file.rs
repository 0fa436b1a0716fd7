//! What the model files of all baselines have in common.

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::Limits;

use crate::error::{Fault, check_limits};

/// Fitted numbers of any kind. Choice: standardized features and forces stay far below; a larger number means a damaged
/// file.
pub(super) const FITTED: Limits = Limits::new(-1e12, 1e12, "");

/// Numbers that are used as divisors, such as variances. Choice, as [`FITTED`].
pub(super) const POSITIVE: Limits = Limits::new(1e-15, 1e12, "");

/// The keys of a fitted baseline.
#[derive(Deserialize, JsonSchema)]
#[schemars(rename = "{O}File")]
pub(super) struct Keys<O, P> {
    /// Names in alphabetical order: the order of all scores.
    #[schemars(length(min = 1))]
    pub(super) categories: Vec<String>,
    /// What the classifier was fitted with.
    pub(super) options: O,
    /// What was fitted.
    pub(super) parameters: P,
}

/// Checks that a list has this length and that all numbers are within limits.
pub(super) fn check_list(field: &str, values: &[f64], length: usize, limits: Limits) -> Result<(), Fault> {
    if values.len() != length {
        return Err(Fault::new(field, format!("{} numbers", values.len()), format!("{length} numbers")));
    }
    let mut places = values.iter().enumerate();
    places.try_for_each(|(index, value)| check_limits(format!("{field}[{index}]"), *value, limits))
}

/// Checks that a table has this many rows of this length and that all numbers are within limits. `shape` is the number
/// of rows and their length.
pub(super) fn check_table(field: &str, rows: &[Vec<f64>], shape: (usize, usize), limits: Limits) -> Result<(), Fault> {
    if rows.len() != shape.0 {
        return Err(Fault::new(field, format!("{} rows", rows.len()), format!("{} rows", shape.0)));
    }
    let mut places = rows.iter().enumerate();
    places.try_for_each(|(index, row)| check_list(&format!("{field}[{index}]"), row, shape.1, limits))
}

/// The columns of a matrix as rows of a table.
pub(super) fn columns(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.column_iter().map(|column| column.iter().copied().collect()).collect()
}

/// The matrix whose columns are these rows, all of this length.
pub(super) fn from_columns(length: usize, columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(length, columns.len(), |row, column| columns[column][row])
}
