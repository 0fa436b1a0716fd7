//! The velocities at the end of a step, under the contact law.
//!
//! Without contacts the engine would end the step with the generalized velocities u*. With the mass matrix M of its implicit
//! step (which includes joint springs and dampers), the velocities u with contacts satisfy
//!
//!   M (u − u*) = Σ Jᵀ λ(J u),
//!
//! where J gives the speeds of a patch from u, and λ is the impulse of [`super::law`]. For friction limits μ N that are held
//! fixed this is the minimum of a strictly convex function: the kinetic term and the potentials of the law. Newton's method
//! with a line search along the convex function finds it from any start. The limits are those of the present iterate, so that
//! usually the whole converges together; if it does not within `JOINT_ITERATIONS`, the limits are held until the convex
//! function is minimized, and then renewed, half way. What remains unsolved is reported as the residual.

use nalgebra::Vector3;

use super::envelope::Envelope;
use super::law::{Law, NormalSpeeds, Response, SlipSpeeds};
use super::patch::Node;
use super::stop::Stop;

mod newton_step;

/// Rows of a patch: parting speed and angular velocities about the tangents, then slip and r times the angular velocity
/// about the normal.
pub const ROWS: usize = 6;

/// Iterations for normal impulses and friction together.
const JOINT_ITERATIONS: usize = 20;
/// A step is accepted there if it leaves at most this part of the squared residual.
const SUFFICIENT: f64 = 0.5;
/// Iterations altogether.
const MAX_ITERATIONS: usize = 200;
/// The residual at which the iteration ends, relative to the largest generalized impulse.
const TOLERANCE: f64 = 1e-6;
/// Below this, N s or N m s, an impulse is rounding.
const NO_IMPULSE: f64 = 1e-14;

/// The degrees of freedom of one articulated body among all.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Index of its first velocity.
    offset: usize,
    /// Number of its velocities.
    size: usize,
    /// Where its mass matrix begins.
    mass: usize,
}

/// What moves one side of a patch.
#[derive(Clone, Copy, Debug)]
struct Side {
    block: usize,
    /// Where its columns begin: one for each velocity of the block.
    columns: usize,
}

/// One patch as the solver sees it.
#[derive(Clone, Debug)]
struct Patch {
    law: Law,
    nodes: (usize, usize),
    sides: [Option<Side>; 2],
    deflection: Vector3<f64>,
    speeds: [f64; ROWS],
    change: [f64; ROWS],
    /// The law at the present speeds.
    normal: Response,
    friction: Response,
    /// Largest friction impulse, N s, and the one that was held before.
    limit: f64,
    held: f64,
}

/// The outcome for one patch.
#[derive(Clone, Copy, Debug)]
pub struct Solved {
    /// Normal impulse on the first body and its moments about the tangents, N s and N m s.
    pub normal_impulse: Vector3<f64>,
    /// Friction impulse along the tangents, N s, and moment about the normal over r.
    pub friction_impulse: Vector3<f64>,
    /// Parting speeds at the end of the step.
    pub normal_speeds: NormalSpeeds,
    /// Slip at the end of the step.
    pub slip_speeds: SlipSpeeds,
    /// Elastic displacement at the end of the step, m.
    pub deflection_m: Vector3<f64>,
}

/// How a solution went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Iterations.
    pub iterations: usize,
    /// Largest entry of the residual, relative to the largest generalized impulse.
    pub residual: f64,
}

/// Contacts of one step. Its buffers are kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    step_s: f64,
    blocks: Vec<Block>,
    mass: Vec<f64>,
    columns: Vec<[f64; ROWS]>,
    nodes: Vec<Node>,
    patches: Vec<Patch>,
    stops: Vec<Stop>,
    free: Vec<f64>,
    velocity: Vec<f64>,
    impulse: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    matrix: Envelope,
}

impl Solver {
    /// Forgets the last step.
    pub fn start(&mut self, step_s: f64) {
        self.step_s = step_s;
        self.blocks.clear();
        self.mass.clear();
        self.columns.clear();
        self.nodes.clear();
        self.patches.clear();
        self.stops.clear();
        self.free.clear();
        self.velocity.clear();
    }

    /// Adds an articulated body with its velocities at the start of the step, and at its end if nothing touched it. `mass`
    /// returns the entries of its mass matrix. Bodies that many others touch should come last.
    pub fn add_block(
        &mut self,
        before: impl Iterator<Item = f64>,
        free: impl Iterator<Item = f64>,
        mass: impl Fn(usize, usize) -> f64,
    ) -> usize {
        let offset = self.free.len();
        self.free.extend(free);
        self.velocity.extend(before);
        let size = self.free.len() - offset;
        self.blocks.push(Block {
            offset,
            size,
            mass: self.mass.len(),
        });
        for row in 0..size {
            self.mass.extend((0..size).map(|column| mass(row, column)));
        }
        self.blocks.len() - 1
    }

    /// Adds a patch with its columns of area, and returns its index.
    pub fn add_patch(&mut self, law: Law, nodes: &[Node], deflection_m: Vector3<f64>) -> usize {
        let first = self.nodes.len();
        self.nodes.extend_from_slice(nodes);
        self.patches.push(Patch {
            law,
            nodes: (first, self.nodes.len()),
            sides: [None; 2],
            deflection: deflection_m,
            speeds: [0.0; ROWS],
            change: [0.0; ROWS],
            normal: Response::default(),
            friction: Response::default(),
            limit: 0.0,
            held: 0.0,
        });
        self.patches.len() - 1
    }

