//! The reaches of a data set, each with its place in the files, its outcome and its audit, and their table
//! (`meta/episodes/…`).

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::disk::table::{Batch, Column, ParquetTable, Row, Text, Want, row, write_table};
use crate::disk::tables::truth_tables::{COUNTS, OBJECTS, read_outcome, some_missing};
use crate::{Audit, GoalOutcomes, NamedStop, Outcome, Recording, Result};

/// One reach of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Episode {
    /// The task, as a sentence.
    pub task: String,
    /// Number of frames.
    pub frames: usize,
    /// Index of its first frame in the data set.
    pub first_index: usize,
    /// Chunk (folder) of its data file.
    pub chunk_index: usize,
    /// Number of its data file in the chunk.
    pub file_index: usize,
    /// Name of the scene.
    pub scene: String,
    /// The campaign's seed.
    pub seed: u64,
    /// Index of the reach in its campaign.
    pub reach_index: u64,
    /// Name of the controller.
    pub controller: String,
    /// The outcome of the reach: the worst outcome of its goals.
    pub outcome: Outcome,
    /// The number of goals with each outcome.
    pub goal_outcomes: GoalOutcomes,
    /// The contact that ended the reach, if a force exceeded the controller's stop force.
    pub safety_stop: Option<NamedStop>,
    /// Number of objects in the clutter.
    pub objects: usize,
    /// Number of contacts, with and without skin.
    pub contacts: usize,
    /// Number of frames in which an object truly pressed on each patch, by name; see [`Recording::touched_frames`].
    pub touched_frames: BTreeMap<String, u32>,
    /// Residuals of the physics.
    pub audit: Audit,
}

impl Episode {
    /// What the entry of a recording says apart from its task and its place in the files, which are empty.
    pub fn of(recording: &Recording) -> Self {
        Episode {
            task: String::new(),
            frames: recording.frames.len(),
            first_index: 0,
            chunk_index: 0,
            file_index: 0,
            scene: recording.scene.clone(),
            seed: recording.seed,
            reach_index: recording.reach_index,
            controller: recording.controller.clone(),
            outcome: recording.outcome(),
            goal_outcomes: recording.goal_outcomes(),
            safety_stop: recording.safety_stop(),
            objects: recording.objects.len(),
            contacts: recording.contacts.len(),
            touched_frames: recording.touched_frames(),
            audit: recording.audit,
        }
    }
}

row! {
    /// The columns that do not depend on the skin, without the figures of the audit and the goals.
    EpisodeRow {
        episode_index: i64, "", "index of the reach, from 0";
        tasks: Option<Vec<Text>>, "", "the task, as a list of one sentence";
        length: i64, "", "number of frames";
        chunk_index: i64 = "data/chunk_index", "", "chunk of its files";
        file_index: i64 = "data/file_index", "", "number of its files in the chunk";
        from_index: i64 = "dataset_from_index", "", "index of its first frame in the set";
        to_index: i64 = "dataset_to_index", "", "index after its last frame";
        episodes_chunk_index: i64 = "meta/episodes/chunk_index", "", "chunk of this file";
        episodes_file_index: i64 = "meta/episodes/file_index", "", "number of this file";
        scene: Text, "", "name of the scene";
        seed: u64, "", "seed of the campaign";
        reach_index: u64, "", "index of the reach in its campaign";
        controller: Text, "", "name of the controller";
        outcome: Text, "", "the worst outcome of its goals";
        objects: i64, "", "number of objects";
        contacts: i64, "", "number of contacts";
    }
}

row! {
    /// The contact that ended the reach, if a force exceeded the stop force.
    StopRow {
        object: Option<i32> = "stop_object_index", "", "the object; null for the arm itself";
        kind: Option<Text> = "stop_object_kind", "", "its kind";
        link: Option<Text> = "stop_link", "", "name of the link that it pressed";
        patch: Option<Text> = "stop_patch", "", "name of the patch; null if there is no skin there";
        force_n: Option<f64> = "stop_force_n", "N", "the force";
    }
}

/// The column with the number of goals of an outcome.
fn goals_column(outcome: Outcome) -> String {
    format!("goals_{}", outcome.name())
}

/// Prefix of the columns with the number of frames in contact; the patch's name follows.
const TOUCHED_FRAMES: &str = "touched_frames.";

