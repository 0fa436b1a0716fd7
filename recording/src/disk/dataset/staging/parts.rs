//! Makes one set from the parts of a campaign, the set that one process would have made. Either several processes write
//! into one folder, or the sets of several machines are joined.
//!
//! In a folder that is shared, each process stages its part of the reaches in `incomplete/`, under their positions in
//! the plan of the whole set, and holds a shared lock meanwhile. When it is done, it tries to get the lock exclusively.
//! It gets the lock only if no other process is at work, so the last process assembles the set. If two processes are
//! done at the same moment, one of them gets the lock, and sees everything that the other staged before releasing its
//! lock.

use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::folder::not_locked;
use crate::disk::dataset::plan::first_difference;
use crate::disk::dataset::{Dataset, DatasetPlan, DatasetWriter, PlannedEpisode, Shard, names};
use crate::disk::files::is_there;
use crate::{DiskError, InputError, Result};

impl DatasetWriter {
    /// Starts or continues a data set in a folder that several processes share. Each process passes the plan of the whole set,
    /// stages its own reaches ([`DatasetWriter::missing_of`]) and then calls [`DatasetWriter::finish_if_last`].
    ///
    /// # Errors
    /// As [`DatasetWriter::create`] with `resume`. [`DiskError::InUse`] while a process assembles the set, or writes it alone.
    pub fn share(dir: impl AsRef<Path>, plan: DatasetPlan) -> Result<Self, DiskError> {
        Self::begin(dir.as_ref().to_path_buf(), plan, true, File::try_lock_shared)
    }

    /// Ends the work of this process. Assembles the set if no other process is at work in the folder and all reaches
    /// are staged. Otherwise returns `None`, and leaves the set to the processes that are still at work or start later.
    ///
    /// # Errors
    /// As [`DatasetWriter::finish`].
    pub fn finish_if_last(mut self) -> Result<Option<Dataset>, DiskError> {
        let dir = self.staging.dir.clone();
        let released = self.lock.unlock().map_err(TryLockError::Error);
        match released.and_then(|()| self.lock.try_lock()).map_err(not_locked(&dir)) {
            Err(DiskError::InUse { .. }) => return Ok(None),
            locked => locked?,
        }
        if !is_there(&dir.join(names::PLAN))? {
            // Another process has finished the set while nobody held the lock.
            return Dataset::open(dir).map(Some);
        }
        self.whole = is_there(&dir.join(names::INFO))?;
        // The checksum of a staged reach is written after the reach, so it is enough that the checksum exists. `finish`
        // compares the checksums, which takes longer.
        for position in self.to_assemble()? {
            if !is_there(&self.staging.path(position).with_extension("json"))? {
                return Ok(None);
            }
        }
        self.finish().map(Some)
    }
}

/// All parts of one campaign, in order.
#[derive(Debug)]
pub struct Shards {
    /// Part 1 first.
    parts: Vec<Dataset>,
    /// The plan of the whole campaign.
    pub plan: DatasetPlan,
}

/// The largest number of missing parts that an error names.
const MOST_NAMED: usize = 8;

/// The plan of a part, without the fields that differ between parts.
fn common(part: &Dataset) -> Result<Value> {
    let mut plan = part.plan().clone();
    plan.provenance.shard = None;
    plan.episodes.clear();
    serde_json::to_value(plan).map_err(DiskError::io(part.dir(), "compare"))
}

/// The part that a data set says it is.
fn shard_of(set: &Dataset) -> Result<Shard, InputError> {
    let allowed = "a part of a campaign, made with `underbrush generate --shard I/N`";
    let error = |found: String, remedy: &str| InputError::new(set.dir(), "shard", found, allowed, remedy);
    match set.plan().provenance.shard {
        None => Err(error("none: the set is a whole campaign".into(), "leave it out")),
        Some(shard) if shard.index < shard.count => Ok(shard),
        Some(shard) => Err(error(shard.to_string(), "generate the part again")),
    }
}

/// An error unless the part belongs to the same campaign as the first.
fn require_same_campaign(first: &Dataset, part: &Dataset) -> Result<()> {
    let remedy = "merge only parts that were generated from the same scenes, arms, seed, options and version";
    let error = |field: &str, found: String, allowed: String| -> DiskError {
        let allowed = format!("{allowed}, as in {}", first.dir().display());
        InputError::new(part.dir(), field, found, allowed, remedy).into()
    };
    let (expected, found) = (shard_of(first)?, shard_of(part)?);
    if let Some((field, expected, found)) = first_difference(&common(first)?, &common(part)?) {
        return Err(error(&field, found, expected));
    }
    if expected.count != found.count {
        return Err(error("shard", found.to_string(), format!("a part of {}", expected.count)));
    }
    Ok(())
}

