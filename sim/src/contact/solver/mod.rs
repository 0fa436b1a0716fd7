//! The velocities of a step, under the contact law.
//!
//! Without contacts the trees would move with the generalized velocities u*, which are those at θ of the step. With the
//! mass matrix M of the step over θ (it includes joint springs and dampers), the velocities u with contacts satisfy
//!
//!   M (u − u*) = Σ Jᵀ λ(J u),
//!
//! where J maps u to the speeds of a patch, and λ is the impulse of [`super::law`]. Newton's method solves for normal
//! impulses and friction together. Friction has the limit μ N, so the derivative is not symmetric, and a step may lead
//! away from the solution.
//!
//! If the limits are held fixed, the solution is the minimum of a strictly convex function: the kinetic term and the
//! potentials of the law. Newton's method with a line search along this function finds the minimum from any start. This
//! method takes over where a step of the first one does not help, and completely after `JOINT_ITERATIONS`. The limits
//! are then held until the function is minimized, and moved half way to their new values. The error that remains is
//! reported as the residual.

use nalgebra::Vector3;

use super::block_matrix::{BlockMatrix, Lanes};
use super::law::{Law, NormalSpeeds, Response, SlipSpeeds, Stop};
use super::patch::Node;

mod iteration;
mod newton_step;

/// Rows of a patch: parting speed and angular velocities about the tangents, then slip and r times the angular velocity
/// about the normal.
pub const ROWS: usize = 6;

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

/// The block that moves one side of a patch.
#[derive(Clone, Copy, Debug)]
struct Side {
    block: usize,
    /// Where its columns begin: one for each velocity of the block.
    columns: usize,
}

/// One patch in the solver.
#[derive(Clone, Debug)]
pub struct Patch {
    law: Law,
    nodes: (usize, usize),
    sides: [Option<Side>; 2],
    deflection: Vector3<f64>,
    /// Slip at the start of the step.
    before: SlipSpeeds,
    speeds: [f64; ROWS],
    change: [f64; ROWS],
    /// The law at the present speeds: normal impulse on the first body and its moments about the tangents, N s and N m s.
    pub normal: Response,
    /// Friction impulse along the tangents, N s, and moment about the normal over r.
    pub friction: Response,
    /// Largest friction impulse, N s, and the one that was held before.
    limit: f64,
    held: f64,
}

impl Patch {
    /// Parting speeds and slip at the velocities u_θ.
    pub fn speeds(&self) -> (NormalSpeeds, SlipSpeeds) {
        split(&self.speeds)
    }

    /// Elastic displacement at the end of the step, m.
    pub fn deflection_after_m(&self) -> Vector3<f64> {
        self.law.deflection_after(&self.deflection, &self.speeds().1)
    }
}

/// How the solver converged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Number of iterations.
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
    /// For one side of a patch: its columns times the patch's stiffness, transposed and not. Lanes of columns, row by row.
    pushed: [Vec<[Lanes; ROWS]>; 2],
    nodes: Vec<Node>,
    /// The patches, in the order in which they were added.
    pub patches: Vec<Patch>,
    /// The end stops of joints.
    pub stops: Vec<Stop>,
    free: Vec<f64>,
    velocity: Vec<f64>,
    impulse: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
    matrix: BlockMatrix,
}

impl Solver {
    /// Begins a new step and removes everything that belonged to the last one.
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

    /// Adds an articulated body and returns its index. `before` holds its velocities at the start of the step, `free`
    /// its velocities u_θ if nothing touches it, and `mass` returns the entries of its mass matrix over θ. Bodies that
    /// many others touch should come last.
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
        self.blocks.push(Block { offset, size, mass: self.mass.len() });
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
            before: Vector3::zeros(),
            speeds: [0.0; ROWS],
            change: [0.0; ROWS],
            normal: Response::default(),
            friction: Response::default(),
            limit: 0.0,
            held: 0.0,
        });
        self.patches.len() - 1
    }

    /// Says which block moves one side of a patch. Returns the columns to fill: the six speeds of that side for each
    /// velocity of the block, with a minus sign for the second side. They are zero.
    pub fn add_side(&mut self, patch: usize, side: usize, block: usize) -> &mut [[f64; ROWS]] {
        let first = self.columns.len();
        self.columns.resize(first + self.blocks[block].size, [0.0; ROWS]);
        self.patches[patch].sides[side] = Some(Side { block, columns: first });
        &mut self.columns[first..]
    }

    /// The velocities of a block.
    pub fn velocity(&self, block: usize) -> &[f64] {
        let block = self.blocks[block];
        &self.velocity[block.offset..block.offset + block.size]
    }

    /// Whether contacts changed the velocities of a block.
    pub fn is_changed(&self, block: usize) -> bool {
        let Block { offset, size, .. } = self.blocks[block];
        self.velocity[offset..offset + size] != self.free[offset..offset + size]
    }

    /// Index of a block's first velocity.
    pub fn offset(&self, block: usize) -> usize {
        self.blocks[block].offset
    }
}

/// The first three and the last three rows.
fn split(values: &[f64; ROWS]) -> (Vector3<f64>, Vector3<f64>) {
    let [a, b, c, d, e, f] = *values;
    (Vector3::new(a, b, c), Vector3::new(d, e, f))
}

fn join(first: Vector3<f64>, second: Vector3<f64>) -> [f64; ROWS] {
    [first[0], first[1], first[2], second[0], second[1], second[2]]
}
