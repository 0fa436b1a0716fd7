//! One step of Newton's method: the matrix, and how far to go.

use fearless_simd::{Simd, SimdBase, SimdFrom, dispatch, f64x4};
use nalgebra::Matrix3;
use underbrush_recording::vector::level;

use super::{Patch, ROWS, Solver, join, split};
use crate::contact::block_matrix::{LANES, Lanes, dot};

/// Trials of the line search.
const MAX_SEARCH: usize = 20;

impl Solver {
    /// Assembles the matrix M + Σ Jᵀ (−∂λ/∂v) J. With `is_coupled`, friction changes with the normal impulse, which
    /// makes the matrix unsymmetric.
    pub(super) fn assemble(&mut self, is_coupled: bool) {
        dispatch!(level(), simd => self.assemble_with(simd, is_coupled));
    }

    #[inline(always)]
    fn assemble_with<S: Simd>(&mut self, simd: S, is_coupled: bool) {
        self.matrix.clear();
        for (index, block) in self.blocks.iter().enumerate() {
            for (row, sides) in self.matrix.rows_mut(index, index).enumerate() {
                let mass = &self.mass[block.mass + row * block.size..][..block.size];
                for entries in sides {
                    entries.as_flattened_mut()[..block.size].copy_from_slice(mass);
                }
            }
        }
        for patch in &self.patches {
            let stiffness = Stiffness::new(patch, is_coupled);
            if stiffness.normal[(0, 0)] == 0.0 && patch.limit == 0.0 {
                continue;
            }
            for own in patch.sides.iter().flatten() {
                // Jᵀ times the stiffness, for the rows of the block and for its columns.
                for pushed in &mut self.pushed {
                    pushed.clear();
                    pushed.resize(self.matrix.width(own.block), [[0.0; LANES]; ROWS]);
                }
                let own_columns = &self.columns[own.columns..][..self.blocks[own.block].size];
                for (at, column) in own_columns.iter().enumerate() {
                    let sides = [stiffness.transposed_times(column), stiffness.times(column)];
                    for (pushed, entries) in self.pushed.iter_mut().zip(sides) {
                        for (lanes, entry) in pushed[at / LANES].iter_mut().zip(entries) {
                            lanes[at % LANES] = entry;
                        }
                    }
                }
                for other in patch.sides.iter().flatten().filter(|other| other.block <= own.block) {
                    let other_columns = &self.columns[other.columns..][..self.blocks[other.block].size];
                    let targets = self.matrix.rows_mut(own.block, other.block);
                    for ((at, column), targets) in other_columns.iter().enumerate().zip(targets) {
                        // On the diagonal nothing reads the lanes before `at`.
                        let first = if own.block == other.block { at / LANES } else { 0 };
                        for (target, pushed) in targets.into_iter().zip(&self.pushed) {
                            add_products(simd, &mut target[first..], column, &pushed[first..]);
                        }
                    }
                }
            }
        }
        for stop in &self.stops {
            let (_, stiffness) = stop.response(stop.sign * self.velocity[stop.index], self.step_s);
            if let Some(entry) = self.matrix.diagonal_mut(stop.index) {
                *entry += stiffness;
            }
        }
    }

    /// The share of the Newton step to take: 1, or less if the slope of the convex function changes its sign before
    /// that.
    pub(super) fn line_search(&self) -> f64 {
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
                sum += step[row] * dot(mass, step);
            }
        }
        sum
    }
}

/// Adds to each entry the product of its column of `pushed` with `column`.
#[inline(always)]
fn add_products<S: Simd>(simd: S, entries: &mut [Lanes], column: &[f64; ROWS], pushed: &[[Lanes; ROWS]]) {
    for (entries, pushed) in entries.iter_mut().zip(pushed) {
        let mut products = [f64x4::splat(simd, 0.0); ROWS];
        for (product, (pushed, factor)) in products.iter_mut().zip(pushed.iter().zip(column)) {
            *product = f64x4::simd_from(simd, *pushed) * *factor;
        }
        let [a, b, c, d, e, f] = products;
        *entries = (f64x4::simd_from(simd, *entries) + (a + b + c + d + e + f)).into();
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
            friction.impulse / patch.limit * normal.stiffness.row(0) * patch.law.interface.friction
        } else {
            Matrix3::zeros()
        };
        Stiffness { normal: normal.stiffness, friction: friction.stiffness, coupling }
    }

    #[inline(always)]
    fn times(&self, column: &[f64; ROWS]) -> [f64; ROWS] {
        let (first, second) = split(column);
        join(self.normal * first, self.coupling * first + self.friction * second)
    }

    #[inline(always)]
    fn transposed_times(&self, row: &[f64; ROWS]) -> [f64; ROWS] {
        let (first, second) = split(row);
        join(self.normal * first + self.coupling.tr_mul(&second), self.friction * second)
    }
}
