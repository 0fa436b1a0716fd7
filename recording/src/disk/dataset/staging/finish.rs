//! Assembles staged reaches into a data set, in one pass in the order of the plan. As many reaches are in memory as there
//! are threads, which read and prepare them side by side; the bytes do not depend on their number.
//!
//! When files are complete, their reaches are removed from `incomplete/`. The folder therefore holds the set and the
//! staged reaches of at most one more file, and not the set twice. After a crash, assembling continues after the last
//! complete file (`packed.rs`).

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::Path;

use rayon::prelude::*;

use super::folder::{Staging, require_own_files};
use super::packed::Assembled;
use super::statistics::Statistics;
use super::table_files::{FurtherColumns, TableFiles};
use crate::disk::dataset::checksums::{Checksums, FileSum, files_below, files_of_set};
use crate::disk::dataset::info::{FORMAT, Info, ProvenanceFile, card};
use crate::disk::dataset::names;
use crate::disk::files::{create_folder, json_bytes, remove_if_there, remove_leftovers, write_bytes, write_json};
use crate::disk::recording_file::batches;
use crate::disk::table::{Column, Encoder, Group};
use crate::disk::tables::FURTHER;
use crate::disk::tables::episode::{Episode, write_episodes};
use crate::disk::tables::frames::{FRAME_COLUMNS, Feature, Numbering, ReachRows, columns_of, features};
use crate::disk::tables::shared_tables::{write_tasks, write_taxels};
use crate::{Category, DiskError, Recording, Result};

/// A reach that is ready for the files of the set: only its place in them is missing. Preparing one needs no other, so each
/// thread prepares its own.
struct Prepared {
    /// Its entry, without task, chunk and file.
    episode: Episode,
    /// Size of the staged file.
    staged_bytes: u64,
    /// The columns of frames, without rows.
    columns: Vec<Column>,
    /// The row group with the frames.
    frames: Group,
    /// Statistics of the frames.
    statistics: Statistics,
    /// The other tables.
    further: FurtherColumns,
}

impl Prepared {
    /// Prepares a reach that is staged at a path and gets this place in the set.
    fn new(staged: &Path, recording: &Recording, numbering: Numbering, features: &[Feature]) -> Result<Self> {
        let rows = ReachRows { recording, numbering, moves: Vec::new() };
        let columns = columns_of(features, &rows, 0..0);
        let mut statistics = Statistics::new(features);
        let mut with_statistics = batches(recording.frames.len()).map(|frames| {
            let columns = columns_of(features, &rows, frames);
            statistics.add(&columns);
            columns
        });
        let frames = Encoder::new(staged, &columns)?.encode(staged, &mut with_statistics)?;
        Ok(Prepared {
            episode: Episode { first_index: numbering.first_index, ..Episode::of(recording) },
            staged_bytes: fs::metadata(staged).map_err(DiskError::io(staged, "read"))?.len(),
            columns,
            frames,
            statistics,
            further: FURTHER.map(|(_, columns)| columns(numbering.episode, recording)),
        })
    }
}

/// Writes the whole set, with `meta/info.json` last. `read` returns the reaches at some positions of the plan and has to leave
/// them staged, because the size of a staged file decides where a new data file begins.
pub(crate) fn assemble_from(
    staging: &Staging,
    read: &mut dyn FnMut(Range<usize>) -> Vec<Result<Recording>>,
) -> Result<()> {
    let (dir, plan) = (staging.dir.as_path(), &staging.plan);
    let features = features(FRAME_COLUMNS, &plan.joint_names, &plan.layout);
    let begun = || Assembled { statistics: Statistics::new(&features), ..Assembled::default() };
    let mut assembled = Assembled::read(dir)?.unwrap_or_else(begun);
    // Once more, as simulating the reaches may have taken days.
    require_own_files(dir)?;
    // What an earlier, killed attempt has left, except complete files.
    for name in files_of_set(dir)?.iter().filter(|name| !assembled.checksums.has(name)) {
        remove_if_there(&dir.join(name))?;
    }
    remove_leftovers(&dir.join(names::CARD));
    staging.remove(0..assembled.episodes.len())?;
    create_folder(&dir.join("meta/episodes/chunk-000"))?;
    write_taxels(&dir.join(names::TAXELS), &plan.layout)?;
    let provenance = ProvenanceFile {
        format: FORMAT.to_string(),
        categories: plan.categories.clone(),
        provenance: plan.provenance.clone(),
    };
    write_json(&dir.join(names::PROVENANCE), &provenance)?;
    let mut numbers = BTreeMap::new();
    for episode in &plan.episodes {
        let next = numbers.len();
        numbers.entry(episode.task.as_str()).or_insert(next);
    }
    write_tasks(&dir.join(names::TASKS), &numbers)?;

    let mut files = TableFiles::new(dir, &plan.categories, staging.bytes_per_file, assembled.files);
    let mut still_staged = assembled.episodes.len();
    let (count, threads) = (plan.episodes.len(), rayon::current_num_threads());
    for first in (still_staged..count).step_by(threads) {
        let recordings = read(first..count.min(first + threads));
        let mut first_index = assembled.total_frames;
        let numbered = recordings.into_iter().zip(first..).map(|(recording, episode)| {
            let task = numbers[plan.episodes[episode].task.as_str()] as i64;
            let numbering = Numbering { episode, first_index, task };
            first_index += recording.as_ref().map_or(0, |recording| recording.frames.len());
            (numbering, recording)
        });
        let numbered: Vec<_> = numbered.collect();
        let prepared = numbered.into_par_iter().map(|(numbering, recording)| {
            Prepared::new(&staging.path(numbering.episode), &recording?, numbering, &features)
        });
        for reach in prepared.collect::<Vec<_>>() {
            let Prepared { episode, staged_bytes, columns, frames, statistics, further } = reach?;
            if files.is_full_for(staged_bytes) {
                assembled.files_end(&mut files, dir)?;
                staging.remove(still_staged..assembled.episodes.len())?;
                still_staged = assembled.episodes.len();
            }
            let (chunk_index, file_index) = files.write_episode(staged_bytes, &columns, frames, further)?;
            assembled.statistics.merge(statistics);
            assembled.total_frames += episode.frames;
            let task = plan.episodes[assembled.episodes.len()].task.clone();
            assembled.episodes.push(Episode { task, chunk_index, file_index, ..episode });
        }
    }
    // The progress need not be stored once more: the reaches of these files stay staged until the set is complete.
    assembled.checksums.add_files(dir, files.close()?)?;
    write_episodes(&dir.join(names::EPISODES), &assembled.episodes)?;
    write_json(&dir.join(names::STATS), &assembled.statistics.summary())?;
    let info = Info::new(plan, assembled.total_frames, numbers.len(), &features);
    finish_with_info(dir, &info, &plan.categories, assembled.checksums)
}

/// Hashes all other files, then writes the file that makes the set complete.
fn finish_with_info(dir: &Path, info: &Info, categories: &[Category], mut checksums: Checksums) -> Result<()> {
    let path = dir.join(names::INFO);
    let bytes = json_bytes(&path, info)?;
    let card = card(info, categories);
    write_bytes(&dir.join(names::CARD), card.as_bytes())?;
    checksums.add(names::CARD, FileSum::of_bytes(card.as_bytes()));
    checksums.add_files(dir, files_below(dir, "meta")?)?;
    checksums.add(names::INFO, FileSum::of_bytes(&bytes));
    checksums.write(dir)?;
    write_bytes(&path, &bytes)
}

#[cfg(test)]
mod tests;
