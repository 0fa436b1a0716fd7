//! The main loop of the solver: Newton steps for normal forces and friction together, or with fixed friction limits, until the
//! residual is small.

use underbrush_recording::math::larger;

use super::{Block, Convergence, ROWS, Solver, join};

/// Iterations for normal impulses and friction together.
const JOINT_ITERATIONS: usize = 20;
/// Such an iteration's step is accepted if it leaves less than this share of the squared residual.
const SUFFICIENT: f64 = 0.5;
/// Iterations altogether. Where friction wedges a body, the equations may have several solutions, and one of them is unstable:
/// limits near it move away from it by a constant factor each time, which may be little more than 1. Of 2,555 reaches three had
/// such a step. Those took 320 to 453 iterations; the choice is four times as many.
const MAX_ITERATIONS: usize = 2000;
/// The residual at which the iteration ends, relative to the largest generalized impulse.
const TOLERANCE: f64 = 1e-6;
/// Below this, N s or N m s, an impulse is rounding.
const NO_IMPULSE: f64 = 1e-14;

impl Solver {
    /// Finds the velocities u_θ of the step.
    pub fn solve(&mut self) -> Convergence {
        let size = self.velocity.len();
        self.residual.resize(size, 0.0);
        self.impulse.resize(size, 0.0);
        self.step.resize(size, 0.0);
        let shared = self.patches.iter().filter_map(|patch| match &patch.sides {
            [Some(a), Some(b)] => Some([a.block, b.block]),
            _ => None,
        });
        self.matrix.reset(self.blocks.iter().map(|block| block.size), shared);
        self.read_speeds(false);
        for patch in &mut self.patches {
            patch.before = patch.speeds().1;
        }
        let mut convergence = self.solve_together();
        if convergence.residual > TOLERANCE {
            self.solve_by_limits(&mut convergence);
        }
        convergence
    }

    /// Newton's method for normal impulses and friction together. Where a step does not help, one with
    /// fixed friction limits is taken instead, as far as the convex function decreases.
    fn solve_together(&mut self) -> Convergence {
        let mut convergence = Convergence::default();
        self.evaluate(false);
        loop {
            convergence.residual = self.relative_residual();
            if convergence.residual <= TOLERANCE || convergence.iterations == JOINT_ITERATIONS {
                return convergence;
            }
            convergence.iterations += 1;
            let before = self.squared_residual();
            if self.find_step(true) {
                self.go(1.0);
                self.evaluate(false);
                if self.squared_residual() < SUFFICIENT * before {
                    continue;
                }
                self.go(-1.0);
                self.evaluate(false);
            }
            if !self.find_step(false) {
                return convergence;
            }
            self.go(self.line_search());
            self.evaluate(false);
        }
    }

    /// Minimizes the convex function of fixed friction limits, moves the limits half way to their new values, and repeats.
    fn solve_by_limits(&mut self, convergence: &mut Convergence) {
        loop {
            self.evaluate(true);
            let is_last = convergence.iterations == MAX_ITERATIONS;
            if is_last || self.relative_residual() <= TOLERANCE {
                // The residual must also be small with the limits that follow from the present normal impulses.
                self.patches.iter_mut().for_each(|patch| patch.held = patch.limit);
                self.evaluate(false);
                convergence.residual = self.relative_residual();
                if is_last || convergence.residual <= TOLERANCE {
                    return;
                }
                for patch in &mut self.patches {
                    patch.limit = 0.5 * (patch.held + patch.limit);
                }
                self.evaluate(true);
            }
            convergence.iterations += 1;
            if !self.find_step(false) {
                return;
            }
            self.go(self.line_search());
        }
    }

    /// Finds the Newton step and returns whether there is one. With `is_coupled`, friction limits follow the normal
    /// impulses.
    fn find_step(&mut self, is_coupled: bool) -> bool {
        self.assemble(is_coupled);
        if !self.matrix.factorize() {
            return false;
        }
        for (step, residual) in self.step.iter_mut().zip(&self.residual) {
            *step = -residual;
        }
        self.matrix.solve(&mut self.step);
        self.read_speeds(true);
        true
    }

