//! How the taxels lie on their links. Contacts are made on a link's collision shapes, so a taxel that lies off them, or
//! faces into the link, feels nothing; such a skin is refused. What feels, but not quite where it lies, is doubtful.

use glam::DVec3;
use underbrush_recording::{InputError, Patch, Taxel};

use super::skin::{FACING_COSINE, reach_m};
use super::source::Source;
use super::{Arm, Link};
use crate::geometry::{PlacedShape, engine_shape};

/// A link's collision shapes, posed in its frame.
struct Surface(Vec<PlacedShape>);

/// Step over which the surface's direction is measured, m: finer than the features of shapes.
const STEP_M: f64 = 5e-4;

impl Surface {
    fn of(link: &Link) -> Self {
        let shapes = link.colliders.iter().filter_map(|collider| {
            let (shape, turn) = engine_shape(&collider.shape)?;
            Some(PlacedShape {
                shape,
                pose: collider.pose_link * turn,
            })
        });
        Surface(shapes.collect())
    }

    /// Distance of a point from the surface of all shapes together, m; negative within.
    fn distance_m(&self, point: DVec3) -> f64 {
        let distances = self.0.iter().map(|shape| shape.signed_distance_m(point));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Cosine between a taxel's normal and the surface's: how fast the distance grows along the normal just outside, where
    /// faces that shapes hide from each other do not count.
    fn facing_cosine(&self, taxel: &Taxel) -> f64 {
        let depth_m = (-self.distance_m(taxel.position_link)).max(0.0);
        let at =
            |steps: f64| self.distance_m(taxel.position_link + taxel.normal_link * (2.0 * depth_m + steps * STEP_M));
        (at(2.0) - at(1.0)) / STEP_M
    }
}

/// Refuses the taxels of a patch that cannot feel; `offsets` are the bytes of the file at which each is described.
///
/// # Errors
/// Where the link has no collision shape, or a taxel is farther from the link's surface than a contact of this patch may be
/// from its taxels, or faces into the link.
pub(super) fn check(source: &Source, offsets: &[usize], patch: &Patch, link: &Link) -> Result<(), InputError> {
    let surface = Surface::of(link);
    let fault = |taxel: usize, found: String, allowed: String| {
        let field = format!("patch {}, taxel {taxel}", patch.name);
        let remedy = "move the taxels onto the link's collision shapes, or give the link shapes that fit them";
        let line = source.line(offsets.get(taxel).copied().unwrap_or(0));
        Err(source.fault(field, found, allowed, remedy).at_line(line))
    };
    if surface.0.is_empty() {
        let found = format!("link {} without a collision shape", link.name);
        return fault(0, found, "a link with collision shapes: only they are touched".into());
    }
    let reach = reach_m(&patch.taxels);
    for (number, taxel) in patch.taxels.iter().enumerate() {
        let distance_m = surface.distance_m(taxel.position_link);
        let touchable = distance_m.abs() <= reach;
        if !touchable {
            let allowed = format!(
                "at most {:.1} mm off it: contacts farther than that from the patch's taxels are the bare link's",
                reach * 1000.0
            );
            return fault(number, place(distance_m, &link.name), allowed);
        }
        let faces_out = surface.facing_cosine(taxel) > 0.0;
        if !faces_out {
            let found = format!("a normal that points into link {}", link.name);
            return fault(
                number,
                found,
                "a normal that points out of it: nothing presses from within".into(),
            );
        }
    }
    Ok(())
}

fn place(distance_m: f64, link: &str) -> String {
    let side = if distance_m < 0.0 { "under" } else { "above" };
    format!(
        "{:.1} mm {side} the collision surface of link {link}",
        distance_m.abs() * 1000.0
    )
}

impl Arm {
    /// What is doubtful about the skin, a sentence a patch: taxels more than half of the patch's reach off the collision
    /// surface, where a contact's force may go to a neighbour, and taxels whose normal is more than 60° off the surface's,
    /// which feel only what presses from the side.
    pub fn skin_doubts(&self) -> Vec<String> {
        let patches = self.skin.layout.patches.iter().zip(&self.skin.surfaces);
        patches
            .flat_map(|(patch, surface)| doubts(patch, &self.links[surface.link]))
            .collect()
    }
}

fn doubts(patch: &Patch, link: &Link) -> Vec<String> {
    let surface = Surface::of(link);
    let bound_m = reach_m(&patch.taxels) / 2.0;
    let count = patch.taxels.len();
    let mut found = Vec::new();
    let distances: Vec<f64> = patch
        .taxels
        .iter()
        .map(|taxel| surface.distance_m(taxel.position_link))
        .collect();
    let off = distances.iter().filter(|distance| distance.abs() > bound_m).count();
    let farthest = (0..count).max_by(|a, b| distances[*a].abs().total_cmp(&distances[*b].abs()));
    if let Some(farthest) = farthest.filter(|_| off > 0) {
        found.push(format!(
            "patch {}: {off} of {count} taxels lie more than {:.1} mm off the collision surface; taxel {farthest} lies {}",
            patch.name,
            bound_m * 1000.0,
            place(distances[farthest], &link.name)
        ));
    }
    let turned = |taxel: &&Taxel| surface.facing_cosine(taxel) <= FACING_COSINE;
    let turned = patch.taxels.iter().filter(turned).count();
    if turned > 0 {
        found.push(format!(
            "patch {}: {turned} of {count} normals are more than 60° off the collision surface of link {}",
            patch.name, link.name
        ));
    }
    found
}
