//! The bodies of a reach: the table `truth/bodies`, with one row per collision shape.

use std::path::Path;

use arrow_array::builder::{Float64Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type};
use arrow_array::{Array, Float64Array, Int32Array, RecordBatch, StringArray};
use glam::DVec3;

use super::row_groups::EpisodeRows;
use super::truth_tables::table;
use crate::disk::DiskError;
use crate::disk::dictionary::TRUTH_BODIES;
use crate::disk::table::Columns;
use crate::{Body, BodyOwner, BodyPart, BodyShape, Pose, Recording};

/// Names of the shapes.
fn shape_name(shape: &BodyShape) -> &'static str {
    match shape {
        BodyShape::Sphere { .. } => "sphere",
        BodyShape::Cylinder { .. } => "cylinder",
        BodyShape::Capsule { .. } => "capsule",
        BodyShape::Box { .. } => "box",
        BodyShape::Hull { .. } => "hull",
    }
}

fn radius_m(shape: &BodyShape) -> Option<f64> {
    match shape {
        BodyShape::Sphere { radius_m } | BodyShape::Cylinder { radius_m, .. } | BodyShape::Capsule { radius_m, .. } => {
            Some(*radius_m)
        }
        _ => None,
    }
}

fn length_m(shape: &BodyShape) -> Option<f64> {
    match shape {
        BodyShape::Cylinder { length_m, .. } | BodyShape::Capsule { length_m, .. } => Some(*length_m),
        _ => None,
    }
}

/// One row: a shape of a body, or a body without shapes.
type Row<'a> = (usize, &'a Body, Option<&'a BodyPart>);

/// The rows of all bodies.
fn rows_of(bodies: &[Body]) -> Vec<Row<'_>> {
    let bodies = bodies.iter().enumerate();
    bodies
        .flat_map(|(index, body)| {
            let parts = body.parts.iter().map(move |part| (index, body, Some(part)));
            let bare = body.parts.is_empty().then_some((index, body, None));
            parts.chain(bare)
        })
        .collect()
}

/// An episode's bodies.
pub(super) fn body_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let rows = rows_of(&recording.bodies);
    let link = |(_, body, _): &Row| match &body.owner {
        BodyOwner::Link(name) => Some(name.clone()),
        BodyOwner::Object(_) => None,
    };
    let object = |(_, body, _): &Row| match body.owner {
        BodyOwner::Link(_) => None,
        BodyOwner::Object(index) => Some(index),
    };
    let category = |row: &Row| {
        let object = recording.objects.get(usize::from(object(row)?))?;
        Some(object.category.name())
    };
    let number = |pick: &dyn Fn(&BodyShape) -> Option<f64>| -> Float64Array {
        rows.iter().map(|(.., part)| pick(&(*part)?.shape)).collect()
    };
    let edge = |axis: usize| {
        number(&move |shape| match shape {
            BodyShape::Box { size_m } => Some(size_m[axis]),
            _ => None,
        })
    };
    let mut points = ListBuilder::new(Float64Builder::new());
    for (.., part) in &rows {
        let hull = part.and_then(|part| match &part.shape {
            BodyShape::Hull { points_m } => Some(points_m),
            _ => None,
        });
        for point in hull.into_iter().flatten() {
            points.values().append_slice(&point.to_array());
        }
        points.append(hull.is_some());
    }
    let at_origin = Pose {
        position: DVec3::ZERO,
        orientation: glam::DQuat::IDENTITY,
    };
    let poses = || {
        rows.iter()
            .map(|(.., part)| part.map_or(at_origin, |part| part.pose_body))
    };
    let rest = || rows.iter().map(|(_, body, _)| body.rest_pose_world);
    table(&TRUTH_BODIES, episode, rows.len())
        .column(
            "body_index",
            Int32Array::from_iter_values(rows.iter().map(|row| row.0 as i32)),
        )
        .column("link", rows.iter().map(link).collect::<StringArray>())
        .column(
            "object_index",
            rows.iter()
                .map(|row| object(row).map(i32::from))
                .collect::<Int32Array>(),
        )
        .column("category", rows.iter().map(category).collect::<StringArray>())
        .column(
            "shape",
            rows.iter()
                .map(|(.., part)| part.map(|part| shape_name(&part.shape)))
                .collect::<StringArray>(),
        )
        .column("size_x_m", edge(0))
        .column("size_y_m", edge(1))
        .column("size_z_m", edge(2))
        .column("radius_m", number(&radius_m))
        .column("length_m", number(&length_m))
        .column("points_m", points.finish())
        .vectors("position_body", "_m", poses().map(|pose| pose.position))
        .quaternions("orientation_body", poses().map(|pose| pose.orientation))
        .vectors("rest_position_world", "_m", rest().map(|pose| pose.position))
        .quaternions("rest_orientation_world", rest().map(|pose| pose.orientation))
        .build(path)
}

