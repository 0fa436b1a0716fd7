//! The factorization M = LᵀL of a tree's mass matrix (Featherstone 2008, table 6.3).

use super::{Coordinate, Tree};

/// The coordinates before one on its way to the ground.
fn before(coordinates: &[Coordinate], at: usize) -> impl Iterator<Item = usize> + '_ {
    std::iter::successors(coordinates[at].before, |at| coordinates[*at].before)
}

impl Tree {
    /// Factorizes the mass matrix. A matrix that is not positive definite gives factors that are not numbers.
    pub(super) fn factorize(&mut self) {
        let (size, coordinates) = (self.coordinates.len(), &self.coordinates);
        let factor = &mut self.scratch.factor;
        factor.clone_from(&self.scratch.mass);
        for row in (0..size).rev() {
            let pivot = factor[row * size + row].sqrt();
            factor[row * size + row] = pivot;
            for column in before(coordinates, row) {
                factor[row * size + column] /= pivot;
            }
            for above in before(coordinates, row) {
                let entry = factor[row * size + above];
                factor[above * size + above] -= entry * entry;
                for column in before(coordinates, above) {
                    factor[above * size + column] -= entry * factor[row * size + column];
                }
            }
        }
    }

    /// Solves Lᵀ x = b in place, with the factors of [`Tree::factorize`].
    pub(super) fn solve_upper(&self, x: &mut [f64]) {
        let (size, coordinates, factor) = (self.coordinates.len(), &self.coordinates, &self.scratch.factor);
        for row in (0..size).rev() {
            x[row] /= factor[row * size + row];
            for column in before(coordinates, row) {
                x[column] -= factor[row * size + column] * x[row];
            }
        }
    }

    /// Solves M x = b in place, with the factors of [`Tree::factorize`].
    pub(super) fn solve(&self, x: &mut [f64]) {
        let (size, coordinates, factor) = (self.coordinates.len(), &self.coordinates, &self.scratch.factor);
        self.solve_upper(x);
        for row in 0..size {
            for column in before(coordinates, row) {
                x[row] -= factor[row * size + column] * x[column];
            }
            x[row] /= factor[row * size + row];
        }
    }
}
