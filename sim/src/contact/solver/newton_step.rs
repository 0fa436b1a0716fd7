//! One step of Newton's method: the matrix, and how far to go.

use nalgebra::{Matrix3, Vector3};

use super::{Patch, ROWS, Solver, split};

/// Trials of the line search.
const MAX_SEARCH: usize = 20;

impl Solver {
    /// Sets the shape of the matrix. A row begins at the first block that shares a patch with the row's own block.
    pub(super) fn shape_matrix(&mut self) {
        let first = &mut self.first_block;
        first.clear();
        first.extend(0..self.blocks.len());
        for patch in &self.patches {
            if let [Some(a), Some(b)] = &patch.sides {
                let (low, high) = (a.block.min(b.block), a.block.max(b.block));
                first[high] = first[high].min(low);
            }
        }
        let blocks = &self.blocks;
        let rows = blocks.iter().zip(first.iter());
        let columns = rows.flat_map(|(block, first)| std::iter::repeat_n(blocks[*first].offset, block.size));
        self.matrix.reset(columns);
    }

    /// Writes the columns of each side row by row.
    pub(super) fn turn_columns(&mut self) {
        self.rows.resize(ROWS * self.columns.len(), 0.0);
        for side in self.patches.iter().flat_map(|patch| patch.sides.iter().flatten()) {
            let size = self.blocks[side.block].size;
            let rows = &mut self.rows[ROWS * side.columns..][..ROWS * size];
            for (at, column) in self.columns[side.columns..][..size].iter().enumerate() {
                for (row, entry) in column.iter().enumerate() {
                    rows[row * size + at] = *entry;
                }
            }
        }
    }

    /// Assembles the matrix M + Σ Jᵀ (−∂λ/∂v) J. With `is_coupled`, friction changes with the normal impulse, which
    /// makes the matrix unsymmetric.
    pub(super) fn assemble(&mut self, is_coupled: bool) {
        self.matrix.clear();
        for block in &self.blocks {
            for row in 0..block.size {
                let mass = &self.mass[block.mass + row * block.size..][..=row];
                let at = block.offset + row;
                for entries in self.matrix.row_and_column_mut(at, block.offset) {
                    entries.copy_from_slice(mass);
                }
            }
        }
        for patch in &self.patches {
            let stiffness = Stiffness::new(patch, is_coupled);
            if stiffness.normal[(0, 0)] == 0.0 && patch.limit == 0.0 {
                continue;
            }
            for own in patch.sides.iter().flatten() {
                let own_block = self.blocks[own.block];
                for row in 0..own_block.size {
                    let column = &self.columns[own.columns + row];
                    let sides = [stiffness.transposed_times(column), stiffness.times(column)];
                    for other in patch.sides.iter().flatten() {
                        if other.block > own.block {
                            continue;
                        }
                        let other_block = self.blocks[other.block];
                        let width = if other.block == own.block { row + 1 } else { other_block.size };
                        let rows = &self.rows[ROWS * other.columns..][..ROWS * other_block.size];
                        let targets = self.matrix.row_and_column_mut(own_block.offset + row, other_block.offset);
                        for (target, pushed) in targets.into_iter().zip(&sides) {
                            add_products(&mut target[..width], pushed, rows);
                        }
                    }
                }
            }
        }
        for stop in &self.stops {
            let (_, stiffness) = stop.response(stop.sign * self.velocity[stop.index], self.step_s);
            let [row, _] = self.matrix.row_and_column_mut(stop.index, stop.index);
            row[0] += stiffness;
        }
    }

