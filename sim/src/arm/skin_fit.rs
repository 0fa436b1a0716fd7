//! Checks how the taxels lie on their links. Contacts occur on a link's collision shapes, so a taxel that is away from
//! them or faces into the link would feel nothing; such a skin is refused. A taxel that is slightly off is reported as
//! doubtful.

use glam::DVec3;
use underbrush_recording::{InputError, Patch, Pose, Taxel};

use super::skin::{FACING_COSINE, reach_m};
use super::source::Source;
use super::{Arm, Link};
use crate::geometry::PlacedShape;

/// A link's collision shapes, posed in its frame.
pub(super) struct Surface(pub(super) Vec<PlacedShape>);

/// Step of the finite difference that measures the surface's direction, m: finer than the features of the shapes.
const STEP_M: f64 = 5e-4;

impl Surface {
    pub(super) fn of(link: &Link) -> Self {
        Surface(link.placed_shapes(Pose::IDENTITY).collect())
    }

    /// Distance of a point from the surface of all shapes together, m; negative inside.
    pub(super) fn distance_m(&self, point: DVec3) -> f64 {
        self.0.iter().map(|shape| shape.signed_distance_m(point)).fold(f64::INFINITY, f64::min)
    }

    /// Cosine between a taxel's normal and the surface's: the rate at which the distance grows along the normal. It is
    /// measured just outside, where faces that lie inside another shape do not count.
    pub(super) fn facing_cosine(&self, position: DVec3, normal: DVec3) -> f64 {
        let depth_m = (-self.distance_m(position)).max(0.0);
        let at = |steps: f64| self.distance_m(position + normal * (2.0 * depth_m + steps * STEP_M));
        (at(2.0) - at(1.0)) / STEP_M
    }
}

/// Refuses a patch with taxels that cannot feel; `path` is that of the patch in the file.
///
/// # Errors
/// When the link has no collision shape, or a taxel faces into the link or is farther from its surface than a contact
/// of this patch may be from its taxels.
pub(super) fn check(source: &Source, path: &str, patch: &Patch, link: &Link) -> Result<(), InputError> {
    let surface = Surface::of(link);
    let fault = |taxel: usize, found: String, allowed: String| {
        let field = format!("patch {}, taxel {taxel}", patch.name);
        let remedy = "move the taxels onto the link's collision shapes, or give the link shapes that fit them";
        let described = match patch.grid {
            Some(_) => format!("{path}.cylinder"),
            None => format!("{path}.points.taxels[{taxel}]"),
        };
        Err(source.fault(field, found, allowed, remedy).at_line(source.line_setting(&described)))
    };
    if surface.0.is_empty() {
        let found = format!("link {} without a collision shape", link.name);
        return fault(0, found, "a link with collision shapes, because only these can be touched".into());
    }
    let reach = reach_m(&patch.taxels);
    for (number, taxel) in patch.taxels.iter().enumerate() {
        let distance_m = surface.distance_m(taxel.position_link);
        if distance_m.abs() > reach {
            let allowed = format!(
                "at most {:.1} mm from it; contacts farther than that from the patch's taxels belong to the bare link",
                reach * 1000.0
            );
            return fault(number, place(distance_m, &link.name), allowed);
        }
        if surface.facing_cosine(taxel.position_link, taxel.normal_link) <= 0.0 {
            let found = format!("a normal that points into link {}", link.name);
            let allowed = "a normal that points out of the link, because nothing presses from inside";
            return fault(number, found, allowed.into());
        }
    }
    Ok(())
}

fn place(distance_m: f64, link: &str) -> String {
    let side = if distance_m < 0.0 { "under" } else { "above" };
    format!("{:.1} mm {side} the collision surface of link {link}", distance_m.abs() * 1000.0)
}

impl Arm {
    /// What is doubtful about the skin: taxels so far off the collision surface that a contact's force may go to a neighbour (more
    /// than half the patch's reach), taxels whose normal is more than 60° off the surface's, which feel only what presses from
    /// the side, and patches that lie on other ones.
    pub fn skin_doubts(&self) -> Vec<String> {
        let patches = self.skin.layout.patches.iter().zip(&self.skin.surfaces);
        let covered = patches.clone().enumerate().flat_map(|(number, (patch, own))| {
            let before = patches.clone().take(number).filter(|(_, other)| other.link == own.link);
            before.filter_map(|(other, _)| hidden(patch, other))
        });
        patches.clone().flat_map(|(patch, own)| doubts(patch, &self.links[own.link])).chain(covered).collect()
    }
}

/// Says so if most taxels of a patch lie on those of another one on the same link.
fn hidden(patch: &Patch, other: &Patch) -> Option<String> {
    // More than half a diagonal of a square grid, less than its pitch.
    let near_m = 0.75 * reach_m(&other.taxels);
    let lies_on = |own: &&Taxel| other.taxels.iter().any(|one| one.position_link.distance(own.position_link) < near_m);
    let (count, all) = (patch.taxels.iter().filter(lies_on).count(), patch.taxels.len());
    let text = || format!("patch {}: {count} of {all} taxels lie on those of patch {}", patch.name, other.name);
    (2 * count > all).then(text)
}

fn doubts(patch: &Patch, link: &Link) -> Vec<String> {
    let surface = Surface::of(link);
    let bound_m = reach_m(&patch.taxels) / 2.0;
    let count = patch.taxels.len();
    let mut found = Vec::new();
    let distances: Vec<f64> = patch.taxels.iter().map(|taxel| surface.distance_m(taxel.position_link)).collect();
    let off = distances.iter().filter(|distance| distance.abs() > bound_m).count();
    let farthest = (0..count).max_by(|a, b| distances[*a].abs().total_cmp(&distances[*b].abs()));
    if let Some(farthest) = farthest.filter(|_| off > 0) {
        let (bound_mm, place) = (bound_m * 1000.0, place(distances[farthest], &link.name));
        let text = format!("{off} of {count} taxels are more than {bound_mm:.1} mm off the collision surface");
        found.push(format!("patch {}: {text}; taxel {farthest} is {place}", patch.name));
    }
    let misaligned = |taxel: &&Taxel| surface.facing_cosine(taxel.position_link, taxel.normal_link) <= FACING_COSINE;
    let misaligned = patch.taxels.iter().filter(misaligned).count();
    if misaligned > 0 {
        found.push(format!(
            "patch {}: {misaligned} of {count} normals are more than 60° off the collision surface of link {}",
            patch.name, link.name
        ));
    }
    found
}
