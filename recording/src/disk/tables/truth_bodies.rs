//! The bodies of a reach: the table `truth/bodies`, with one row per collision shape.

use glam::DVec3;

use crate::disk::table::{Batch, EpisodeRows};
use crate::disk::tables::dictionary::TruthBody;
use crate::{Body, BodyOwner, BodyPart, BodyShape, Pose, Recording, Result};

/// A row of a body without shapes.
fn bare_row(index: usize, body: &Body, recording: &Recording) -> TruthBody {
    let (link, object) = match &body.owner {
        BodyOwner::Link(name) => (Some(name.as_str()), None),
        BodyOwner::Object(index) => (None, Some(*index)),
    };
    let known = object.and_then(|index| recording.objects.get(usize::from(index)));
    TruthBody {
        body_index: index as i32,
        link: link.map(Into::into),
        object_index: object.map(Into::into),
        category: known.map(|object| object.category.name().into()),
        rest_position_world: body.rest_pose_world.position,
        rest_orientation_world: body.rest_pose_world.orientation,
        ..TruthBody::default()
    }
}

/// The row of a shape of a body.
fn with_part(row: TruthBody, part: &BodyPart) -> TruthBody {
    let row = TruthBody { position_body: part.pose_body.position, orientation_body: part.pose_body.orientation, ..row };
    let (shape, row) = match &part.shape {
        BodyShape::Sphere { radius_m } => ("sphere", TruthBody { radius_m: Some(*radius_m), ..row }),
        BodyShape::Cylinder { radius_m, length_m } => ("cylinder", round(row, *radius_m, *length_m)),
        BodyShape::Capsule { radius_m, length_m } => ("capsule", round(row, *radius_m, *length_m)),
        BodyShape::Box { size_m } => ("box", TruthBody { size: Some(*size_m), ..row }),
        BodyShape::Hull { points_m } => {
            let points_m = points_m.iter().flat_map(DVec3::to_array).collect();
            ("hull", TruthBody { points_m: Some(points_m), ..row })
        }
    };
    TruthBody { shape: Some(shape.into()), ..row }
}

fn round(row: TruthBody, radius_m: f64, length_m: f64) -> TruthBody {
    TruthBody { radius_m: Some(radius_m), length_m: Some(length_m), ..row }
}

/// An episode's bodies.
pub(crate) fn body_rows(recording: &Recording) -> Vec<TruthBody> {
    let mut rows = Vec::new();
    for (index, body) in recording.bodies.iter().enumerate() {
        let bare = bare_row(index, body, recording);
        rows.extend(body.parts.iter().map(|part| with_part(bare.clone(), part)));
        if body.parts.is_empty() {
            rows.push(bare);
        }
    }
    rows
}

/// The shape of a row, if it has one.
fn shape_of(batch: &Batch, row: &TruthBody) -> Result<Option<BodyShape>> {
    let Some(shape) = row.shape.as_deref() else { return Ok(None) };
    let missing = |name: &str| batch.error(name, "nothing", format!("a number for a {shape}"));
    let radius_m = || row.radius_m.ok_or_else(|| missing("radius_m"));
    let length_m = || row.length_m.ok_or_else(|| missing("length_m"));
    Ok(Some(match shape {
        "sphere" => BodyShape::Sphere { radius_m: radius_m()? },
        "cylinder" => BodyShape::Cylinder { radius_m: radius_m()?, length_m: length_m()? },
        "capsule" => BodyShape::Capsule { radius_m: radius_m()?, length_m: length_m()? },
        "box" => BodyShape::Box { size_m: row.size.ok_or_else(|| missing("size_x_m"))? },
        "hull" => match row.points_m.as_deref().map(<[f64]>::as_chunks) {
            Some((points, [])) => {
                BodyShape::Hull { points_m: points.iter().map(|point| DVec3::from_array(*point)).collect() }
            }
            _ => return Err(batch.error("points_m", "no list of points", "a list of x y z")),
        },
        other => return Err(batch.error("shape", other, "sphere, cylinder, capsule, box or hull")),
    }))
}

/// Reads the bodies of an episode, without their motion.
pub(crate) fn read_bodies(rows: &EpisodeRows) -> Result<Vec<Body>> {
    let mut bodies: Vec<Body> = Vec::new();
    for (batch, row) in rows.rows::<TruthBody>()? {
        let next = bodies.len();
        let index = usize::try_from(row.body_index).ok();
        if index == Some(next) {
            let owner = match (&row.link, row.object_index.map(u16::try_from)) {
                (Some(link), _) => BodyOwner::Link(link.to_string()),
                (None, Some(Ok(object))) => BodyOwner::Object(object),
                _ => return Err(batch.error("object_index", "no object and no link", "one of them")),
            };
            bodies.push(Body {
                owner,
                parts: Vec::new(),
                rest_pose_world: Pose::new(row.rest_position_world, row.rest_orientation_world),
                track: Vec::new(),
            });
        } else if next == 0 || index != Some(next - 1) {
            let allowed = format!("{next}, as bodies are in order");
            return Err(batch.error("body_index", row.body_index.to_string(), allowed));
        }
        if let (Some(shape), Some(body)) = (shape_of(batch, &row)?, bodies.last_mut()) {
            body.parts.push(BodyPart { shape, pose_body: Pose::new(row.position_body, row.orientation_body) });
        }
    }
    Ok(bodies)
}
