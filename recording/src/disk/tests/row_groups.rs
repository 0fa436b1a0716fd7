use std::fs;

use super::dataset::plan;
use super::reach;
use crate::Recording;
use crate::disk::dataset::ROWS_PER_GROUP;
use crate::disk::table::read::{ParquetTable, Want};
use crate::disk::table::row_groups::{EpisodeRows, Footers, row_groups_of};
use crate::disk::tables::tables_of_reaches;
use crate::disk::{Dataset, DatasetWriter};

/// Number of reaches. Together they fill several row groups of every table except goals and objects.
const REACHES: usize = 60;

/// A set of many short reaches in one data file.
fn make(dir: &std::path::Path) -> (Dataset, Vec<Recording>) {
    let recordings: Vec<Recording> = (0..REACHES).map(|index| reach(index as u64, 90 + index)).collect();
    let mut plan = plan();
    let episode = plan.episodes[0].clone();
    plan.episodes = recordings
        .iter()
        .map(|recording| {
            let mut episode = episode.clone();
            episode.reach_index = recording.reach_index;
            episode
        })
        .collect();
    let writer = DatasetWriter::create(dir, plan, false).unwrap();
    for (position, recording) in recordings.iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    (writer.finish().unwrap(), recordings)
}

/// Tests that a reach is within one row group of every table, that a group holds at most a given number of rows and
/// one more reach, and that reading a reach uses no other group: the others are overwritten with garbage and the
/// reach can still be read.
#[test]
fn reading_a_reach_touches_its_own_row_groups_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (set, recordings) = make(folder.path());
    let mut several = 0;
    for described in tables_of_reaches() {
        let path = folder.path().join(described.path).join("chunk-000/file-000.parquet");
        let whole_table = ParquetTable::open(&path).unwrap();
        let metadata = &whole_table.footer;
        several += usize::from(metadata.num_row_groups() > 1);
        let whole = fs::read(&path).unwrap();
        for episode in [0, 1, REACHES / 2, REACHES - 1] {
            let groups = row_groups_of(metadata, episode);
            assert_eq!(groups.len(), 1, "{}: reach {episode}", described.path);
            let rows_in = |path: &std::path::Path| Footers::default().rows(path, episode, &|_| Want::All).unwrap();
            let expected = rows_in(&path);
            // A reach has at most three taxels per frame.
            let longest = 3 * recordings[REACHES - 1].frames.len();
            let rows = metadata.row_group(groups[0]).num_rows() as usize;
            assert!(rows < ROWS_PER_GROUP + longest, "{}: {rows} rows", described.path);
            let mut spoiled = whole.clone();
            for (index, group) in metadata.row_groups().iter().enumerate() {
                for column in group.columns().iter().filter(|_| index != groups[0]) {
                    let (start, length) = column.byte_range();
                    spoiled[start as usize..(start + length) as usize].fill(0xA5);
                }
            }
            let other = folder.path().join("spoiled.parquet");
            fs::write(&other, spoiled).unwrap();
            let found = rows_in(&other);
            let columns =
                |rows: &EpisodeRows| rows.batches.iter().map(|batch| batch.columns.clone()).collect::<Vec<_>>();
            assert!(found.count() > 0 && columns(&found) == columns(&expected), "{}", described.path);
        }
    }
    assert!(several >= 4, "only {several} tables have several row groups");
    for (index, recording) in recordings.iter().enumerate() {
        assert_eq!(&set.read_reach(index).unwrap(), recording, "reach {index}");
    }
}
