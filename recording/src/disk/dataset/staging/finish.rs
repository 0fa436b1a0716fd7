//! Assembles staged reaches into a data set, in one pass in the order of the plan, with one reach in memory.
//!
//! When files are complete, their reaches are removed from `incomplete/`. The folder therefore holds the set and the
//! staged reaches of at most one more file, and not the set twice. After a crash, assembling continues after the last
//! complete file (`assembled.rs`).

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::assembled::Assembled;
use super::card::card;
use super::staged::Staging;
use super::statistics::Statistics;
use super::table_files::TableFiles;
use crate::disk::dataset::checksums::{FileSum, files_of_set};
use crate::disk::dataset::info::{FORMAT, Info, ProvenanceFile};
use crate::disk::dataset::names;
use crate::disk::recording_file::batches;
use crate::disk::tables::episode::Episode;
use crate::disk::tables::episode_table::write_episodes;
use crate::disk::tables::frames::{FRAME_COLUMNS, Numbering, ReachRows, columns_of, features};
use crate::disk::tables::tasks::{number_tasks, write_tasks};
use crate::disk::tables::taxel_table::write_taxels;
use crate::disk::whole_file::{create_folder, json_bytes, remove_if_there, remove_leftovers, write_bytes};
use crate::{Category, DiskError, Recording};

/// Writes the whole set, with `meta/info.json` last. `reach` returns the reach at a position of the plan and has to leave
/// it staged, because the size of the staged file decides where a new data file begins.
pub(in crate::disk) fn assemble_from(
    staging: &Staging,
    reach: &mut dyn FnMut(usize) -> Result<Recording, DiskError>,
) -> Result<(), DiskError> {
    let (dir, plan) = (staging.dir.as_path(), &staging.plan);
    let features = features(FRAME_COLUMNS, &plan.joint_names, &plan.layout);
    let begun = || Assembled { statistics: Statistics::new(&features), ..Assembled::default() };
    let mut assembled = Assembled::read(dir)?.unwrap_or_else(begun);
    remove_all_but(dir, assembled.checksums.names().collect())?;
    remove_leftovers(&dir.join(names::CARD));
    for position in 0..assembled.episodes.len() {
        remove_if_there(&staging.path(position))?;
    }
    create_folder(&dir.join("meta/episodes/chunk-000"))?;
    write_taxels(&dir.join(names::TAXELS), &plan.layout)?;
    let provenance = ProvenanceFile {
        format: FORMAT.to_string(),
        categories: plan.categories.clone(),
        provenance: plan.provenance.clone(),
    };
    write_json(&dir.join(names::PROVENANCE), &provenance)?;
    let tasks = number_tasks(plan.episodes.iter().map(|episode| episode.task.as_str()));
    write_tasks(&dir.join(names::TASKS), &tasks)?;

    let mut files = TableFiles::new(dir, &plan.categories, staging.bytes_per_file, assembled.files);
    let mut still_staged = assembled.episodes.len();
    for (position, planned) in plan.episodes.iter().enumerate().skip(still_staged) {
        let path = staging.path(position);
        let recording = reach(position)?;
        let staged_bytes = fs::metadata(&path).map_err(DiskError::io(&path, "read"))?.len();
        if files.is_full_for(staged_bytes) {
            assembled.files_end(&mut files, dir)?;
            for position in still_staged..assembled.episodes.len() {
                remove_if_there(&staging.path(position))?;
            }
            still_staged = assembled.episodes.len();
        }
        let (chunk_index, file_index) = files.begin_episode(staged_bytes);
        let rows = ReachRows {
            recording: &recording,
            numbering: Numbering {
                episode: position,
                first_index: assembled.total_frames,
                task: tasks.get(planned.task.as_str()).copied().unwrap_or_default(),
            },
            moves: Vec::new(),
        };
        let frames = recording.frames.len();
        let statistics = &mut assembled.statistics;
        let mut columns = batches(frames).map(|frames| {
            let columns = columns_of(&features, &rows, frames);
            statistics.add(&columns);
            Ok(columns)
        });
        files.write_frames(&columns_of(&features, &rows, 0..0), &mut columns)?;
        files.end_episode(position, &recording)?;
        let (task, first_index) = (planned.task.clone(), assembled.total_frames);
        assembled.total_frames += frames;
        assembled.episodes.push(Episode { task, first_index, chunk_index, file_index, ..Episode::of(&recording) });
    }
    assembled.files_end(&mut files, dir)?;
    write_episodes(&dir.join(names::EPISODES), &assembled.episodes)?;
    write_json(&dir.join(names::STATS), &assembled.statistics.summary())?;
    let info = Info::new(plan, assembled.total_frames, tasks.len(), &features);
    finish_with_info(dir, &info, &plan.categories, assembled)
}

/// Removes what an earlier, killed attempt has left, except complete files.
fn remove_all_but(dir: &Path, whole: BTreeSet<&str>) -> Result<(), DiskError> {
    let names = files_of_set(dir)?.into_iter().filter(|name| !whole.contains(name.as_str()));
    names.into_iter().try_for_each(|name| remove_if_there(&dir.join(name)))
}

/// Hashes all other files, then writes the file that makes the set complete.
fn finish_with_info(dir: &Path, info: &Info, categories: &[Category], assembled: Assembled) -> Result<(), DiskError> {
    let path = dir.join(names::INFO);
    let bytes = json_bytes(&path, info)?;
    let card = card(info, categories);
    write_bytes(&dir.join(names::CARD), card.as_bytes())?;
    let mut checksums = assembled.checksums;
    checksums.add(names::CARD, FileSum::of_bytes(card.as_bytes()));
    checksums.add_folder(dir, "meta")?;
    checksums.add(names::INFO, FileSum::of_bytes(&bytes));
    checksums.write(dir)?;
    write_bytes(&path, &bytes)
}

fn write_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<(), DiskError> {
    write_bytes(path, &json_bytes(path, value)?)
}

#[cfg(test)]
mod tests;
