//! Staged reaches to a whole data set: one pass in the order of the plan, one reach in memory.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;

use super::card::card;
use super::checksums::{Checksums, FileSum};
use super::episode_table::{Episode, Place, number_tasks, write_episodes, write_tasks};
use super::info::{FORMAT, Info, MEGABYTES_PER_FILE, ProvenanceFile};
use super::names;
use super::statistics::Statistics;
use super::table_files::TableFiles;
use super::taxel_table::write_taxels;
use super::writer::DatasetWriter;
use crate::disk::DiskError;
use crate::disk::features::{features, schema};
use crate::disk::frames::{Numbering, frame_columns};
use crate::disk::parquet_file::ROWS_PER_BATCH;
use crate::disk::recording_file::read_recording;
use crate::disk::whole_file::{create_folder, json_bytes, write_bytes};

/// Staged bytes at which a new data file begins.
pub(super) const BYTES_PER_FILE: u64 = MEGABYTES_PER_FILE * 1024 * 1024;

/// Writes everything but `incomplete/` from the staged reaches; `meta/info.json` last.
pub(super) fn assemble(set: &DatasetWriter) -> Result<(), DiskError> {
    let (dir, plan) = (set.dir(), set.plan());
    for folder in names::FOLDERS.map(|name| dir.join(name)) {
        // What an earlier, killed attempt left behind.
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(DiskError::io(&folder, "remove"))?;
        }
    }
    create_folder(&dir.join("meta/episodes/chunk-000"))?;
    write_taxels(&dir.join(names::TAXELS), &plan.layout)?;
    let provenance = ProvenanceFile {
        format: FORMAT.to_string(),
        provenance: plan.provenance.clone(),
    };
    write_json(&dir.join(names::PROVENANCE), &provenance)?;
    let tasks = number_tasks(plan.episodes.iter().map(|episode| episode.task.as_str()));
    write_tasks(&dir.join(names::TASKS), &tasks)?;

    let features = features(&plan.joint_names, &plan.layout);
    let mut statistics = Statistics::new(&features);
    let schema = schema(&features);
    let mut files = TableFiles::new(dir, set.bytes_per_file);
    let mut episodes = Vec::with_capacity(plan.episodes.len());
    let mut total_frames = 0;
    for (position, planned) in plan.episodes.iter().enumerate() {
        let path = set.staged(position);
        let staged_bytes = fs::metadata(&path).map_err(DiskError::io(&path, "read"))?.len();
        let recording = read_recording(&path)?;
        let (chunk_index, file_index) = files.begin_episode(staged_bytes)?;
        let numbering = Numbering {
            episode: position,
            first_index: total_frames,
            task: tasks.get(planned.task.as_str()).copied().unwrap_or_default(),
        };
        let frames = recording.frames.len();
        for first in (0..frames).step_by(ROWS_PER_BATCH) {
            let count = ROWS_PER_BATCH.min(frames - first);
            let batch = frame_columns(&recording, first, count, numbering)
                .and_then(|columns| Ok(RecordBatch::try_new(Arc::clone(&schema), columns)?))
                .map_err(DiskError::encode(&path))?;
            statistics.add(&batch);
            files.write_frames(&batch)?;
        }
        files.end_episode(position, &recording)?;
        let place = Place {
            frames,
            first_index: total_frames,
            chunk_index,
            file_index,
        };
        total_frames += frames;
        episodes.push(Episode::new(planned.task.clone(), place, recording));
    }
    files.close()?;
    write_episodes(&dir.join(names::EPISODES), &episodes)?;
    write_json(&dir.join(names::STATS), &statistics.summary())?;
    finish_with_info(dir, &Info::new(plan, total_frames, tasks.len(), &features))
}

/// Hashes everything, then writes the file that makes the set whole.
fn finish_with_info(dir: &Path, info: &Info) -> Result<(), DiskError> {
    let path = dir.join(names::INFO);
    let bytes = json_bytes(&path, info)?;
    let card = card(info);
    write_bytes(&dir.join(names::CARD), card.as_bytes())?;
    let mut checksums = Checksums::default();
    checksums.add(names::CARD, FileSum::of_bytes(card.as_bytes()));
    for folder in names::FOLDERS {
        checksums.add_folder(dir, folder)?;
    }
    checksums.add(names::INFO, FileSum::of_bytes(&bytes));
    checksums.write(dir)?;
    write_bytes(&path, &bytes)
}

fn write_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<(), DiskError> {
    write_bytes(path, &json_bytes(path, value)?)
}