/// An error that names the missing parts, if there are any.
fn require_all(places: &BTreeMap<u64, Dataset>, count: u64) -> Result<()> {
    let absent = (0..count).filter(|index| !places.contains_key(index));
    let named: Vec<String> = absent.take(MOST_NAMED).map(|index| Shard { index, count }.to_string()).collect();
    let Some(first) = places.values().next().filter(|_| !named.is_empty()) else { return Ok(()) };
    let more = count - places.len() as u64 - named.len() as u64;
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let found = format!("{} of {count} parts, without {}{more}", places.len(), named.join(", "));
    let remedy = "generate the missing parts with --shard, and name the folders of all parts";
    Err(InputError::new(first.dir(), "shard", found, format!("all {count} parts, each once"), remedy).into())
}

/// The reaches of the whole campaign, in order, from those of its parts.
fn joined(parts: &[Dataset], whole: &DatasetPlan) -> Result<Vec<PlannedEpisode>> {
    let mut plans: Vec<_> = parts.iter().map(|part| part.plan().episodes.iter()).collect();
    let count: usize = plans.iter().map(ExactSizeIterator::len).sum();
    let error = |part: usize, found: &str| -> DiskError {
        let allowed = "each reach of the campaign in the part to which it belongs";
        InputError::new(parts[part].dir(), "episodes", found, allowed, "generate the part again").into()
    };
    let mut episodes = Vec::with_capacity(count);
    // According to the scenes of the campaign.
    let scenes = whole.provenance.scenes.iter();
    let planned = scenes.flat_map(|scene| (0..scene.reaches).map(|reach| (scene.name.as_str(), reach)));
    for (position, (scene, reach_index)) in planned.enumerate() {
        let part = position % parts.len();
        let Some(episode) = plans[part].next() else {
            return Err(error(part, &format!("no reach {reach_index} of {scene}")));
        };
        if episode.scene != scene || episode.reach_index != reach_index {
            let found = format!("reach {} of {}", episode.reach_index, episode.scene);
            return Err(error(part, &format!("{found} in place of reach {reach_index} of {scene}")));
        }
        episodes.push(episode.clone());
    }
    match plans.iter().position(|rest| rest.len() > 0) {
        Some(part) => Err(error(part, "more reaches than the campaign has")),
        None => Ok(episodes),
    }
}

impl Shards {
    /// Opens the folders of all parts of a campaign, in any order. Tables are verified when [`Shards::merge`] reads them.
    ///
    /// # Errors
    /// [`DiskError::Input`] if a folder is not part of a campaign, is part of another campaign than the first folder,
    /// or holds the same part as another folder, and if parts are missing. The error names the folder or the missing
    /// parts. Otherwise as [`Dataset::open`].
    pub fn open(dirs: &[PathBuf]) -> Result<Self, DiskError> {
        let opened = dirs.iter().map(Dataset::open).collect::<Result<Vec<_>, _>>()?;
        let Some(first) = opened.first() else {
            let remedy = "name the folders of the parts";
            return Err(InputError::new(".", "parts", "none", "all parts of a campaign", remedy).into());
        };
        let count = shard_of(first)?.count;
        opened.iter().try_for_each(|part| require_same_campaign(first, part))?;
        let mut places: BTreeMap<u64, Dataset> = BTreeMap::new();
        for part in opened {
            let shard = shard_of(&part)?;
            if let Some(other) = places.get(&shard.index) {
                let found = format!("{shard}, which {} holds, too", other.dir().display());
                let remedy = "name each part once";
                return Err(InputError::new(part.dir(), "shard", found, "each part once", remedy).into());
            }
            places.insert(shard.index, part);
        }
        require_all(&places, count)?;
        let parts: Vec<Dataset> = places.into_values().collect();
        let mut plan = parts[0].plan().clone();
        plan.provenance.shard = None;
        plan.episodes = joined(&parts, &plan)?;
        Ok(Shards { parts, plan })
    }

    /// Writes the set that one process would have made, byte for byte, into an empty or new folder. With `resume` it
    /// continues an interrupted merge, or opens the set that a merge has finished. As many reaches are in memory as there
    /// are threads. `merged` is called for each reach that has been read.
    ///
    /// # Errors
    /// As [`DatasetWriter::create`] and [`DatasetWriter::finish`], and [`DiskError::Input`] for damaged parts.
    pub fn merge(&self, out: &Path, resume: bool, merged: impl FnMut()) -> Result<Dataset, DiskError> {
        match DatasetWriter::create(out, self.plan.clone(), resume) {
            // With `resume`, this means that the set has the same plan.
            Err(DiskError::Finished { .. }) if resume => Dataset::open(out),
            writer => self.merge_with(writer?, merged),
        }
    }

    /// Writes the set with a writer for its plan.
    pub(crate) fn merge_with(&self, writer: DatasetWriter, mut merged: impl FnMut()) -> Result<Dataset> {
        let count = self.parts.len();
        writer.finish_from(|position| {
            let recording = self.parts[position % count].read_reach(position / count)?;
            merged();
            Ok(recording)
        })
    }
}
