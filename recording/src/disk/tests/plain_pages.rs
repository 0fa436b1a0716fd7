use std::fs;
use std::sync::Arc;

use parquet::basic::Encoding;
use parquet::data_type::FloatType;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::dataset::plan;
use super::reach;
use crate::disk::table::{Batch, ParquetTable, Want, plain_pages};
use crate::disk::{Dataset, DatasetWriter, Rows};

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

/// Tests that columns read straight from the pages have the numbers of the column reader, converted, for every column of
/// floating-point numbers and reaches of one and of several pages. Other columns have no width.
#[test]
fn pages_have_the_numbers_of_the_columns() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let mut wide = 0;
    for name in set.frame_columns() {
        let Some((width, single)) = set.width_of_floats(&name) else {
            assert!(name.ends_with("index"), "{name}");
            continue;
        };
        wide += usize::from(width > 1);
        for (index, episode) in set.episodes().iter().enumerate() {
            // Lists of any length are read without the shortcut.
            let path = folder.path().join(format!("data/chunk-000/file-{:03}.parquet", episode.file_index));
            let table = ParquetTable::open(&path).unwrap();
            let want = |found: &str| if found == name { Want::All } else { Want::Nothing };
            let mut slowly = table.batch(index, 0..episode.frames, &want).unwrap().columns.remove(0);
            if let Rows::Lists { ends, .. } = &slowly.rows {
                assert_eq!(ends.len() * width, slowly.values.len());
                slowly.rows = Rows::Fixed(width);
            }
            let batches = set.read_columns(index, &[&name]).unwrap();
            assert_eq!(batches[0].columns, [slowly]);
            let numbers = |batch: &Batch| match single {
                true => batch.fixed::<f32>(&name, width).unwrap().iter().map(|number| f64::from(*number)).collect(),
                false => batch.fixed::<f64>(&name, width).unwrap().to_vec(),
            };
            let expected: Vec<f64> = batches.iter().flat_map(numbers).collect();
            let mut found = vec![f64::NAN; episode.frames * width];
            set.read_floats(index, &name, |number| 2.0 * number, &mut found).unwrap();
            assert_eq!(found.len(), expected.len(), "{name}");
            assert!(found.iter().zip(&expected).all(|(found, own)| *found == 2.0 * own), "{name}");
        }
    }
    assert!(wide > 5, "{wide} columns of several numbers");
    // If there is one place too few, the column reader fills the others and then returns an error.
    let (width, frames) = (set.width_of_floats(COLUMN).unwrap().0, set.episodes()[1].frames);
    let mut whole = vec![0.0; frames * width];
    set.read_floats(1, COLUMN, |number| number, &mut whole).unwrap();
    let mut short = vec![0.0; frames * width - 1];
    assert!(set.read_floats(1, COLUMN, |number| number, &mut short).is_err());
    assert_eq!(short, whole[..short.len()]);
    assert!(set.read_floats(2, COLUMN, |number| number, &mut []).is_err(), "no such reach");
    assert!(set.read_floats(0, COLUMN, |number| number, &mut [0.0]).is_err(), "not one number");
}

/// Tests when pages are read directly. Plain numbers are; the same numbers in another encoding are left to the column
/// reader, and so are numbers that do not fit the destination. A damaged page is an error or is left to the
/// column reader, and never a panic.
#[test]
fn other_encodings_are_left_to_the_column_reader() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let path = folder.path().join("data/chunk-000/file-000.parquet");
    let (width, _) = set.width_of_floats(COLUMN).unwrap();
    let count = set.episodes()[1].frames * width;
    let read = |path: &std::path::Path, group: usize, count: usize| {
        let table = ParquetTable::open(path).unwrap();
        let mut to = vec![0.0_f32; count];
        let group = table.footer.row_group(group);
        let done = plain_pages::read(&table.file, group, COLUMN, |number| number, &mut to);
        done.map(|done| done.then_some(to))
    };
    let numbers = read(&path, 1, count).unwrap().expect("plain numbers");
    assert!(numbers.iter().any(|number| *number > 0.0));
    assert_eq!(read(&path, 1, count - 1).unwrap(), None);
    assert_eq!(read(&path, 1, count + 1).unwrap(), None);
    let other = folder.path().join("other.parquet");
    let schema = format!("message schema {{ optional float {COLUMN}; }}");
    let properties =
        WriterProperties::builder().set_dictionary_enabled(false).set_encoding(Encoding::BYTE_STREAM_SPLIT).build();
    let file = fs::File::create(&other).unwrap();
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let mut column = group.next_column().unwrap().unwrap();
    column.typed::<FloatType>().write_batch(&numbers, Some(&vec![1; count]), None).unwrap();
    column.close().unwrap();
    group.close().unwrap();
    writer.close().unwrap();
    assert_eq!(read(&other, 0, count).unwrap(), None);
    // Garbage where the pages are.
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[4..middle].fill(0xff);
    let damaged = folder.path().join("damaged.parquet");
    fs::write(&damaged, bytes).unwrap();
    let own = set.episodes()[0].frames * width;
    assert!(!matches!(read(&damaged, 0, own), Ok(Some(_))));
}