/// Writes the episodes, in order.
pub(crate) fn write_episodes(path: &Path, episodes: &[Episode]) -> Result<()> {
    let row = |(index, episode): (usize, &Episode)| EpisodeRow {
        episode_index: index as i64,
        tasks: Some(vec![episode.task.as_str().into()]),
        length: episode.frames as i64,
        chunk_index: episode.chunk_index as i64,
        file_index: episode.file_index as i64,
        from_index: episode.first_index as i64,
        to_index: (episode.first_index + episode.frames) as i64,
        episodes_chunk_index: 0,
        episodes_file_index: 0,
        scene: episode.scene.as_str().into(),
        seed: episode.seed,
        reach_index: episode.reach_index,
        controller: episode.controller.as_str().into(),
        outcome: episode.outcome.name().into(),
        objects: episode.objects as i64,
        contacts: episode.contacts as i64,
    };
    let stop = |episode: &Episode| {
        let stop = episode.safety_stop.as_ref();
        StopRow {
            object: stop.and_then(|stop| stop.object_index).map(Into::into),
            kind: stop.map(|stop| stop.object_kind.as_str().into()),
            link: stop.map(|stop| stop.link.as_str().into()),
            patch: stop.and_then(|stop| stop.patch.as_deref()).map(Into::into),
            force_n: stop.map(|stop| stop.force_n),
        }
    };
    let mut columns = EpisodeRow::write(&episodes.iter().enumerate().map(row).collect::<Vec<_>>());
    let audits = || episodes.iter().map(|episode| &episode.audit);
    let counts = Audit::COUNTS.map(|field| (field.name, audits().map(move |audit| i64::from((field.get)(audit)))));
    columns.extend(counts.map(|(name, counts)| Column::of(name, counts)));
    columns.extend(Audit::FIELDS.map(|field| Column::of(field.name, audits().map(field.get))));
    columns.extend(Outcome::ALL.map(|outcome| {
        let goals = episodes.iter().map(|episode| episode.goal_outcomes.of(outcome) as i64);
        Column::of(goals_column(outcome), goals)
    }));
    columns.extend(StopRow::write(&episodes.iter().map(stop).collect::<Vec<_>>()));
    // All episodes of a set have the same skin.
    let patches = episodes.first().map(|episode| episode.touched_frames.keys());
    columns.extend(patches.into_iter().flatten().map(|patch| {
        let frames = |episode: &Episode| episode.touched_frames.get(patch).map_or(0, |frames| i64::from(*frames));
        Column::of(format!("{TOUCHED_FRAMES}{patch}"), episodes.iter().map(frames))
    }));
    write_table(path, columns, Vec::new())
}

/// Reads the episodes, in order.
pub(crate) fn read_episodes(path: &Path) -> Result<Vec<Episode>> {
    let mut episodes = Vec::new();
    for batch in ParquetTable::open(path)?.batches(&|_| Want::All) {
        read_batch(&batch?, &mut episodes)?;
    }
    Ok(episodes)
}

/// The contact that ended a reach.
fn read_stop(batch: &Batch, row: StopRow) -> Result<Option<NamedStop>> {
    match (row.object, row.kind, row.link, row.force_n) {
        (object, Some(kind), Some(link), Some(force_n)) => Ok(Some(NamedStop {
            object_index: object.map(|object| batch.index("stop_object_index", object, OBJECTS)).transpose()?,
            object_kind: kind.to_string(),
            link: link.to_string(),
            patch: row.patch.map(|patch| patch.to_string()),
            force_n,
        })),
        (None, None, None, None) if row.patch.is_none() => Ok(None),
        _ => Err(some_missing(batch)),
    }
}

fn read_batch(batch: &Batch, episodes: &mut Vec<Episode>) -> Result<()> {
    // Within 32 bits, so that their sum cannot overflow.
    let whole = |name: &str, number: i64| batch.index::<u32>(name, number, COUNTS);
    let count = |name: &str, number: i64| whole(name, number).map(|number| number as usize);
    let counts = |name: &str| batch.fixed::<i64>(name, 1);
    let patches: Vec<_> = batch.columns.iter().filter_map(|column| column.name.strip_prefix(TOUCHED_FRAMES)).collect();
    let stops = batch.rows_as::<StopRow>()?;
    for (place, (row, stop)) in batch.rows_as::<EpisodeRow>()?.into_iter().zip(stops).enumerate() {
        let frames = count("length", row.length)?;
        let expected = episodes.last().map_or(0, |episode| episode.first_index + episode.frames);
        if usize::try_from(row.episode_index) != Ok(episodes.len()) || usize::try_from(row.from_index) != Ok(expected) {
            let found = format!("episode {} from frame {}", row.episode_index, row.from_index);
            let allowed = format!("episode {} from frame {expected}", episodes.len());
            return Err(batch.error("dataset_from_index", found, allowed));
        }
        let Some([task]) = row.tasks.as_deref() else {
            return Err(batch.error("tasks", "no list of one text", "a list of one text a row"));
        };
        let mut audit = Audit::default();
        for field in &Audit::COUNTS {
            (field.set)(&mut audit, whole(field.name, counts(field.name)?[place])?);
        }
        // Sets of earlier versions have fewer figures. Like all that was not audited, the others are 0.
        for field in Audit::FIELDS.iter().filter(|field| batch.has(field.name)) {
            (field.set)(&mut audit, batch.fixed(field.name, 1)?[place]);
        }
        let mut goal_outcomes = GoalOutcomes::default();
        for outcome in Outcome::ALL {
            let name = goals_column(outcome);
            *goal_outcomes.of_mut(outcome) = count(&name, counts(&name)?[place])?;
        }
        let touched = patches.iter().map(|patch| {
            let name = format!("{TOUCHED_FRAMES}{patch}");
            Ok(((*patch).to_owned(), whole(&name, counts(&name)?[place])?))
        });
        episodes.push(Episode {
            task: task.to_string(),
            frames,
            first_index: expected,
            chunk_index: count("data/chunk_index", row.chunk_index)?,
            file_index: count("data/file_index", row.file_index)?,
            scene: row.scene.to_string(),
            seed: row.seed,
            reach_index: row.reach_index,
            controller: row.controller.to_string(),
            outcome: read_outcome(batch, &row.outcome)?,
            goal_outcomes,
            safety_stop: read_stop(batch, stop)?,
            objects: count("objects", row.objects)?,
            contacts: count("contacts", row.contacts)?,
            touched_frames: touched.collect::<Result<_>>()?,
            audit,
        });
    }
    Ok(())
}
