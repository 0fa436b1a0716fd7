//! Ground truth per reach: the tables `truth/objects`, `truth/goals` and `truth/contacts`.

use std::path::Path;

use arrow_array::types::{Float64Type, Int32Type, Int64Type};
use arrow_array::{Array, Float64Array, Int32Array, Int64Array, RecordBatch, StringArray};

use super::row_groups::EpisodeRows;
use super::stop_columns::{self, Stop, object_index};
use crate::disk::DiskError;
use crate::disk::dictionary::{TRUTH_CONTACTS, TRUTH_GOALS, TRUTH_OBJECTS, Table};
use crate::disk::table::{Columns, TableBuilder};
use crate::{Category, Contact, GoalRecord, ObjectRecord, Outcome, Recording, SafetyStop, SkinLayout};

/// Starts a table with the column of the episode.
pub(super) fn table(described: &'static Table, episode: usize, rows: usize) -> TableBuilder {
    TableBuilder::new(described).column("episode_index", Int64Array::from_value(episode as i64, rows))
}

fn numbering(rows: usize) -> Int32Array {
    (0..rows).map(|row| row as i32).collect::<Vec<_>>().into()
}

fn text<'a>(values: impl Iterator<Item = &'a str>) -> StringArray {
    StringArray::from_iter_values(values)
}

fn numbers(values: impl Iterator<Item = f64>) -> Float64Array {
    Float64Array::from_iter_values(values)
}

/// An episode's objects, with their parameters as JSON objects.
pub(super) fn object_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let objects = &recording.objects;
    let parameters = objects.iter().map(|object| serde_json::to_string(&object.parameters));
    let parameters = parameters
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| DiskError::io(path, "write")(error.into()))?;
    table(&TRUTH_OBJECTS, episode, objects.len())
        .column("object_index", numbering(objects.len()))
        .column("kind", text(objects.iter().map(|object| object.kind.as_str())))
        .column("category", text(objects.iter().map(|object| object.category.name())))
        .vectors(
            "position_world",
            "_m",
            objects.iter().map(|object| object.position_world),
        )
        .column("parameters", StringArray::from(parameters))
        .build(path)
}

/// The objects of an episode of a set with `further` categories.
pub(super) fn read_objects(rows: &EpisodeRows, further: &[Category]) -> Result<Vec<ObjectRecord>, DiskError> {
    let all = || Category::BUILT_IN.iter().chain(further);
    let known = |name: &str| all().find(|category| category.name() == name).copied();
    let mut objects = Vec::new();
    for columns in rows.columns() {
        let (kind, category) = (columns.text("kind")?, columns.text("category")?);
        let parameters = columns.text("parameters")?;
        for (row, position_world) in columns.vectors("position_world", "_m")?.into_iter().enumerate() {
            objects.push(ObjectRecord {
                kind: kind.value(row).to_string(),
                category: known(category.value(row)).ok_or_else(|| {
                    let names: Vec<_> = all().map(|category| category.name()).collect();
                    columns.error("category", category.value(row), names.join(", "))
                })?,
                position_world,
                parameters: serde_json::from_str(parameters.value(row))
                    .map_err(|error| columns.error("parameters", error.to_string(), "a JSON object of numbers"))?,
            });
        }
    }
    Ok(objects)
}

/// An episode's goals.
pub(super) fn goal_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let Recording { goals, layout, .. } = recording;
    let stops = goals.iter().map(|goal| {
        let stop = goal.safety_stop.as_ref()?;
        Some(Stop {
            object: stop.object,
            link: &stop.link,
            patch: patch_name(layout, stop.patch),
            force_n: stop.force_n,
        })
    });
    let table = table(&TRUTH_GOALS, episode, goals.len())
        .column("goal_index", numbering(goals.len()))
        .vectors("position_world", "_m", goals.iter().map(|goal| goal.position_world))
        .column("start_time_s", numbers(goals.iter().map(|goal| goal.start_time_s)))
        .column("end_time_s", numbers(goals.iter().map(|goal| goal.end_time_s)))
        .column("outcome", text(goals.iter().map(|goal| goal.outcome.name())));
    stop_columns::write(table, stops, None).build(path)
}

/// Reads the goals of an episode.
pub(super) fn read_goals(rows: &EpisodeRows, layout: &SkinLayout) -> Result<Vec<GoalRecord>, DiskError> {
    let mut goals = Vec::new();
    for columns in rows.columns() {
        let start = columns.numbers::<Float64Type>("start_time_s")?;
        let end = columns.numbers::<Float64Type>("end_time_s")?;
        let outcome = columns.text("outcome")?;
        let stops = stop_columns::read(&columns)?;
        for (row, position_world) in columns.vectors("position_world", "_m")?.into_iter().enumerate() {
            goals.push(GoalRecord {
                position_world,
                start_time_s: start[row],
                end_time_s: end[row],
                outcome: read_outcome(&columns, outcome, row)?,
                safety_stop: stops[row].map(|stop| safety_stop(&columns, layout, stop)).transpose()?,
            });
        }
    }
    Ok(goals)
}