/// The columns of a shape, null for numbers that it does not have.
struct ShapeColumns<'a> {
    columns: &'a Columns<'a>,
    shape: &'a StringArray,
    edges: [&'a Float64Array; 3],
    radius: &'a Float64Array,
    length: &'a Float64Array,
}

impl<'a> ShapeColumns<'a> {
    fn new(columns: &'a Columns<'a>) -> Result<Self, DiskError> {
        let numbers = |name: &str| columns.typed::<Float64Array>(name, "Float64");
        Ok(ShapeColumns {
            shape: columns.text_or_null("shape")?,
            edges: [numbers("size_x_m")?, numbers("size_y_m")?, numbers("size_z_m")?],
            radius: numbers("radius_m")?,
            length: numbers("length_m")?,
            columns,
        })
    }

    fn shape(&self, row: usize) -> Result<Option<BodyShape>, DiskError> {
        if self.shape.is_null(row) {
            return Ok(None);
        }
        let number = |name: &str, column: &Float64Array| match column.is_valid(row) {
            true => Ok(column.value(row)),
            false => Err(self
                .columns
                .error(name, "nothing", format!("a number for a {}", self.shape.value(row)))),
        };
        let radius = || number("radius_m", self.radius);
        let length = || number("length_m", self.length);
        Ok(Some(match self.shape.value(row) {
            "sphere" => BodyShape::Sphere { radius_m: radius()? },
            "cylinder" => BodyShape::Cylinder {
                radius_m: radius()?,
                length_m: length()?,
            },
            "capsule" => BodyShape::Capsule {
                radius_m: radius()?,
                length_m: length()?,
            },
            "box" => BodyShape::Box {
                size_m: DVec3::new(
                    number("size_x_m", self.edges[0])?,
                    number("size_y_m", self.edges[1])?,
                    number("size_z_m", self.edges[2])?,
                ),
            },
            "hull" => BodyShape::Hull {
                points_m: self.points(row)?,
            },
            other => {
                return Err(self
                    .columns
                    .error("shape", other, "sphere, cylinder, capsule, box or hull"));
            }
        }))
    }

    fn points(&self, row: usize) -> Result<Vec<DVec3>, DiskError> {
        let error = || self.columns.error("points_m", "no list of points", "a list of x y z");
        let lists = self.columns.batch.column_by_name("points_m");
        let lists = lists
            .and_then(|array| array.as_list_opt::<i32>())
            .filter(|lists| lists.is_valid(row));
        let list = lists.ok_or_else(error)?.value(row);
        let numbers = list
            .as_primitive_opt::<Float64Type>()
            .filter(|numbers| numbers.null_count() == 0);
        let (points, rest) = numbers.ok_or_else(error)?.values().as_chunks::<3>();
        if !rest.is_empty() {
            return Err(error());
        }
        Ok(points.iter().map(|point| DVec3::from_array(*point)).collect())
    }
}

/// Reads the bodies of an episode, without their motion.
pub(super) fn read_bodies(rows: &EpisodeRows) -> Result<Vec<Body>, DiskError> {
    let mut bodies: Vec<Body> = Vec::new();
    for columns in rows.columns() {
        let index = columns.numbers::<Int32Type>("body_index")?;
        let links = columns.text_or_null("link")?;
        let objects = columns.typed::<Int32Array>("object_index", "Int32")?;
        let shapes = ShapeColumns::new(&columns)?;
        let positions = columns.vectors("position_body", "_m")?;
        let orientations = columns.quaternions("orientation_body")?;
        let rest_positions = columns.vectors("rest_position_world", "_m")?;
        let rest_orientations = columns.quaternions("rest_orientation_world")?;
        for row in 0..columns.batch.num_rows() {
            let next = bodies.len();
            let same = next > 0 && usize::try_from(index[row]) == Ok(next - 1);
            if !same && usize::try_from(index[row]) != Ok(next) {
                let allowed = format!("{next}, as bodies are in order");
                return Err(columns.error("body_index", index[row].to_string(), allowed));
            }
            if !same {
                let owner = if links.is_valid(row) {
                    BodyOwner::Link(links.value(row).to_string())
                } else {
                    let object = objects
                        .is_valid(row)
                        .then(|| u16::try_from(objects.value(row)).ok())
                        .flatten();
                    let error = || columns.error("object_index", "no object and no link", "one of them");
                    BodyOwner::Object(object.ok_or_else(error)?)
                };
                bodies.push(Body {
                    owner,
                    parts: Vec::new(),
                    rest_pose_world: Pose {
                        position: rest_positions[row],
                        orientation: rest_orientations[row],
                    },
                    track: Vec::new(),
                });
            }
            if let (Some(shape), Some(body)) = (shapes.shape(row)?, bodies.last_mut()) {
                body.parts.push(BodyPart {
                    shape,
                    pose_body: Pose {
                        position: positions[row],
                        orientation: orientations[row],
                    },
                });
            }
        }
    }
    Ok(bodies)
}
