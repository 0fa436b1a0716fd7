//! The factorization M = LᵀL of a tree's mass matrix (Featherstone 2008, table 6.3).

use super::{Coordinate, Scratch, Tree};

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

    /// The mass matrix of the step, M + θ Δt D + (θ Δt)² K, kg m² or kg, as some coordinates feel it if the others are free
    /// to follow: the Schur complement, as the lower triangle by rows. With each coordinate those on its way to the ground
    /// must be given, in ascending order.
    pub fn mass_of(&self, coordinates: &[usize], mass: &mut Vec<f64>) {
        let (all, size, Scratch { mass: whole, factor, .. }) =
            (self.coordinates.len(), coordinates.len(), &self.scratch);
        mass.clear();
        mass.resize(size * size, 0.0);
        for (row, at) in coordinates.iter().enumerate() {
            for (column, other) in coordinates[..=row].iter().enumerate() {
                mass[row * size + column] = if size == all {
                    whole[at * all + other]
                } else {
                    // The rows of L that belong to the others are left out of LᵀL.
                    let rows = coordinates[row..].iter().map(|row| row * all);
                    rows.map(|row| factor[row + at] * factor[row + other]).sum()
                };
            }
        }
    }

    /// Changes the velocities u_θ of the step for those coordinates for which `velocity` returns one. The others follow as the
    /// equations of motion demand. With each coordinate those on its way to the ground must be given.
    pub fn set_next(&mut self, velocity: impl Fn(usize) -> Option<f64>) {
        let (size, coordinates) = (self.coordinates.len(), &self.coordinates);
        let Scratch { next, factor, motion: change, .. } = &mut self.scratch;
        change.clear();
        for (row, own) in next.iter_mut().enumerate() {
            change.push(velocity(row).map_or_else(
                // Nothing acts on this coordinate: its row of L x = 0.
                || {
                    let carried = before(coordinates, row).map(|column| factor[row * size + column] * change[column]);
                    -carried.sum::<f64>() / factor[row * size + row]
                },
                |velocity| velocity - *own,
            ));
            *own = velocity(row).unwrap_or(*own + change[row]);
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