/// The contact that ended a goal, with the patch as an index.
fn safety_stop(columns: &Columns, layout: &SkinLayout, stop: Stop) -> Result<SafetyStop, DiskError> {
    Ok(SafetyStop {
        object: stop.object,
        link: stop.link.to_owned(),
        patch: patch_index(columns, stop_columns::PATCH, stop.patch, layout)?,
        force_n: stop.force_n,
    })
}

/// The name of a patch; null for a part of the arm without skin.
fn patch_name(layout: &SkinLayout, patch: Option<u16>) -> Option<&str> {
    let patch = layout.patches.get(usize::from(patch?))?;
    Some(&patch.name)
}

/// The index of a patch; `None` for a part of the arm without skin.
fn patch_index(
    columns: &Columns,
    column: &str,
    name: Option<&str>,
    layout: &SkinLayout,
) -> Result<Option<u16>, DiskError> {
    let Some(name) = name else { return Ok(None) };
    let index = layout.patch_index(name).and_then(|index| u16::try_from(index).ok());
    match index {
        Some(index) => Ok(Some(index)),
        None => Err(columns.error(column, name, "a patch of meta/taxels.parquet")),
    }
}

/// The outcome of a row.
pub(super) fn read_outcome(columns: &Columns, outcome: &StringArray, row: usize) -> Result<Outcome, DiskError> {
    let name = outcome.value(row);
    Outcome::from_name(name).ok_or_else(|| columns.error("outcome", name, "reached, stuck, timed_out or aborted"))
}

/// An episode's contacts. The patch is null for a part of the link without skin.
pub(super) fn contact_rows(path: &Path, episode: usize, recording: &Recording) -> Result<RecordBatch, DiskError> {
    let Recording {
        contacts,
        objects,
        layout,
        ..
    } = recording;
    let category = |contact: &Contact| {
        let object = objects.get(usize::from(contact.object));
        object.map(|object| object.category.name())
    };
    let frames = |frame: fn(&Contact) -> u32| Int64Array::from_iter_values(contacts.iter().map(frame).map(i64::from));
    table(&TRUTH_CONTACTS, episode, contacts.len())
        .column("link", text(contacts.iter().map(|contact| contact.link.as_str())))
        .column(
            "patch",
            contacts
                .iter()
                .map(|contact| patch_name(layout, contact.patch))
                .collect::<StringArray>(),
        )
        .column(
            "object_index",
            Int32Array::from_iter_values(contacts.iter().map(|contact| contact.object.into())),
        )
        .column("category", contacts.iter().map(category).collect::<StringArray>())
        .column("first_frame", frames(|contact| contact.first_frame))
        .column("last_frame", frames(|contact| contact.last_frame))
        .column(
            "peak_force_n",
            numbers(contacts.iter().map(|contact| contact.peak_force_n)),
        )
        .column(
            "mean_force_n",
            numbers(contacts.iter().map(|contact| contact.mean_force_n)),
        )
        .build(path)
}

/// Reads the contacts of an episode.
pub(super) fn read_contacts(rows: &EpisodeRows, layout: &SkinLayout) -> Result<Vec<Contact>, DiskError> {
    let mut contacts = Vec::new();
    for columns in rows.columns() {
        let link = columns.text("link")?;
        let patch = columns.text_or_null("patch")?;
        let object = columns.numbers::<Int32Type>("object_index")?;
        let frames = [
            columns.numbers::<Int64Type>("first_frame")?,
            columns.numbers::<Int64Type>("last_frame")?,
        ];
        let peak = columns.numbers::<Float64Type>("peak_force_n")?;
        let mean = columns.numbers::<Float64Type>("mean_force_n")?;
        for row in 0..columns.batch.num_rows() {
            let whole = |name: &str, number: i64| {
                u32::try_from(number).map_err(|_| columns.error(name, number.to_string(), "0 to 4294967295"))
            };
            contacts.push(Contact {
                link: link.value(row).to_string(),
                patch: patch_index(&columns, "patch", patch.is_valid(row).then(|| patch.value(row)), layout)?,
                object: object_index(&columns, "object_index", object[row])?,
                first_frame: whole("first_frame", frames[0][row])?,
                last_frame: whole("last_frame", frames[1][row])?,
                peak_force_n: peak[row],
                mean_force_n: mean[row],
            });
        }
    }
    Ok(contacts)
}
