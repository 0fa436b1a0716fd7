//! LU factorization within an envelope: row i of the matrix begins at its first non-zero column f(i), and column i
//! begins at row f(i).

/// A square matrix with a symmetric pattern: each row of its lower triangle from its first column on, and each column
/// of its upper triangle from the same row on. The factorization fills no entry outside this pattern. It does not
/// pivot.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    /// First column of each row.
    first: Vec<usize>,
    /// Where row i, column 0 would be among the values.
    base: Vec<isize>,
    /// The lower triangle, with the diagonal.
    lower: Vec<f64>,
    /// The upper triangle, column by column. Its diagonal is not used.
    upper: Vec<f64>,
}

impl Envelope {
    /// Sets the shape, row by row, and all values to zero.
    pub fn reset(&mut self, first_columns: impl IntoIterator<Item = usize>) {
        self.first.clear();
        self.base.clear();
        let mut end = 0;
        for (row, first) in first_columns.into_iter().enumerate() {
            self.first.push(first);
            self.base.push(end as isize - first as isize);
            end += row + 1 - first;
        }
        for values in [&mut self.lower, &mut self.upper] {
            values.clear();
            values.resize(end, 0.0);
        }
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.lower.fill(0.0);
        self.upper.fill(0.0);
    }

    fn range(&self, row: usize, from: usize, to: usize) -> std::ops::Range<usize> {
        let base = self.base[row];
        (base + from as isize) as usize..(base + to as isize) as usize
    }

    /// From column `from` to the diagonal: the entries of row `index`, and those of column `index` above the diagonal.
    pub fn row_and_column_mut(&mut self, index: usize, from: usize) -> [&mut [f64]; 2] {
        let range = self.range(index, from, index + 1);
        [&mut self.lower[range.clone()], &mut self.upper[range]]
    }

    /// Replaces the matrix by its factors: L with ones on its diagonal below, U above, and the reciprocals of U's
    /// diagonal on the diagonal. Returns whether all of U's diagonal is positive, as it is for a positive definite
    /// matrix.
    pub fn factorize(&mut self) -> bool {
        for row in 0..self.first.len() {
            let first = self.first[row];
            let start = (self.base[row] + first as isize) as usize;
            let (lower_above, lower) = self.lower.split_at_mut(start);
            let (upper_above, upper) = self.upper.split_at_mut(start);
            for column in first..row {
                let from = first.max(self.first[column]);
                let base = self.base[column];
                let other = (base + from as isize) as usize..(base + column as isize) as usize;
                let inverse = lower_above[other.end];
                let own = from - first..column - first;
                let at = column - first;
                lower[at] = (lower[at] - dot(&lower[own.clone()], &upper_above[other.clone()])) * inverse;
                upper[at] -= dot(&upper[own], &lower_above[other]);
            }
            let along = row - first;
            let pivot = lower[along] - dot(&lower[..along], &upper[..along]);
            if pivot <= 0.0 {
                return false;
            }
            lower[along] = 1.0 / pivot;
        }
        true
    }

    /// Solves for the right-hand side `x` in place. The matrix must have been factorized.
    pub fn solve(&self, x: &mut [f64]) {
        for row in 0..self.first.len() {
            let first = self.first[row];
            x[row] -= dot(&self.lower[self.range(row, first, row)], &x[first..row]);
        }
        for row in (0..self.first.len()).rev() {
            let first = self.first[row];
            let range = self.range(row, first, row);
            x[row] *= self.lower[range.end];
            let value = x[row];
            for (entry, left) in self.upper[range].iter().zip(&mut x[first..row]) {
                *left -= entry * value;
            }
        }
    }
}

/// The dot product, as four sums side by side that the compiler turns into vector instructions. Their order is fixed.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        /// Tests solutions against nalgebra's dense LU, for random matrices with rows of random lengths.
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            rows in prop::collection::vec((0.0..1.0f64, prop::collection::vec(-1.0..1.0f64, 24)), 1..24),
            right in prop::collection::vec(-1.0..1.0f64, 24),
        ) {
            let size = rows.len();
            let first: Vec<usize> = rows.iter().enumerate().map(|(row, (share, _))| (share * row as f64) as usize).collect();
            let mut dense = DMatrix::<f64>::identity(size, size) * 200.0;
            let mut envelope = Envelope::default();
            envelope.reset(first.iter().copied());
            for (row, (_, values)) in rows.iter().enumerate() {
                for column in first[row]..row {
                    dense[(row, column)] = values[column];
                    dense[(column, row)] = 1.0 - 3.0 * values[column];
                }
                let [own_row, own_column] = envelope.row_and_column_mut(row, first[row]);
                for (offset, (lower, upper)) in own_row.iter_mut().zip(own_column).enumerate() {
                    *lower = dense[(row, first[row] + offset)];
                    *upper = dense[(first[row] + offset, row)];
                }
            }
            let mut found = right[..size].to_vec();
            prop_assert!(envelope.factorize());
            envelope.solve(&mut found);
            let expected = dense.lu().solve(&DVector::from_row_slice(&right[..size])).unwrap();
            for (found, expected) in found.iter().zip(expected.iter()) {
                prop_assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}
