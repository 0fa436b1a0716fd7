//! Cholesky factorization of a symmetric positive definite matrix whose rows begin at their first non-zero column.

/// The lower triangle of a symmetric matrix, row by row, each from its first column on. The factorization fills nothing
/// outside of it.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    /// First column of each row.
    first: Vec<usize>,
    /// Where row i, column 0 would be among the values.
    base: Vec<isize>,
    values: Vec<f64>,
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
        self.values.clear();
        self.values.resize(end, 0.0);
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Row `row` from column `from` up to, but not including, `to`.
    fn part(&self, row: usize, from: usize, to: usize) -> &[f64] {
        let base = self.base[row];
        &self.values[(base + from as isize) as usize..(base + to as isize) as usize]
    }

    /// Row `row` from column `from` to the diagonal.
    pub fn row_mut(&mut self, row: usize, from: usize) -> &mut [f64] {
        let base = self.base[row];
        &mut self.values[(base + from as isize) as usize..=(base + row as isize) as usize]
    }

    /// Replaces the matrix by its factor L, with the reciprocals on the diagonal.
    pub fn factorize(&mut self) {
        for row in 0..self.first.len() {
            let first = self.first[row];
            let start = (self.base[row] + first as isize) as usize;
            let (above, own) = self.values.split_at_mut(start);
            for column in first..row {
                let from = first.max(self.first[column]);
                let base = self.base[column];
                let other = &above[(base + from as isize) as usize..=(base + column as isize) as usize];
                let (other, inverse) = (&other[..column - from], other[column - from]);
                let sum = dot(&own[from - first..column - first], other);
                own[column - first] = (own[column - first] - sum) * inverse;
            }
            let along = row - first;
            let rest = own[along] - dot(&own[..along], &own[..along]);
            // Only rounding can make it vanish, in a matrix that is positive definite.
            own[along] = 1.0 / rest.max(f64::MIN_POSITIVE).sqrt();
        }
    }

    /// Solves for the right side `x`, in place, once factorized.
    pub fn solve(&self, x: &mut [f64]) {
        for row in 0..self.first.len() {
            let first = self.first[row];
            let own = self.part(row, first, row + 1);
            let sum = dot(&own[..row - first], &x[first..row]);
            x[row] = (x[row] - sum) * own[row - first];
        }
        for row in (0..self.first.len()).rev() {
            let first = self.first[row];
            let own = self.part(row, first, row + 1);
            x[row] *= own[row - first];
            let value = x[row];
            for (entry, left) in own[..row - first].iter().zip(&mut x[first..row]) {
                *left -= entry * value;
            }
        }
    }
}

/// Four sums side by side, which the compiler turns into vector instructions; in a fixed order.
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
        /// Pins solutions against nalgebra's dense Cholesky, for random matrices with rows of random lengths.
        #[test]
        fn solutions_are_those_of_the_dense_matrix(
            rows in prop::collection::vec((0.0..1.0f64, prop::collection::vec(-1.0..1.0f64, 24)), 1..24),
            right in prop::collection::vec(-1.0..1.0f64, 24),
        ) {
            let size = rows.len();
            let first: Vec<usize> = rows.iter().enumerate().map(|(row, (share, _))| (share * row as f64) as usize).collect();
            let mut dense = DMatrix::<f64>::identity(size, size) * 30.0;
            let mut envelope = Envelope::default();
            envelope.reset(first.iter().copied());
            for (row, (_, values)) in rows.iter().enumerate() {
                for column in first[row]..row {
                    dense[(row, column)] = values[column];
                    dense[(column, row)] = values[column];
                }
                for (offset, entry) in envelope.row_mut(row, first[row]).iter_mut().enumerate() {
                    *entry = dense[(row, first[row] + offset)];
                }
            }
            let mut found = right[..size].to_vec();
            envelope.factorize();
            envelope.solve(&mut found);
            let expected = dense.cholesky().unwrap().solve(&DVector::from_row_slice(&right[..size]));
            for (found, expected) in found.iter().zip(expected.iter()) {
                prop_assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}
