//! Staged reaches to a whole data set: one pass in the order of the plan, one batch of frames in memory.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Int64Array, RecordBatch};
use arrow_schema::{ArrowError, FieldRef, SchemaRef};

use super::checksums::{Checksums, FileSum};
use super::episode_table::{Episode, Place, number_tasks, write_episodes, write_tasks};
use super::info::{FILES_PER_CHUNK, FORMAT, Info, MEGABYTES_PER_FILE, ProvenanceFile};
use super::names;
use super::statistics::Statistics;
use super::taxel_table::write_taxels;
use super::truth_tables::{contact_rows, goal_rows, object_rows};
use super::writer::DatasetWriter;
use crate::disk::DiskError;
use crate::disk::features::{features, schema};
use crate::disk::parquet_file::{ParquetFile, broken};
use crate::disk::recording_file::open_recording;
use crate::disk::whole_file::{create_folder, json_bytes, write_bytes};
use crate::{Recording, SkinLayout};

/// Staged bytes at which a new data file begins.
pub(super) const BYTES_PER_FILE: u64 = MEGABYTES_PER_FILE * 1024 * 1024;

/// The data files, one after the other.
struct DataFiles<'a> {
    dir: &'a Path,
    schema: SchemaRef,
    bytes_per_file: u64,
    file: Option<ParquetFile>,
    staged_bytes: u64,
    /// Files begun so far.
    files: usize,
}

impl DataFiles<'_> {
    /// Opens the file for an episode that took so many staged bytes; chunk and file index.
    fn begin_episode(&mut self, staged_bytes: u64) -> Result<(usize, usize, &mut ParquetFile), DiskError> {
        if self.file.is_some() && self.staged_bytes + staged_bytes > self.bytes_per_file {
            self.close()?;
        }
        self.staged_bytes += staged_bytes;
        let file = match self.file.take() {
            Some(file) => file,
            None => {
                self.files += 1;
                let (chunk, number) = self.place();
                create_folder(&self.dir.join(format!("data/chunk-{chunk:03}")))?;
                ParquetFile::create(&self.dir.join(names::data(chunk, number)), Arc::clone(&self.schema), [])?
            }
        };
        let (chunk, number) = self.place();
        Ok((chunk, number, self.file.insert(file)))
    }

    /// Chunk and file index of the file that was begun last.
    fn place(&self) -> (usize, usize) {
        let index = self.files - 1;
        (index / FILES_PER_CHUNK, index % FILES_PER_CHUNK)
    }

    fn close(&mut self) -> Result<(), DiskError> {
        self.staged_bytes = 0;
        self.file.take().map_or(Ok(()), ParquetFile::close)
    }
}

/// Gives a batch of a staged recording its place in the data set.
fn renumber(batch: &RecordBatch, episode: usize, first_index: usize, task: i64) -> Result<RecordBatch, ArrowError> {
    let rows = batch.num_rows();
    let schema = batch.schema();
    let column = |(field, array): (&FieldRef, &ArrayRef)| -> ArrayRef {
        match field.name().as_str() {
            "episode_index" => Arc::new(Int64Array::from_value(episode as i64, rows)),
            "index" => Arc::new(Int64Array::from_iter_values(
                first_index as i64..(first_index + rows) as i64,
            )),
            "task_index" => Arc::new(Int64Array::from_value(task, rows)),
            _ => Arc::clone(array),
        }
    };
    let columns = schema.fields().iter().zip(batch.columns()).map(column).collect();
    RecordBatch::try_new(Arc::clone(&schema), columns)
}

/// The tables of ground truth.
struct TruthTables {
    objects: ParquetFile,
    goals: ParquetFile,
    contacts: ParquetFile,
}

impl TruthTables {
    fn create(dir: &Path) -> Result<Self, DiskError> {
        let table = |name: &str, rows: RecordBatch| ParquetFile::create(&dir.join(name), rows.schema(), []);
        Ok(TruthTables {
            objects: table(names::OBJECTS, object_rows(dir, 0, &[])?)?,
            goals: table(names::GOALS, goal_rows(dir, 0, &[], &SkinLayout::default())?)?,
            contacts: table(names::CONTACTS, contact_rows(dir, 0, &[], &[], &SkinLayout::default())?)?,
        })
    }

    fn write(&mut self, dir: &Path, episode: usize, recording: &Recording) -> Result<(), DiskError> {
        let Recording {
            objects,
            goals,
            contacts,
            layout,
            ..
        } = recording;
        self.objects.write(&object_rows(dir, episode, objects)?)?;
        self.goals.write(&goal_rows(dir, episode, goals, layout)?)?;
        self.contacts
            .write(&contact_rows(dir, episode, contacts, objects, layout)?)
    }

    fn close(self) -> Result<(), DiskError> {
        self.objects.close()?;
        self.goals.close()?;
        self.contacts.close()
    }
}

/// Writes everything but `incomplete/` from the staged reaches; `meta/info.json` last.
pub(super) fn assemble(set: &DatasetWriter) -> Result<(), DiskError> {
    let (dir, plan) = (set.dir(), set.plan());
    for folder in ["data", "meta"].map(|name| dir.join(name)) {
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
    let mut data = DataFiles {
        dir,
        schema: schema(&features),
        bytes_per_file: set.bytes_per_file,
        file: None,
        staged_bytes: 0,
        files: 0,
    };
    let mut truth = TruthTables::create(dir)?;
    let mut episodes = Vec::with_capacity(plan.episodes.len());
    let mut total_frames = 0;
    for (position, planned) in plan.episodes.iter().enumerate() {
        let path = set.staged(position);
        let staged_bytes = fs::metadata(&path).map_err(DiskError::io(&path, "read"))?.len();
        let (recording, batches) = open_recording(&path)?;
        let (chunk_index, file_index, file) = data.begin_episode(staged_bytes)?;
        let task = tasks.get(planned.task.as_str()).copied().unwrap_or_default();
        let first_index = total_frames;
        for batch in batches {
            let batch = renumber(&batch?, position, total_frames, task).map_err(|error| broken(&path, error))?;
            statistics.add(&batch);
            file.write(&batch)?;
            total_frames += batch.num_rows();
        }
        file.end_row_group()?;
        truth.write(dir, position, &recording)?;
        let place = Place {
            frames: total_frames - first_index,
            first_index,
            chunk_index,
            file_index,
        };
        episodes.push(Episode::new(planned.task.clone(), place, recording));
    }
    data.close()?;
    truth.close()?;
    write_episodes(&dir.join(names::EPISODES), &episodes)?;
    write_json(&dir.join(names::STATS), &statistics.summary())?;
    finish_with_info(dir, &Info::new(plan, total_frames, tasks.len(), &features))
}

/// Hashes everything, then writes the file that makes the set whole.
fn finish_with_info(dir: &Path, info: &Info) -> Result<(), DiskError> {
    let path = dir.join(names::INFO);
    let bytes = json_bytes(&path, info)?;
    let mut checksums = Checksums::default();
    checksums.add_folder(dir, "data")?;
    checksums.add_folder(dir, "meta")?;
    checksums.add(names::INFO, FileSum::of_bytes(&bytes));
    checksums.write(dir)?;
    write_bytes(&path, &bytes)
}

fn write_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<(), DiskError> {
    write_bytes(path, &json_bytes(path, value)?)
}
