//! Contacts between the engine's bodies, added to a step that the engine made without any.
//!
//! The engine finds which bounding boxes overlap, but computes no contacts. Before its step the poses, Jacobians and
//! velocities of every articulated body are copied. After it, the patches of the shapes that overlap are made from
//! those poses, [`crate::contact::solver`] finds the velocities with contacts, and these replace the engine's
//! velocities. The positions are changed to match.

use glam::DVec3;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::bounds::AllBounds;
use crate::contact::patch::Node;
use crate::contact::solver::{Convergence, Solver};
use crate::contact::surface::Surface;
use candidate::{Candidate, Detection, Meeting};
use copied::{Copied, mass_matrix};

mod apply;
mod candidate;
mod copied;
mod missed;
mod stops;
#[cfg(test)]
mod tests;

pub(super) use stops::JointStop;

/// The contact of two shapes in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct PatchContact {
    /// The shapes.
    pub(super) colliders: [ColliderHandle; 2],
    /// Centre of pressure when the step began, in the frames of the two bodies, m.
    pub(super) position_body: [DVec3; 2],
    /// Unit normal, world frame: the first body is pushed along it.
    pub(super) normal_world: DVec3,
    /// Normal impulse on the first body, N s.
    pub(super) normal_impulse: f64,
    /// Impulse on the first body with friction, N s, world frame.
    pub(super) impulse_world: DVec3,
    /// Moment of the friction on the first body about the normal, N m s, world frame.
    pub(super) moment_world: DVec3,
    /// Largest overlap of the undeformed shapes at the end of the step, m.
    pub(super) overlap_m: f64,
    /// Distance of the farthest part of the patch from its centre of pressure, m.
    pub(super) radius_m: f64,
    /// Velocity of the first surface against the second at the end of the step, in the tangent plane, m/s, world frame.
    pub(super) slip_world: DVec3,
}

/// Two colliders or two bodies, as raw handles, which can be sorted.
type PairKey = [(u32, u32); 2];

/// What a pair of shapes in contact keeps from step to step, in the frame of the second body.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Kept {
    /// The bodies.
    bodies: PairKey,
    /// The contact's normal.
    normal: DVec3,
    /// Elastic displacement of the contact along its surface, m.
    deflection: DVec3,
    /// Elastic rotation about the normal, times the patch's radius, m.
    deflection_about_normal: f64,
}

/// The state and the buffers of the contacts of one engine.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct ContactStep {
    /// The surfaces of the colliders, by the index in their handle.
    surfaces: Vec<Option<Surface>>,
    bounds: AllBounds,
    pub(super) stops: Vec<JointStop>,
    /// Sorted by pair.
    kept: Vec<(PairKey, Kept)>,
    /// The contacts of the last step.
    #[serde(skip)]
    pub(super) contacts: Vec<PatchContact>,
    /// The largest overlap of two shapes that should have pressed on each other in the last step but have no patch, m.
    #[serde(skip)]
    pub(super) missed_overlap_m: f64,
    /// How the last step was solved.
    #[serde(skip)]
    pub(super) convergence: Convergence,
    #[serde(skip)]
    scratch: Scratch,
}

/// Buffers, kept from step to step so that a step allocates little.
#[derive(Clone, Default)]
struct Scratch {
    bodies: Vec<Copied>,
    /// How many of the copied bodies are of this step.
    count: usize,
    pairs: Vec<[ColliderHandle; 2]>,
    candidates: Vec<Candidate>,
    nodes: Vec<Node>,
    detection: Detection,
    patches_of_body: Vec<usize>,
    order: Vec<usize>,
    block_of_body: Vec<usize>,
    mass: Vec<f64>,
    displacement: Vec<f64>,
    kept: Vec<(PairKey, Kept)>,
    solver: Solver,
}

/// The part of an engine that contacts work on.
pub(super) struct Parts<'a> {
    pub(super) bodies: &'a mut RigidBodySet,
    pub(super) colliders: &'a ColliderSet,
    pub(super) joints: &'a mut MultibodyJointSet,
    pub(super) narrow_phase: &'a NarrowPhase,
    pub(super) step_s: f64,
    /// Shapes that are farther apart have no contact, m.
    pub(super) near_m: f64,
}

impl ContactStep {
    /// Adds a collider with its surface.
    pub(super) fn add_collider(&mut self, collider: ColliderHandle, shape: &dyn Shape, surface: Surface) {
        self.bounds.set(collider, shape);
        let index = collider.into_raw_parts().0 as usize;
        if self.surfaces.len() <= index {
            self.surfaces.resize(index + 1, None);
        }
        self.surfaces[index] = Some(surface);
    }

    pub(super) fn surface(&self, collider: ColliderHandle) -> Option<Surface> {
        *self.surfaces.get(collider.into_raw_parts().0 as usize)?
    }

    /// Copies what the engine's step overwrites.
    pub(super) fn before_step(&mut self, bodies: &RigidBodySet, joints: &MultibodyJointSet) {
        let scratch = &mut self.scratch;
        scratch.count = 0;
        for multibody in joints.multibodies() {
            let root = multibody.root().rigid_body_handle();
            let Some(index) = joints.rigid_body_link(root).map(|link| link.multibody) else {
                continue;
            };
            if multibody.ndofs() == 0 {
                continue;
            }
            if scratch.count == scratch.bodies.len() {
                scratch.bodies.push(Copied::new(index));
            }
            let copied = &mut scratch.bodies[scratch.count];
            scratch.count += 1;
            copied.copy(index, multibody, bodies);
        }
    }

