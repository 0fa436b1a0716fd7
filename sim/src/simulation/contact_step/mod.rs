//! Contacts between trees, added to a step that was prepared without any.
//!
//! Patches are found where shapes overlap after the step has begun. [`crate::contact::solver`] then finds the velocities
//! with contacts, and these replace the trees' own.

use glam::DVec3;
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::placed::{PlacedLink, Scene};
use crate::contact::chord::Faces;
use crate::contact::outline::Outline;
use crate::contact::patch::Node;
use crate::contact::plane::{DepthSearch, Plane};
use crate::contact::solver::{Convergence, Solver};
use crate::contact::surface::Interface;
use crate::physics::{PhysicsOptions, Theta};
use blocks::{Blocks, near_stops, stop_rows};
use candidate::{Candidate, Found, Meeting};

mod apply;
mod blocks;
mod candidate;
mod missed;
#[cfg(test)]
mod tests;

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
    /// Area on which the undeformed shapes overlap at the end of the step, m².
    pub(super) area_m2: f64,
    /// Velocity of the first surface against the second in the step, in the tangent plane, m/s, world frame.
    pub(super) slip_world: DVec3,
}

/// Two colliders or two bodies, as raw handles, which can be sorted.
type PairKey = [(u32, u32); 2];

/// What a pair of shapes that are near each other keeps from step to step, in the frame of the second body.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Kept {
    /// The bodies.
    bodies: PairKey,
    /// The contact's normal, or a direction that separates the shapes.
    normal: DVec3,
    /// The contact, if there is one.
    patch: Option<KeptPatch>,
}

/// What a contact keeps.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct KeptPatch {
    /// A place of the patch, m.
    origin: DVec3,
    /// Where its region ended, and the direction of its strips.
    outline: Outline,
    strip: DVec3,
    /// Elastic displacement of the contact along its surface, m.
    deflection: DVec3,
    /// Elastic rotation about the normal, times the patch's radius, m.
    deflection_about_normal: f64,
}

/// The state and the buffers of the contacts of one engine.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct ContactStep {
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
    candidates: Vec<Candidate>,
    nodes: Vec<Node>,
    faces: [Faces; 2],
    depth_search: DepthSearch,
    /// Pairs that a direction separates.
    apart: Vec<(PairKey, Kept)>,
    /// By slot: Σ k/m over the contacts, 1/s².
    contact_rate: Vec<f64>,
    blocks: Blocks,
    solver: Solver,
}

impl ContactStep {
    /// Finds the velocities u_θ of the step with contacts, and writes them into the trees.
    pub(super) fn step(&mut self, scene: &mut Scene, options: &PhysicsOptions) {
        let step_s = options.step_s;
        self.contacts.clear();
        self.convergence = Convergence::default();
        self.find_patches(scene, step_s);
        self.choose_theta(scene, options);
        let Scratch { candidates, blocks, solver, .. } = &mut self.scratch;
        solver.start(step_s);
        if blocks.choose(scene, candidates, solver) {
            self.fill_solver(scene);
            self.convergence = self.scratch.solver.solve();
            self.apply(scene, step_s);
        }
        self.keep();
    }

    /// Finds the patches of the shapes that may press on each other in this step, in an order that does not depend on
    /// the broad phase's.
    fn find_patches(&mut self, scene: &Scene, step_s: f64) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.candidates.clear();
        scratch.nodes.clear();
        scratch.apart.clear();
        self.missed_overlap_m = 0.0;
        for (colliders, mounts) in scene.near_pairs() {
            let meeting = Meeting::new(scene, colliders, mounts, step_s);
            match self.find(&meeting, &mut scratch.nodes, &mut scratch.faces, &mut scratch.depth_search) {
                Found::Patch(candidate) => scratch.candidates.push(candidate),
                Found::Apart(normal_world) => scratch.apart.push((key(&colliders), meeting.kept_apart(normal_world))),
                Found::Nothing => {
                    self.missed_overlap_m = self.missed_overlap_m.max(meeting.overlap_m(&mut scratch.faces));
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
        kept.find(|kept| kept.patch.is_some() && kept.bodies == *bodies)
    }

    /// Gives every tree the rule that its contacts need: their springs act side by side on what the tree's inertia lets
    /// move at them.
    fn choose_theta(&mut self, scene: &mut Scene, options: &PhysicsOptions) {
        let Scratch { candidates, nodes, contact_rate: rates, .. } = &mut self.scratch;
        rates.clear();
        rates.resize(scene.slots().len(), 0.0);
        for candidate in candidates.iter() {
            let Interface { stiffness_n_per_m3, layer, .. } = &candidate.law.interface;
            let hardened_m2 = |node: &Node| node.area_m2 * layer.pressed(node.overlap_m).1;
            let area_m2: f64 = nodes[candidate.nodes.0..candidate.nodes.1].iter().map(hardened_m2).sum();
            let stiffness_n_per_m = area_m2 * stiffness_n_per_m3;
            for PlacedLink { slot, link } in candidate.links.iter().flatten() {
                let tree = scene.tree_mut(*slot);
                let Plane { origin_world, normal_world, .. } = candidate.plane;
                rates[*slot] += stiffness_n_per_m * tree.mobility(*link, origin_world, normal_world);
            }
        }
        for (slot, rate) in rates.iter().enumerate().filter(|(_, rate)| **rate > 0.0) {
            let tree = scene.tree_mut(slot);
            let theta = tree.theta().or_more(Theta::of_phase(options.step_s * rate.sqrt(), Theta::EULER));
            if theta != tree.theta() {
                tree.set_theta(theta);
                tree.prepare(options.gravity_m_per_s2);
            }
        }
        for candidate in candidates {
            candidate.law.theta = scene.theta(&candidate.links);
        }
    }

    fn fill_solver(&mut self, scene: &Scene) {
        let Scratch { candidates, nodes, blocks, solver, .. } = &mut self.scratch;
        for candidate in candidates.iter() {
            let nodes = &nodes[candidate.nodes.0..candidate.nodes.1];
            let patch = solver.add_patch(candidate.law, nodes, candidate.deflection);
            for (side, link) in candidate.links.iter().enumerate() {
                let Some(PlacedLink { slot, link }) = *link else { continue };
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let columns = solver.add_side(patch, side, blocks.block(slot));
                candidate.fill_columns(scene.tree(slot), link, sign, blocks.places(slot), columns);
            }
        }
        for (slot, block) in blocks.trees() {
            let first = solver.offset(block);
            let (tree, places) = (scene.tree(slot), blocks.places(slot));
            for (at, own) in near_stops(tree) {
                let index = places[at].map(|place| first + place);
                solver.stops.extend(index.into_iter().flat_map(|index| stop_rows(index, own, tree)));
            }
        }
    }
}

fn key(colliders: &[ColliderHandle; 2]) -> PairKey {
    colliders.map(ColliderHandle::into_raw_parts)
}
