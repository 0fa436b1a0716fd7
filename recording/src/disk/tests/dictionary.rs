use std::fs::{self, File};
use std::path::{Path, PathBuf};

use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::ColumnOrder;

use super::dataset::make;
use super::reach;
use crate::disk::dictionary::{FRAMES, RECORDING_TRUTH, TABLES, Table};
use crate::disk::write_recording;

/// The columns of a Parquet file, each with its metadata, in order.
pub(super) fn columns(path: &Path) -> Vec<(String, std::collections::HashMap<String, String>)> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let fields = builder.schema().fields().iter();
    fields
        .map(|field| {
            let metadata = field.metadata().iter();
            let metadata = metadata.map(|(key, value)| (key.to_string(), value.to_string()));
            (field.name().clone(), metadata.collect())
        })
        .collect()
}

/// Asserts that the tables together describe all columns of a file and no others.
fn described(path: &Path, tables: &[&Table]) {
    let mut found = columns(path);
    for column in tables.iter().flat_map(|table| table.columns) {
        let covered = found.extract_if(.., |(name, metadata)| {
            let same = column.covers(name);
            if same {
                assert_eq!(metadata["description"], column.what, "{name}");
                assert_eq!(metadata.get("unit").map_or("", String::as_str), column.unit, "{name}");
            }
            same
        });
        assert!(covered.count() > 0, "{}: no column {}", path.display(), column.name);
    }
    assert!(found.is_empty(), "{}: not described: {found:?}", path.display());
}

/// Pins that the dictionary describes every column of every table and of recordings, with its unit, and no other
/// column.
#[test]
fn every_column_is_described_in_the_file_itself() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    make(&set);
    for table in TABLES {
        let path = set.join(table.path);
        let file = path.join("chunk-000/file-000.parquet");
        described(if path.is_file() { &path } else { &file }, &[table]);
    }
    let recording = folder.path().join("reach.parquet");
    write_recording(&recording, &reach(0, 5)).unwrap();
    described(&recording, &[&FRAMES, &RECORDING_TRUTH]);
}

/// Tests that all files declare an order of columns that readers of some years know, such as polars 1.35.
#[test]
fn readers_of_some_years_know_the_order_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let (set, recording) = (folder.path().join("set"), folder.path().join("reach.parquet"));
    make(&set);
    write_recording(&recording, &reach(0, 5)).unwrap();
    let tables = TABLES.into_iter().map(|table| set.join(table.path));
    let file = |path: PathBuf| {
        if path.is_file() {
            path
        } else {
            path.join("chunk-000/file-000.parquet")
        }
    };
    for path in tables.map(file).chain([recording]) {
        let footer = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).unwrap()).unwrap();
        let footer = footer.metadata();
        let orders = footer.file_metadata().column_orders().unwrap();
        assert_eq!(orders.len(), footer.file_metadata().schema_descr().num_columns());
        for order in orders {
            assert!(
                matches!(order, ColumnOrder::TYPE_DEFINED_ORDER(_)),
                "{}: {order}",
                path.display()
            );
        }
    }
}

/// Pins the category codes in the metadata of their column.
#[test]
fn category_codes_stand_with_their_column() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let path = folder.path().join("truth/taxels/chunk-000/file-000.parquet");
    let columns = columns(&path);
    let (_, metadata) = columns.iter().find(|(name, _)| name == "category_code").unwrap();
    let codes: serde_json::Value = serde_json::from_str(&metadata["codes"]).unwrap();
    let expected = serde_json::json!({"-1": "none", "0": "leaf", "1": "trunk", "2": "block", "3": "outlier"});
    assert_eq!(codes, expected);
}

/// Pins that a learner cannot read ground truth by accident: neither the frames nor the features contain any, and the
/// card makes the frames the default table.
#[test]
fn frames_hold_no_ground_truth() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let frames = columns(&folder.path().join("data/chunk-000/file-000.parquet"));
    let names: Vec<_> = frames.into_iter().map(|(name, _)| name).collect();
    let mut features: Vec<_> = set.info().features.keys().cloned().collect();
    assert!(names.iter().all(|name| !name.contains("truth")), "{names:?}");
    let mut sorted = names;
    sorted.sort();
    features.sort();
    assert_eq!(sorted, features);
    let card = fs::read_to_string(folder.path().join("README.md")).unwrap();
    assert!(card.contains("- config_name: frames\n  data_files: data/*/*.parquet\n  default: true\n"));
}

/// Pins that `docs/data.md` describes the tables as they are. After a change, the left side of the failing assertion
/// is the new text.
#[test]
fn the_document_lists_the_tables() {
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/data.md")).unwrap();
    let tables: Vec<&Table> = TABLES.into_iter().chain([&RECORDING_TRUTH]).collect();
    let (_, listed) = document.split_once("<!-- tables -->\n\n").unwrap();
    assert_eq!(crate::disk::dataset::describe_tables(&tables, &[]), listed);
}