    /// Replaces the velocities and positions at the end of the engine's step by those with contacts.
    pub(super) fn after_step(&mut self, parts: &mut Parts) {
        self.contacts.clear();
        self.convergence = Convergence::default();
        self.find_patches(parts);
        if self.choose_blocks(parts) {
            self.fill_solver(parts);
            self.convergence = self.scratch.solver.solve();
            self.apply(parts);
        }
        self.keep();
    }

    /// Finds the patches of the shapes that may press on each other in this step, in an order that does not depend on
    /// the engine's.
    fn find_patches(&mut self, parts: &Parts) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.candidates.clear();
        scratch.nodes.clear();
        scratch.pairs.clear();
        let boxed = parts.narrow_phase.contact_pairs();
        scratch.pairs.extend(boxed.map(|pair| [pair.collider1, pair.collider2]));
        scratch.pairs.sort_unstable_by_key(key);
        self.missed_overlap_m = 0.0;
        let copies = &scratch.bodies[..scratch.count];
        for colliders in &scratch.pairs {
            let meeting = Meeting::of(self, *colliders, copies, parts);
            let Some(meeting) = meeting.filter(|meeting| meeting.is_near(&self.bounds, parts.near_m)) else {
                continue;
            };
            match self.candidate(&meeting, copies, &mut scratch.nodes, &mut scratch.detection, parts) {
                Some(candidate) => scratch.candidates.push(candidate),
                None => {
                    let missed_m = meeting.overlap_m(copies, parts, &mut scratch.detection.faces);
                    self.missed_overlap_m = self.missed_overlap_m.max(missed_m);
                }
            }
        }
        self.scratch = scratch;
    }

    fn kept(&self, key: &PairKey) -> Option<&Kept> {
        let at = self.kept.binary_search_by(|(other, _)| other.cmp(key)).ok()?;
        Some(&self.kept[at].1)
    }

    /// The state that another pair of shapes of the same two bodies keeps. A blade between two shapes of one link must
    /// not be pushed into one of them by the other.
    fn sibling(&self, bodies: &PairKey) -> Option<&Kept> {
        let mut kept = self.kept.iter().map(|(_, kept)| kept);
        kept.find(|kept| kept.bodies == *bodies)
    }

    /// Gives every articulated body that something may touch, or that is near an end stop, a block of the solver. The
    /// more patches and stops a body has, the later its block. Returns whether there are any blocks.
    fn choose_blocks(&mut self, parts: &Parts) -> bool {
        let scratch = &mut self.scratch;
        scratch.solver.start(parts.step_s);
        scratch.patches_of_body.clear();
        scratch.patches_of_body.resize(scratch.count, 0);
        for link in scratch.candidates.iter().flat_map(|candidate| candidate.links.iter().flatten()) {
            scratch.patches_of_body[link.body] += 1;
        }
        for stop in &self.stops {
            if let Some(body) = stop.body(&scratch.bodies[..scratch.count], parts) {
                scratch.patches_of_body[body] += 1;
            }
        }
        scratch.order.clear();
        let counts = &scratch.patches_of_body;
        scratch.order.extend((0..scratch.count).filter(|body| counts[*body] > 0));
        scratch.order.sort_by_key(|body| counts[*body]);
        scratch.block_of_body.clear();
        scratch.block_of_body.resize(scratch.count, usize::MAX);
        for body in &scratch.order {
            let copied = &scratch.bodies[*body];
            let Some(multibody) = parts.joints.get_multibody(copied.index) else {
                continue;
            };
            let mass = mass_matrix(multibody, &mut scratch.mass);
            scratch.block_of_body[*body] = scratch.solver.add_block(
                copied.velocity.iter().copied(),
                multibody.generalized_velocity().iter().copied(),
                |row, column| mass[(row, column)],
            );
        }
        !scratch.order.is_empty()
    }

    fn fill_solver(&mut self, parts: &Parts) {
        let scratch = &mut self.scratch;
        for candidate in &scratch.candidates {
            let nodes = &scratch.nodes[candidate.nodes.0..candidate.nodes.1];
            let patch = scratch.solver.add_patch(candidate.law, nodes, candidate.deflection);
            for (side, link) in candidate.links.iter().enumerate() {
                let Some(link) = link else { continue };
                let copied = &scratch.bodies[link.body];
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let columns = candidate.columns(copied, link.link, sign);
                scratch.solver.add_side(patch, side, scratch.block_of_body[link.body], columns);
            }
        }
        for stop in &self.stops {
            let Some(body) = stop.body(&scratch.bodies[..scratch.count], parts) else {
                continue;
            };
            let first = scratch.solver.offset(scratch.block_of_body[body]);
            for stop in stop.rows(first, parts).into_iter().flatten() {
                scratch.solver.add_stop(stop);
            }
        }
    }
}

fn key(colliders: &[ColliderHandle; 2]) -> PairKey {
    colliders.map(ColliderHandle::into_raw_parts)
}