    /// The share of the Newton step to take: 1, or less if the slope of the convex function changes its sign before
    /// that.
    pub(super) fn line_search(&self) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let at_start = dot(&self.step, &self.residual);
        // The kinetic part of the slope is linear along the step.
        let kinetic = at_start + dot(&self.step, &self.impulse);
        let kinetic_rate = self.kinetic_along_step();
        let slope = |share: f64| {
            let mut slope = kinetic + share * kinetic_rate;
            for patch in &self.patches {
                let mut speeds = patch.speeds;
                for (speed, change) in speeds.iter_mut().zip(&patch.change) {
                    *speed += share * change;
                }
                let (normal_speeds, slip_speeds) = split(&speeds);
                let nodes = &self.nodes[patch.nodes.0..patch.nodes.1];
                let normal = patch.law.normal(nodes, &normal_speeds).impulse;
                let friction = patch.law.friction(&patch.deflection, patch.limit, &patch.before, &slip_speeds).impulse;
                let (normal_change, slip_change) = split(&patch.change);
                slope -= normal.dot(&normal_change) + friction.dot(&slip_change);
            }
            for stop in &self.stops {
                let speed = stop.sign * (self.velocity[stop.index] + share * self.step[stop.index]);
                slope -= stop.response(speed, self.step_s).0 * stop.sign * self.step[stop.index];
            }
            slope
        };
        let at_end = slope(1.0);
        if at_end <= 0.3 * at_start.abs() {
            return 1.0;
        }
        // Regula falsi with an occasional bisection: the slope rises along the step.
        let (mut low, mut high) = ((0.0, at_start), (1.0, at_end));
        let mut share = 1.0;
        for trial in 0..MAX_SEARCH {
            share = if trial % 3 == 2 {
                0.5 * (low.0 + high.0)
            } else {
                low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1)
            };
            let found = slope(share);
            if found.abs() < 0.1 * at_start.abs() {
                break;
            }
            if found > 0.0 {
                high = (share, found);
            } else {
                low = (share, found);
            }
        }
        share
    }

    fn kinetic_along_step(&self) -> f64 {
        let mut sum = 0.0;
        for block in &self.blocks {
            let step = &self.step[block.offset..block.offset + block.size];
            for row in 0..block.size {
                let mass = &self.mass[block.mass + row * block.size..][..block.size];
                sum += step[row] * mass.iter().zip(step).map(|(mass, step)| mass * step).sum::<f64>();
            }
        }
        sum
    }
}

/// Adds to each entry the product of `pushed` with its column, of which `rows` holds the rows one after the other.
fn add_products(entries: &mut [f64], pushed: &[f64; ROWS], rows: &[f64]) {
    let (size, count) = (rows.len() / ROWS, entries.len());
    let [a, b, c, d, e, f]: [&[f64]; ROWS] = std::array::from_fn(|row| &rows[row * size..][..count]);
    for at in 0..count {
        entries[at] += pushed[0] * a[at]
            + pushed[1] * b[at]
            + pushed[2] * c[at]
            + pushed[3] * d[at]
            + pushed[4] * e[at]
            + pushed[5] * f[at];
    }
}

/// Minus the derivative of a patch's impulses with respect to its speeds.
struct Stiffness {
    normal: Matrix3<f64>,
    friction: Matrix3<f64>,
    /// Minus the derivative of friction with respect to the normal speeds, through the limit.
    coupling: Matrix3<f64>,
}

impl Stiffness {
    fn new(patch: &Patch, is_coupled: bool) -> Self {
        let (normal, friction) = (&patch.normal, &patch.friction);
        let coupling = if is_coupled && patch.limit > 0.0 {
            let by_limit = friction.impulse / patch.limit;
            by_limit * normal.stiffness.row(0) * patch.law.interface.friction
        } else {
            Matrix3::zeros()
        };
        Stiffness { normal: normal.stiffness, friction: friction.stiffness, coupling }
    }

    fn times(&self, column: &[f64; ROWS]) -> [f64; ROWS] {
        let (first, second) = split(column);
        join(self.normal * first, self.coupling * first + self.friction * second)
    }

    fn transposed_times(&self, row: &[f64; ROWS]) -> [f64; ROWS] {
        let (first, second) = split(row);
        join(self.normal * first + self.coupling.tr_mul(&second), self.friction * second)
    }
}

fn join(first: Vector3<f64>, second: Vector3<f64>) -> [f64; ROWS] {
    [first[0], first[1], first[2], second[0], second[1], second[2]]
}
