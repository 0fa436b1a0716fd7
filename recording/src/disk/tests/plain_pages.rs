use std::fs::File;

use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::basic::Encoding;
use parquet::file::properties::WriterProperties;

use super::dataset::plan;
use super::reach;
use crate::disk::parquet_file::read_footer;
use crate::disk::parquet_input::ParquetInput;
use crate::disk::plain_pages;
use crate::disk::{Dataset, DatasetWriter};

const COLUMN: &str = "observation.tactile.forearm";

/// A finished set of two reaches of different lengths.
fn make(dir: &std::path::Path) -> Dataset {
    let mut plan = plan();
    let recordings = [reach(0, 120), reach(1, 1500)];
    let episode = plan.episodes[0].clone();
    plan.episodes = vec![episode.clone(), episode];
    for (planned, recording) in plan.episodes.iter_mut().zip(&recordings) {
        planned.reach_index = recording.reach_index;
    }
    let writer = DatasetWriter::create(dir, plan, false).unwrap();
    for (position, recording) in recordings.iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    writer.finish().unwrap()
}

/// Pins that columns read straight from the pages have the numbers of Arrow's reader, converted, for every column of
/// double precision and reaches of one and of several pages. Other columns have no width.
#[test]
fn pages_have_the_numbers_of_the_columns() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let mut wide = 0;
    for name in set.frame_columns() {
        let Some(width) = set.width_of_doubles(&name) else {
            assert!(name.ends_with("index") || name == "timestamp", "{name}");
            continue;
        };
        wide += usize::from(width > 1);
        for (index, episode) in set.episodes().iter().enumerate() {
            let batches = set.read_columns(index, &[&name]).unwrap();
            let expected: Vec<f64> = batches
                .iter()
                .flat_map(|batch| crate::disk::dataset::doubles(batch, &name).unwrap().to_vec())
                .collect();
            let mut found = vec![f64::NAN; episode.frames * width];
            set.read_doubles(index, &name, |number| 2.0 * number, &mut found)
                .unwrap();
            assert_eq!(found.len(), expected.len(), "{name}");
            assert!(
                found.iter().zip(&expected).all(|(found, own)| *found == 2.0 * own),
                "{name}"
            );
        }
    }
    assert!(wide > 5, "{wide} columns of several numbers");
    // If there is one place too few, Arrow's reader fills the others and then returns an error.
    let (width, frames) = (set.width_of_doubles(COLUMN).unwrap(), set.episodes()[1].frames);
    let mut whole = vec![0.0; frames * width];
    set.read_doubles(1, COLUMN, |number| number, &mut whole).unwrap();
    let mut short = vec![0.0; frames * width - 1];
    assert!(set.read_doubles(1, COLUMN, |number| number, &mut short).is_err());
    assert_eq!(short, whole[..short.len()]);
    assert!(
        set.read_doubles(2, COLUMN, |number| number, &mut []).is_err(),
        "no such reach"
    );
    assert!(
        set.read_doubles(0, COLUMN, |number| number, &mut [0.0]).is_err(),
        "not one number"
    );
}

/// Pins when pages are read directly. Plain numbers are; the same numbers in another encoding are left to Arrow's
/// reader, and so are numbers that do not fit the destination. A damaged page is an error or is left to Arrow's reader,
/// and never a panic.
#[test]
fn other_encodings_are_left_to_arrow() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let path = folder.path().join("data/chunk-000/file-000.parquet");
    let width = set.width_of_doubles(COLUMN).unwrap();
    let count = set.episodes()[1].frames * width;
    let read = |path: &std::path::Path, group: usize, count: usize| {
        let file = ParquetInput::open(path).unwrap();
        let footer = read_footer(&file).unwrap();
        let mut to = vec![0.0_f64; count];
        let group = footer.metadata().row_group(group);
        let done = plain_pages::read(&file, group, COLUMN, |number| number, &mut to);
        done.map(|done| done.then_some(to))
    };
    let numbers = read(&path, 1, count).unwrap().expect("plain numbers");
    assert!(numbers.iter().any(|number| *number > 0.0));
    assert_eq!(read(&path, 1, count - 1).unwrap(), None);
    assert_eq!(read(&path, 1, count + 1).unwrap(), None);
    let reader = ParquetRecordBatchReaderBuilder::try_new_with_options(
        File::open(&path).unwrap(),
        ArrowReaderOptions::default(),
    );
    let batches: Vec<_> = reader.unwrap().build().unwrap().map(Result::unwrap).collect();
    let other = folder.path().join("other.parquet");
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .build();
    let mut writer =
        ArrowWriter::try_new(File::create(&other).unwrap(), batches[0].schema(), Some(properties)).unwrap();
    batches.iter().for_each(|batch| writer.write(batch).unwrap());
    writer.close().unwrap();
    assert_eq!(read(&other, 0, count).unwrap(), None);
    // Garbage where the pages are.
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[4..middle].fill(0xff);
    let damaged = folder.path().join("damaged.parquet");
    std::fs::write(&damaged, bytes).unwrap();
    let own = set.episodes()[0].frames * width;
    assert!(!matches!(read(&damaged, 0, own), Ok(Some(_))));
}