    /// Says how a block moves one side of a patch: the six speeds of that side for each velocity of the block, with a
    /// minus for the second side.
    pub fn add_side(&mut self, patch: usize, side: usize, block: usize, columns: impl Iterator<Item = [f64; ROWS]>) {
        let first = self.columns.len();
        self.columns.extend(columns);
        self.patches[patch].sides[side] = Some(Side { block, columns: first });
    }

    /// Adds the end stop of a joint.
    pub fn add_stop(&mut self, stop: Stop) {
        self.stops.push(stop);
    }

    /// The velocities of a block.
    pub fn velocity(&self, block: usize) -> &[f64] {
        let block = self.blocks[block];
        &self.velocity[block.offset..block.offset + block.size]
    }

    /// By how much contacts changed the velocities of a block.
    pub fn change(&self, block: usize) -> impl Iterator<Item = f64> + '_ {
        let block = self.blocks[block];
        let range = block.offset..block.offset + block.size;
        self.velocity[range.clone()]
            .iter()
            .zip(&self.free[range])
            .map(|(u, free)| u - free)
    }

    /// Index of a block's first velocity.
    pub fn offset(&self, block: usize) -> usize {
        self.blocks[block].offset
    }

    /// The outcome for a patch.
    pub fn solved(&self, patch: usize) -> Solved {
        let patch = &self.patches[patch];
        let (normal_speeds, slip_speeds) = split(&patch.speeds);
        Solved {
            normal_impulse: patch.normal.impulse,
            friction_impulse: patch.friction.impulse,
            normal_speeds,
            slip_speeds,
            deflection_m: patch.law.deflection_after(&patch.deflection, &slip_speeds),
        }
    }

    /// Finds the velocities at the end of the step.
    pub fn solve(&mut self) -> Convergence {
        let size = self.velocity.len();
        self.residual.resize(size, 0.0);
        self.impulse.resize(size, 0.0);
        self.step.resize(size, 0.0);
        self.shape_matrix();
        self.read_speeds(false);
        let mut convergence = self.solve_together();
        if convergence.residual > TOLERANCE {
            self.solve_by_limits(&mut convergence);
        }
        convergence
    }

    /// Newton's method for normal impulses and friction together. Where a step does not help, one under held friction limits
    /// is gone instead, as far as the convex function falls.
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
            let share = self.line_search();
            self.go(share);
            self.evaluate(false);
        }
    }

    /// Minimizes the convex function of held friction limits, renews the limits half way, and so on.
    fn solve_by_limits(&mut self, convergence: &mut Convergence) {
        loop {
            self.evaluate(true);
            let is_last = convergence.iterations == MAX_ITERATIONS;
            if is_last || self.relative_residual() <= TOLERANCE {
                // What the held limits hide counts as well.
                self.hold_limits();
                self.evaluate(false);
                convergence.residual = self.relative_residual();
                if is_last || convergence.residual <= TOLERANCE {
                    return;
                }
                self.move_limits();
                self.evaluate(true);
            }
            convergence.iterations += 1;
            if !self.find_step(false) {
                return;
            }
            let share = self.line_search();
            self.go(share);
        }
    }

    /// Finds the Newton step. `is_coupled`: for friction limits that follow the normal impulses. Returns whether there is one.
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

    /// Goes a share of the Newton step.
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

    /// Impulses and the residual M (u − u*) − Σ Jᵀ λ at the present speeds, with friction limits that are held or those of the
    /// normal impulses.
    fn evaluate(&mut self, hold_limits: bool) {
        self.impulse.fill(0.0);
        for patch in &mut self.patches {
            let (normal_speeds, slip_speeds) = split(&patch.speeds);
            let nodes = &self.nodes[patch.nodes.0..patch.nodes.1];
            patch.normal = patch.law.normal(nodes, &normal_speeds);
            if !hold_limits {
                patch.limit = patch.law.interface.friction * patch.normal.impulse[0];
            }
            patch.friction = patch.law.friction(&patch.deflection, patch.limit, &slip_speeds);
            let (normal, friction) = (&patch.normal.impulse, &patch.friction.impulse);
            let impulse = [normal[0], normal[1], normal[2], friction[0], friction[1], friction[2]];
            for side in patch.sides.iter().flatten() {
                let block = self.blocks[side.block];
                let columns = &self.columns[side.columns..side.columns + block.size];
                for (column, sum) in columns.iter().zip(&mut self.impulse[block.offset..]) {
                    let parts = column.iter().zip(&impulse).map(|(entry, impulse)| entry * impulse);
                    *sum += parts.sum::<f64>();
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
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        largest(&self.residual) / largest(&self.impulse).max(NO_IMPULSE / TOLERANCE)
    }

    /// The sum of the squared residuals, each divided by its velocity's own entry of the mass matrix.
    fn squared_residual(&self) -> f64 {
        let residuals = |block: &Block| {
            self.residual[block.offset..block.offset + block.size]
                .iter()
                .enumerate()
        };
        let squares = self.blocks.iter().flat_map(|block| {
            residuals(block).map(|(row, residual)| residual * residual / self.mass[block.mass + row * (block.size + 1)])
        });
        squares.sum()
    }

    fn hold_limits(&mut self) {
        for patch in &mut self.patches {
            patch.held = patch.limit;
        }
    }

    /// Moves the friction limits half way from those that were held to the present ones.
    fn move_limits(&mut self) {
        for patch in &mut self.patches {
            patch.limit = 0.5 * (patch.held + patch.limit);
        }
    }
}

/// The first three and the last three rows.
fn split(values: &[f64; ROWS]) -> (Vector3<f64>, Vector3<f64>) {
    let [a, b, c, d, e, f] = *values;
    (Vector3::new(a, b, c), Vector3::new(d, e, f))
}
