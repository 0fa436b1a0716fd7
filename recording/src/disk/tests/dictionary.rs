use std::fs;
use std::path::{Path, PathBuf};

use parquet::basic::ColumnOrder;
use serde_json::{Value, json};

use super::dataset::{info, make};
use super::reach;
use crate::disk::table::read::{COLUMNS_KEY, ParquetTable};
use crate::disk::tables::dictionary::{FRAMES, RECORDING_TRUTH, Table};
use crate::disk::tables::{all_tables, describe_tables};
use crate::disk::trials::TRIALS;
use crate::disk::{write_recording, write_trials};
use crate::{Sample, Trial};

/// The columns of a Parquet file, each with what the metadata say about it, in order.
pub(super) fn columns(path: &Path) -> Vec<(String, Value)> {
    let table = ParquetTable::open(path).unwrap();
    let about: Value = serde_json::from_str(&table.key_value(COLUMNS_KEY).unwrap()).unwrap();
    let schema = table.footer.file_metadata().schema();
    let names = schema.get_fields().iter().map(|field| field.name().to_owned());
    names.map(|name| (name.clone(), about[&name].clone())).collect()
}

/// Asserts that the tables together describe all columns of a file and no others.
fn described(path: &Path, tables: &[&Table]) {
    let mut found = columns(path);
    for column in tables.iter().flat_map(|table| (table.columns)()) {
        let covered = found.extract_if(.., |(name, about)| {
            let same = column.covers(name);
            if same {
                assert_eq!(about["description"], column.what, "{name}");
                assert_eq!(about.get("unit").map_or("", |unit| unit.as_str().unwrap()), column.unit, "{name}");
            }
            same
        });
        assert!(covered.count() > 0, "{}: no column {}", path.display(), column.name);
    }
    assert!(found.is_empty(), "{}: not described: {found:?}", path.display());
}

/// Tests that the dictionary describes every column of every table, of recordings and of trials, with its unit, and no
/// other column.
#[test]
fn every_column_is_described_in_the_file_itself() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    make(&set);
    for table in all_tables() {
        let path = set.join(table.path);
        let file = path.join("chunk-000/file-000.parquet");
        described(if path.is_file() { &path } else { &file }, &[table]);
    }
    let recording = folder.path().join("reach.parquet");
    write_recording(&recording, &reach(0, 5)).unwrap();
    described(&recording, &[&FRAMES, &RECORDING_TRUTH]);
    let trials = folder.path().join("trials.parquet");
    let sample = Sample { time_s: 0.0, force_n: 1.0, ..Sample::default() };
    let trial = Trial { trial: 1, category: None, reach: None, patch: None, taxel: None, samples: vec![sample] };
    write_trials(&trials, &[trial]).unwrap();
    described(&trials, &[&TRIALS]);
}

/// Tests that all files declare an order of columns that readers of some years know, such as polars 1.35.
#[test]
fn readers_of_some_years_know_the_order_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let (set, recording) = (folder.path().join("set"), folder.path().join("reach.parquet"));
    make(&set);
    write_recording(&recording, &reach(0, 5)).unwrap();
    let tables = all_tables().map(|table| set.join(table.path));
    let file = |path: PathBuf| {
        if path.is_file() { path } else { path.join("chunk-000/file-000.parquet") }
    };
    for path in tables.map(file).chain([recording]) {
        let footer = ParquetTable::open(&path).unwrap().footer;
        let orders = footer.file_metadata().column_orders().unwrap();
        assert_eq!(orders.len(), footer.file_metadata().schema_descr().num_columns());
        for order in orders {
            assert!(matches!(order, ColumnOrder::TYPE_DEFINED_ORDER(_)), "{}: {order}", path.display());
        }
    }
}

/// Tests that the metadata of a file name the category codes of a column.
#[test]
fn category_codes_stand_with_their_column() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let path = folder.path().join("truth/taxels/chunk-000/file-000.parquet");
    let columns = columns(&path);
    let (_, about) = columns.iter().find(|(name, _)| name == "category_code").unwrap();
    let expected = json!({"-1": "none", "0": "leaf", "1": "trunk", "2": "block", "3": "outlier"});
    assert_eq!(about["codes"], expected);
}

/// Tests that a learner cannot read ground truth by accident: neither the frames nor the features contain any, and the
/// card makes the frames the default table.
#[test]
fn frames_hold_no_ground_truth() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let frames = columns(&folder.path().join("data/chunk-000/file-000.parquet"));
    let names: Vec<_> = frames.into_iter().map(|(name, _)| name).collect();
    let mut features: Vec<_> = info(folder.path())["features"].as_object().unwrap().keys().cloned().collect();
    assert!(names.iter().all(|name| !name.contains("truth")), "{names:?}");
    let mut sorted = names;
    sorted.sort();
    features.sort();
    assert_eq!(sorted, features);
    let card = fs::read_to_string(folder.path().join("README.md")).unwrap();
    assert!(card.contains("- config_name: frames\n  data_files: data/*/*.parquet\n  default: true\n"));
}

/// Tests that `docs/data.md` describes the tables as they are. After a change, the left side of the failing assertion
/// is the new text.
#[test]
fn the_document_lists_the_tables() {
    let document = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/data.md")).unwrap();
    let tables = all_tables().chain([&RECORDING_TRUTH, &TRIALS]);
    let (_, listed) = document.split_once("<!-- tables -->\n\n").unwrap();
    assert_eq!(describe_tables(tables, &[]), listed);
}
