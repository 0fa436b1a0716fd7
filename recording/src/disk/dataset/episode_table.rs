//! The table of episodes of a data set (`meta/episodes/…`).

use std::path::Path;
use std::sync::Arc;

use arrow_array::builder::{ListBuilder, StringBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt64Type};
use arrow_array::{Array, Float64Array, Int64Array, StringArray, UInt64Array};
use parquet::arrow::arrow_reader::ArrowReaderOptions;

use super::episode::Episode;
use super::stop_columns::{self, Stop};
use super::truth_tables::read_outcome;
use crate::disk::DiskError;
use crate::disk::parquet_file::{Batches, open, write_table};
use crate::disk::table::{Columns, TableBuilder};
use crate::{Audit, AuditField, GoalOutcomes, NamedStop, Outcome};

/// The column with the number of goals of an outcome.
fn goals_column(outcome: Outcome) -> String {
    format!("goals_{}", outcome.name())
}

/// Prefix of the columns with the number of frames in contact; the patch's name follows.
const TOUCHED_FRAMES: &str = "touched_frames.";

/// Writes the episodes, in order.
pub(super) fn write_episodes(path: &Path, episodes: &[Episode]) -> Result<(), DiskError> {
    let count = |pick: fn(&Episode) -> usize| Int64Array::from_iter_values(episodes.iter().map(|e| pick(e) as i64));
    let text = |pick: fn(&Episode) -> &str| StringArray::from_iter_values(episodes.iter().map(pick));
    let wide = |pick: fn(&Episode) -> u64| UInt64Array::from_iter_values(episodes.iter().map(pick));
    let zeros = || Int64Array::from_value(0, episodes.len());
    let mut tasks = ListBuilder::new(StringBuilder::new());
    for episode in episodes {
        tasks.append_value([Some(&episode.task)]);
    }
    let table = TableBuilder::undescribed()
        .column("episode_index", Int64Array::from_iter_values(0..episodes.len() as i64))
        .column("tasks", tasks.finish())
        .column("length", count(|episode| episode.frames))
        .column("data/chunk_index", count(|episode| episode.chunk_index))
        .column("data/file_index", count(|episode| episode.file_index))
        .column("dataset_from_index", count(|episode| episode.first_index))
        .column(
            "dataset_to_index",
            count(|episode| episode.first_index + episode.frames),
        )
        .column("meta/episodes/chunk_index", zeros())
        .column("meta/episodes/file_index", zeros())
        .column("scene", text(|episode| &episode.scene))
        .column("seed", wide(|episode| episode.seed))
        .column("reach_index", wide(|episode| episode.reach_index))
        .column("controller", text(|episode| &episode.controller))
        .column("outcome", text(|episode| episode.outcome.name()))
        .column("objects", count(|episode| episode.objects))
        .column("contacts", count(|episode| episode.contacts));
    let figure =
        |field: &AuditField| Float64Array::from_iter_values(episodes.iter().map(|episode| (field.get)(&episode.audit)));
    let table = Audit::COUNTS.iter().fold(table, |table, field| {
        let counts = episodes.iter().map(|episode| i64::from((field.get)(&episode.audit)));
        table.column(field.name, Int64Array::from_iter_values(counts))
    });
    let figures = Audit::FIELDS.iter();
    let table = figures.fold(table, |table, field| table.column(field.name, figure(field)));
    let table = Outcome::ALL.into_iter().fold(table, |table, outcome| {
        let goals = episodes.iter().map(|episode| episode.goal_outcomes.of(outcome) as i64);
        table.column(goals_column(outcome), Int64Array::from_iter_values(goals))
    });
    let table = with_stops(table, episodes);
    // All episodes of a set have the same skin.
    let patches = episodes.first().map(|episode| episode.touched_frames.keys());
    let table = patches.into_iter().flatten().fold(table, |table, patch| {
        let frames = episodes.iter().map(|episode| {
            let frames = episode.touched_frames.get(patch);
            frames.map_or(0, |frames| i64::from(*frames))
        });
        table.column(format!("{TOUCHED_FRAMES}{patch}"), Int64Array::from_iter_values(frames))
    });
    write_table(path, &table.build(path)?, [])
}

/// Adds the columns of the contact that ended each reach.
fn with_stops(table: TableBuilder, episodes: &[Episode]) -> TableBuilder {
    let stops = episodes.iter().map(|episode| episode.safety_stop.as_ref());
    let kinds = stops.clone().map(|stop| stop.map(|stop| stop.object_kind.as_str()));
    let kinds = kinds.collect();
    let stops = stops.map(|stop| {
        let stop = stop?;
        Some(Stop {
            object: stop.object_index,
            link: &stop.link,
            patch: stop.patch.as_deref(),
            force_n: stop.force_n,
        })
    });
    stop_columns::write(table, stops, Some(kinds))
}

/// Reads the contact that ended each reach.
fn read_stops(columns: &Columns) -> Result<Vec<Option<NamedStop>>, DiskError> {
    let stops = stop_columns::read(columns)?;
    let kinds = stop_columns::read_kinds(columns, &stops)?;
    let named = stops.into_iter().zip(kinds).map(|(stop, kind)| {
        let (stop, kind) = stop.zip(kind)?;
        Some(NamedStop {
            object_index: stop.object,
            object_kind: kind.to_owned(),
            link: stop.link.to_owned(),
            patch: stop.patch.map(str::to_owned),
            force_n: stop.force_n,
        })
    });
    Ok(named.collect())
}

