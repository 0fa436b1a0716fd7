//! Writes what the contacts changed into the trees, and keeps what the next step needs.

use nalgebra::Vector3;
use underbrush_recording::math::larger;

use super::{ContactStep, Kept, KeptPatch, PatchContact, Scene, key};
use crate::contact::law::center_of_pressure;
use crate::contact::patch::Node;

impl ContactStep {
    /// Writes the velocities into the trees, and the contacts of the step into [`ContactStep::contacts`].
    pub(super) fn apply(&mut self, scene: &mut Scene, step_s: f64) {
        let scratch = &mut self.scratch;
        for (slot, block) in scratch.blocks.trees() {
            if scratch.solver.is_changed(block) {
                let velocity = scratch.solver.velocity(block);
                let places = scratch.blocks.places(slot);
                scene.tree_mut(slot).set_next(|at| places[at].map(|place| velocity[place]));
            }
        }
        for (patch, candidate) in scratch.solver.patches.iter().zip(&scratch.candidates) {
            let normal_impulse = patch.normal.impulse[0];
            if normal_impulse <= 0.0 {
                continue;
            }
            let plane = &candidate.plane;
            let (normal_speeds, slip_speeds) = patch.speeds();
            let at = center_of_pressure(&patch.normal.impulse);
            let position_world = plane.origin_world + plane.vector_world(at.x, at.y);
            let tangential = |parts: &Vector3<f64>| plane.vector_world(parts[0], parts[1]);
            let nodes = &scratch.nodes[candidate.nodes.0..candidate.nodes.1];
            let overlap_m = |node: &Node| node.overlap_m - step_s * node.parting(&normal_speeds);
            self.contacts.push(PatchContact {
                colliders: candidate.colliders,
                position_body: candidate.body_poses.map(|pose| pose.inverse_transform_point(position_world)),
                normal_world: plane.normal_world,
                normal_impulse,
                impulse_world: plane.normal_world * normal_impulse + tangential(&patch.friction.impulse),
                moment_world: plane.normal_world * (candidate.radius_m * patch.friction.impulse[2]),
                overlap_m: nodes.iter().map(overlap_m).fold(f64::NEG_INFINITY, larger),
                area_m2: nodes.iter().filter(|node| overlap_m(node) > 0.0).map(|node| node.area_m2).sum(),
                radius_m: nodes.iter().map(|node| node.place.distance(at)).fold(0.0, f64::max),
                slip_world: tangential(&slip_speeds),
            });
        }
    }

    /// Keeps what the pairs need in the next step.
    pub(super) fn keep(&mut self) {
        let ContactStep { kept, scratch, .. } = self;
        kept.clear();
        for (patch, candidate) in scratch.solver.patches.iter().zip(&scratch.candidates) {
            let to_body = |vector| candidate.body_poses[1].inverse_transform_vector(vector);
            let deflection = if patch.normal.impulse[0] > 0.0 { patch.deflection_after_m() } else { Vector3::zeros() };
            let (outline, strip_world) = candidate.next.region.unwrap_or_default();
            let patch = KeptPatch {
                origin: candidate.body_poses[1].inverse_transform_point(candidate.next.origin_world),
                outline,
                strip: to_body(strip_world),
                deflection: to_body(candidate.plane.vector_world(deflection[0], deflection[1])),
                deflection_about_normal: deflection[2],
            };
            let normal = to_body(candidate.next.normal_world);
            kept.push((key(&candidate.colliders), Kept { bodies: candidate.bodies, normal, patch: Some(patch) }));
        }
        kept.append(&mut scratch.apart);
        kept.sort_unstable_by_key(|(pair, _)| *pair);
    }
}
