//! Places the objects of a scene one by one, clear of each other and of the arm.

use glam::DVec2;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::{InputError, Limits};

use super::PlacedObject;
use crate::arm::ArmAtStart;
use crate::object::Footing;
use crate::object::structure::CollisionGroup;
use crate::range::{Draw, PLACE_M, YAW_DEG};
use crate::scene::{Scene, Workspace};

/// Clearance between the arm in its start posture and any object, m.
pub(super) const START_CLEARANCE_M: f64 = 0.02;
/// Clearance between a leaf's foot and the edge of its block, m.
const BLOCK_MARGIN_M: f64 = 0.01;
/// Places tried for one object before everything is drawn again.
const PLACES: usize = 1000;

/// Places every object of a scene.
pub(super) fn place_all(
    scene: &Scene,
    arm: &ArmAtStart,
    random: &mut ChaCha8Rng,
) -> Result<Vec<PlacedObject>, InputError> {
    let workspace = &scene.file.workspace;
    let mut objects: Vec<PlacedObject> = Vec::new();
    for (kind, number, group) in scene.file.objects.groups() {
        let field = format!("objects.{kind}[{number}]");
        for done in 0..group.count {
            let mut rejected = Rejections::default();
            let mut found = None;
            for _ in 0..PLACES {
                let mut draw = |given: Option<Draw>, [low, high]: [f64; 2], limits: Limits| {
                    given.unwrap_or(Draw::Uniform(low, high)).draw(random, limits).unwrap_or(low)
                };
                let yaw_rad = draw(group.place.yaw_deg, [-180.0, 180.0], YAW_DEG).to_radians();
                let x = draw(group.place.x_m, workspace.x_m, PLACE_M);
                let center = DVec2::new(x, draw(group.place.y_m, workspace.y_m, PLACE_M));
                let Some((footing, stands_on)) = ground(group.needs_foam, workspace, &objects, center) else {
                    rejected.no_foam += 1;
                    continue;
                };
                let (object, drawn) = group.draw(random, &footing).map_err(|error| scene.draw_fault(&field, error))?;
                let foot_world = center.extend(footing.height_m);
                let placed = PlacedObject { object, category: group.category, foot_world, yaw_rad, stands_on, drawn };
                if rejected.allows(&placed, &objects, arm) {
                    found = Some(placed);
                    break;
                }
            }
            objects.push(found.ok_or_else(|| {
                let allowed =
                    format!("no more objects than there is room for; {done} were placed; {}", rejected.text());
                scene.fault(&format!("{field}.count"), group.count, allowed)
            })?);
        }
    }
    Ok(objects)
}

/// How many proposed places were rejected, and why, for the error message.
#[derive(Default)]
struct Rejections {
    no_foam: usize,
    overlap: usize,
    arm: usize,
    /// Places beside the table for what would fall from there.
    beside: usize,
}

impl Rejections {
    fn allows(&mut self, placed: &PlacedObject, objects: &[PlacedObject], arm: &ArmAtStart) -> bool {
        let laid = placed.laid();
        if objects.iter().any(|other| !may_overlap(placed, other) && laid.overlaps(&other.laid())) {
            self.overlap += 1;
            return false;
        }
        if placed.object.is_ground() {
            return true;
        }
        let capsule = placed.bounding_capsule();
        if arm.links.iter().any(|link| link.distance(&capsule) < START_CLEARANCE_M) {
            self.arm += 1;
            return false;
        }
        let mut tables = objects.iter().filter(|other| other.object.is_ground()).peekable();
        // A scene that names no table has one without an edge.
        let is_beside =
            tables.peek().is_some() && !tables.any(|table| table.laid().contains(placed.foot_world.truncate(), 0.0));
        let stands_free =
            || placed.object.structure(0.0).bodies.iter().any(|own| own.collision_group == CollisionGroup::Standing);
        if is_beside && stands_free() {
            self.beside += 1;
            return false;
        }
        true
    }

    fn text(&self) -> String {
        let Rejections { no_foam, overlap, arm, beside } = self;
        format!(
            "of {PLACES} places tried for the next one, {overlap} overlapped another object, {arm} were too close to the arm's \
             start posture, {beside} were beside the table and {no_foam} had no foam to stand in"
        )
    }
}

/// Whether one of two objects is the ground, or foam in which the other may stand. What passes through foam to the table
/// would nail a free block to the ground, so it stands beside such a block.
fn may_overlap(a: &PlacedObject, b: &PlacedObject) -> bool {
    let in_foam = |foam: &PlacedObject, other: &PlacedObject| {
        let may_pass = other.object.passes_through_foam() && foam.object.carrier().is_none();
        foam.object.foam_top().is_some() && (other.stands_on.is_some() || may_pass)
    };
    a.object.is_ground() || b.object.is_ground() || in_foam(a, b) || in_foam(b, a)
}

/// What an object at this place would stand on, and the object whose foam it is, if it needs foam; `None` if there is none.
fn ground(
    needs_foam: bool,
    workspace: &Workspace,
    objects: &[PlacedObject],
    center: DVec2,
) -> Option<(Footing, Option<usize>)> {
    if !needs_foam {
        return Some((Footing { height_m: workspace.table_height_m, foam_modulus_pa: None }, None));
    }
    objects.iter().enumerate().find_map(|(index, block)| {
        let (modulus, height) = block.object.foam_top()?;
        let footing = Footing { height_m: block.foot_world.z + height, foam_modulus_pa: Some(modulus) };
        block.laid().contains(center, BLOCK_MARGIN_M).then_some((footing, Some(index)))
    })
}