/// Reads the episodes, in order.
pub(super) fn read_episodes(path: &Path) -> Result<Vec<Episode>, DiskError> {
    let mut episodes = Vec::new();
    let (file, builder) = open(path, ArrowReaderOptions::default())?;
    for batch in Batches::new(file, builder)? {
        read_batch(&Columns { path, batch: &batch? }, &mut episodes)?;
    }
    Ok(episodes)
}

fn read_batch(columns: &Columns, episodes: &mut Vec<Episode>) -> Result<(), DiskError> {
    let count = |name: &str| -> Result<Vec<usize>, DiskError> {
        let numbers = columns.numbers::<Int64Type>(name)?.iter();
        let number = |&n: &i64| {
            // Within 32 bits, so that their sum cannot overflow.
            let number = u32::try_from(n).ok().and_then(|n| usize::try_from(n).ok());
            number.ok_or_else(|| columns.error(name, n.to_string(), "0 to 4294967295"))
        };
        numbers.map(number).collect()
    };
    let tasks = first_tasks(columns)?;
    let (index, frames, first_index) = (count("episode_index")?, count("length")?, count("dataset_from_index")?);
    let (chunk_index, file_index) = (count("data/chunk_index")?, count("data/file_index")?);
    let goals = Outcome::ALL
        .into_iter()
        .map(|outcome| Ok((outcome, count(&goals_column(outcome))?)))
        .collect::<Result<Vec<_>, DiskError>>()?;
    let stops = read_stops(columns)?;
    let schema = columns.batch.schema();
    let touched = schema.fields().iter().filter_map(|field| {
        let patch = field.name().strip_prefix(TOUCHED_FRAMES)?;
        Some(count(field.name()).map(|frames| (patch.to_string(), frames)))
    });
    let touched = touched.collect::<Result<Vec<_>, DiskError>>()?;
    let (objects, contacts) = (count("objects")?, count("contacts")?);
    let (scene, controller, outcome) = (
        columns.text("scene")?,
        columns.text("controller")?,
        columns.text("outcome")?,
    );
    let seed = columns.numbers::<UInt64Type>("seed")?;
    let reach_index = columns.numbers::<UInt64Type>("reach_index")?;
    let audit_counts = Audit::COUNTS
        .iter()
        .map(|field| Ok((field.set, count(field.name)?)))
        .collect::<Result<Vec<_>, DiskError>>()?;
    let figures = Audit::FIELDS
        .iter()
        // Sets of earlier versions have fewer figures. Like all that was not audited, the others are 0.
        .filter(|field| columns.has(field.name))
        .map(|field| Ok((field.set, columns.numbers::<Float64Type>(field.name)?)))
        .collect::<Result<Vec<_>, DiskError>>()?;
    for (row, (task, safety_stop)) in tasks.into_iter().zip(stops).enumerate() {
        let expected = episodes
            .last()
            .map_or(0, |episode| episode.first_index + episode.frames);
        if index[row] != episodes.len() || first_index[row] != expected {
            let found = format!("episode {} from frame {}", index[row], first_index[row]);
            let allowed = format!("episode {} from frame {expected}", episodes.len());
            return Err(columns.error("dataset_from_index", found, allowed));
        }
        let mut audit = Audit::default();
        for (set, counts) in &audit_counts {
            // Counts are within 32 bits.
            set(&mut audit, counts[row] as u32);
        }
        for (set, figure) in &figures {
            set(&mut audit, figure[row]);
        }
        let mut goal_outcomes = GoalOutcomes::default();
        for (outcome, count) in &goals {
            *goal_outcomes.of_mut(*outcome) = count[row];
        }
        episodes.push(Episode {
            task,
            frames: frames[row],
            first_index: first_index[row],
            chunk_index: chunk_index[row],
            file_index: file_index[row],
            scene: scene.value(row).to_string(),
            seed: seed[row],
            reach_index: reach_index[row],
            controller: controller.value(row).to_string(),
            outcome: read_outcome(columns, outcome, row)?,
            goal_outcomes,
            safety_stop,
            objects: objects[row],
            contacts: contacts[row],
            // Counts are within 32 bits.
            touched_frames: touched
                .iter()
                .map(|(patch, frames)| (patch.clone(), frames[row] as u32))
                .collect(),
            audit,
        });
    }
    Ok(())
}

fn first_tasks(columns: &Columns) -> Result<Vec<String>, DiskError> {
    let error = || columns.error("tasks", "no list of one text", "a list of one text a row");
    let lists = columns
        .batch
        .column_by_name("tasks")
        .and_then(|array| array.as_list_opt::<i32>())
        .ok_or_else(error)?;
    let task = |list: Option<Arc<dyn Array>>| {
        let list = list?;
        let texts = list.as_string_opt::<i32>()?;
        (texts.len() == 1 && texts.is_valid(0)).then(|| texts.value(0).to_string())
    };
    lists.iter().map(|list| task(list).ok_or_else(error)).collect()
}