    /// Moves by a share of the Newton step.
    fn go(&mut self, share: f64) {
        for (velocity, step) in self.velocity.iter_mut().zip(&self.step) {
            *velocity += share * step;
        }
        for patch in &mut self.patches {
            for (speed, change) in patch.speeds.iter_mut().zip(&patch.change) {
                *speed += share * change;
            }
        }
    }

    /// Speeds of the patches at the present velocities, or their change along the Newton step.
    fn read_speeds(&mut self, along_step: bool) {
        let velocity = if along_step { &self.step } else { &self.velocity };
        for patch in &mut self.patches {
            let mut speeds = [0.0; ROWS];
            for side in patch.sides.iter().flatten() {
                let block = self.blocks[side.block];
                let columns = &self.columns[side.columns..side.columns + block.size];
                for (column, velocity) in columns.iter().zip(&velocity[block.offset..]) {
                    for (speed, entry) in speeds.iter_mut().zip(column) {
                        *speed += entry * velocity;
                    }
                }
            }
            if along_step {
                patch.change = speeds;
            } else {
                patch.speeds = speeds;
            }
        }
    }

    /// Impulses and the residual M (u − u*) − Σ Jᵀ λ at the present speeds, with friction limits that are held or that
    /// follow from the normal impulses.
    fn evaluate(&mut self, hold_limits: bool) {
        self.impulse.fill(0.0);
        for patch in &mut self.patches {
            let (normal_speeds, slip_speeds) = patch.speeds();
            let nodes = &self.nodes[patch.nodes.0..patch.nodes.1];
            patch.normal = patch.law.normal(nodes, &normal_speeds);
            if !hold_limits {
                patch.limit = patch.law.interface.friction * patch.normal.impulse[0];
            }
            patch.friction = patch.law.friction(&patch.deflection, patch.limit, &patch.before, &slip_speeds);
            let impulse = join(patch.normal.impulse, patch.friction.impulse);
            for side in patch.sides.iter().flatten() {
                let block = self.blocks[side.block];
                let columns = &self.columns[side.columns..side.columns + block.size];
                for (column, sum) in columns.iter().zip(&mut self.impulse[block.offset..]) {
                    *sum += column.iter().zip(&impulse).map(|(entry, impulse)| entry * impulse).sum::<f64>();
                }
            }
        }
        for stop in &self.stops {
            let (impulse, _) = stop.response(stop.sign * self.velocity[stop.index], self.step_s);
            self.impulse[stop.index] += stop.sign * impulse;
        }
        for block in &self.blocks {
            for row in 0..block.size {
                let mass = &self.mass[block.mass + row * block.size..][..block.size];
                let range = block.offset..block.offset + block.size;
                let change = self.velocity[range.clone()].iter().zip(&self.free[range]);
                let momentum: f64 = mass.iter().zip(change).map(|(mass, (u, free))| mass * (u - free)).sum();
                self.residual[block.offset + row] = momentum - self.impulse[block.offset + row];
            }
        }
    }

    fn relative_residual(&self) -> f64 {
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest, value| larger(largest, value.abs()));
        largest(&self.residual) / largest(&self.impulse).max(NO_IMPULSE / TOLERANCE)
    }

    /// The sum of the squared residuals, each divided by its velocity's own entry of the mass matrix.
    fn squared_residual(&self) -> f64 {
        let residuals = |block: &Block| self.residual[block.offset..block.offset + block.size].iter().enumerate();
        let squares = self.blocks.iter().flat_map(|block| {
            residuals(block).map(|(row, residual)| residual * residual / self.mass[block.mass + row * (block.size + 1)])
        });
        squares.sum()
    }
}
