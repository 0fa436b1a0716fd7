//! Trials in Parquet files that others wrote.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow_array::types::Int8Type;
use arrow_array::{
    ArrayRef, DictionaryArray, Float32Array, Float64Array, Int8Array, Int16Array, Int64Array, LargeStringArray,
    NullArray, RecordBatch, StringArray, UInt8Array,
};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;

use super::refused;
use crate::disk::{read_trials, write_trials};
use crate::{Sample, Trial};

fn write_parquet(path: &Path, columns: Vec<(&str, ArrayRef)>, compression: Compression) {
    let batch = RecordBatch::try_from_iter_with_nullable(columns.into_iter().map(|(n, a)| (n, a, true))).unwrap();
    let properties = WriterProperties::builder().set_compression(compression).build();
    let file = fs::File::create(path).unwrap();
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
}

fn foreign_columns() -> Vec<(&'static str, ArrayRef)> {
    let category: DictionaryArray<Int8Type> = vec!["leaf", "leaf", "trunk"].into_iter().collect();
    vec![
        ("noise", Arc::new(NullArray::new(3))),
        ("category", Arc::new(category)),
        ("trial", Arc::new(Int16Array::from(vec![1, 1, 2]))),
        (
            "patch",
            Arc::new(LargeStringArray::from(vec![Some("forearm"), Some("forearm"), None])),
        ),
        ("taxel", Arc::new(Float64Array::from(vec![Some(5.0), Some(5.0), None]))),
        ("reach", Arc::new(UInt8Array::from(vec![3, 3, 4]))),
        ("time_s", Arc::new(Float32Array::from(vec![0.0, 0.5, 0.25]))),
        ("force_n", Arc::new(Float64Array::from(vec![0.1, 0.2, 0.3]))),
        ("motion_m", Arc::new(NullArray::new(3))),
    ]
}

/// Pins that narrow integers, single precision, categories, large strings, gaps, all-null columns, snappy and zstd
/// are read.
#[test]
fn types_that_pandas_and_polars_write_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    for compression in [
        Compression::SNAPPY,
        Compression::ZSTD(Default::default()),
        Compression::UNCOMPRESSED,
    ] {
        write_parquet(&path, foreign_columns(), compression);
        let trials = read_trials(&path).unwrap();
        let facts = |t: &Trial| {
            (
                t.trial,
                t.category.clone(),
                t.reach,
                t.patch.clone(),
                t.taxel,
                t.samples.len(),
            )
        };
        assert_eq!(
            facts(&trials[0]),
            (1, Some("leaf".into()), Some(3), Some("forearm".into()), Some(5), 2)
        );
        assert_eq!(facts(&trials[1]), (2, Some("trunk".into()), Some(4), None, None, 1));
        assert_eq!(
            trials[0].samples[1],
            Sample {
                time_s: 0.5,
                force_n: 0.2,
                motion_m: None,
                region: None,
                touched: None,
            }
        );
    }
}

/// Pins the row and column of each kind of fault in Parquet.
#[test]
fn every_fault_of_a_parquet_table_is_named_with_its_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let faults: [(&str, ArrayRef, Option<usize>); 7] = [
        (
            "force_n",
            Arc::new(Float64Array::from(vec![0.1, f64::NAN, 0.3])),
            Some(2),
        ),
        (
            "force_n",
            Arc::new(Float64Array::from(vec![Some(0.1), Some(0.2), None])),
            Some(3),
        ),
        ("time_s", Arc::new(Float64Array::from(vec![0.5, 0.5, 0.0])), Some(2)),
        ("taxel", Arc::new(Float64Array::from(vec![5.5, 5.5, 1.0])), Some(1)),
        ("trial", Arc::new(Int16Array::from(vec![1, -1, 2])), Some(2)),
        ("reach", Arc::new(StringArray::from(vec!["3", "4", "5"])), Some(2)),
        (
            "motion_m",
            Arc::new(arrow_array::BooleanArray::from(vec![true; 3])),
            None,
        ),
    ];
    for (field, array, row) in faults {
        let mut columns = foreign_columns();
        columns.iter_mut().find(|(name, _)| *name == field).unwrap().1 = array;
        write_parquet(&path, columns, Compression::SNAPPY);
        let error = refused(read_trials(&path));
        assert_eq!((error.field.as_str(), error.line), (field, row), "{error}");
    }
    for gone in ["trial", "time_s", "force_n"] {
        let columns = foreign_columns()
            .into_iter()
            .filter(|(name, _)| *name != gone)
            .collect();
        write_parquet(&path, columns, Compression::SNAPPY);
        assert_eq!(refused(read_trials(&path)).field, gone);
    }
    write_trials(&path, []).unwrap();
    assert_eq!(refused(read_trials(&path)).field, "rows");
    write_parquet(&path, foreign_columns(), Compression::SNAPPY);
    let bytes = fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(53) {
        fs::write(&path, &bytes[..length]).unwrap();
        assert_eq!(refused(read_trials(&path)).field, "Parquet");
    }
}

/// Pins that truth values, numbers and a column without values are read, as in CSV files.
#[test]
fn touched_in_parquet_may_be_a_flag_or_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let columns: [(ArrayRef, [Option<bool>; 2]); 4] = [
        (
            Arc::new(arrow_array::BooleanArray::from(vec![false, true, false])),
            [Some(true), Some(false)],
        ),
        (Arc::new(UInt8Array::from(vec![0, 0, 1])), [Some(false), Some(true)]),
        (
            Arc::new(Float64Array::from(vec![Some(1.0), Some(0.0), None])),
            [Some(true), None],
        ),
        (Arc::new(NullArray::new(3)), [None, None]),
    ];
    for (array, expected) in columns {
        let mut table = foreign_columns();
        table.push(("touched", array));
        write_parquet(&path, table, Compression::SNAPPY);
        let trials = read_trials(&path).unwrap();
        assert_eq!(trials.iter().map(Trial::touched).collect::<Vec<_>>(), expected);
    }
}

/// Tests that tables that declare far more rows or text than their length can hold are refused by the footer, with the
/// limit, and that a name that is too long is refused with its row.
#[test]
fn tables_that_expand_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let zstd = Compression::ZSTD(Default::default());
    let table = |rows: i64, category: String| -> Vec<(&str, ArrayRef)> {
        let places = Int8Array::from(vec![0; rows as usize]);
        let categories = Arc::new(StringArray::from(vec![category]));
        vec![
            ("trial", Arc::new(Int64Array::from(vec![1; rows as usize]))),
            ("category", Arc::new(DictionaryArray::new(places, categories))),
            ("time_s", Arc::new(Int64Array::from(vec![1; rows as usize]))),
            ("force_n", Arc::new(Float64Array::from(vec![1.0; rows as usize]))),
        ]
    };
    for (rows, category, field, allowed) in [
        (
            1_000_000,
            "leaf".to_owned(),
            "rows",
            "at most 4 rows for each byte of the file",
        ),
        (3, "x".repeat(17 << 20), "category", "at most 16777216 bytes"),
        (3, "x".repeat(1001), "category", "at most 1000 bytes"),
    ] {
        write_parquet(&path, table(rows, category), zstd);
        let error = refused(read_trials(&path));
        assert_eq!(error.field, field, "{error}");
        assert!(error.allowed.starts_with(allowed), "{error}");
    }
    write_parquet(&path, table(1, "x".repeat(1000)), zstd);
    assert_eq!(read_trials(&path).unwrap().len(), 1);
}

/// Tests that a text of some megabytes, which every row of a dictionary repeats, is not decoded for many rows at once.
#[test]
fn a_long_text_is_refused_before_it_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let rows = 1024;
    let places = Int8Array::from(vec![0; rows]);
    let text = Arc::new(StringArray::from(vec!["x".repeat(12 << 20)]));
    let columns: Vec<(&str, ArrayRef)> = vec![
        ("trial", Arc::new(Int64Array::from(vec![1; rows]))),
        ("category", Arc::new(DictionaryArray::new(places, text))),
        ("time_s", Arc::new(Int64Array::from_iter_values(0..rows as i64))),
        ("force_n", Arc::new(Float64Array::from(vec![1.0; rows]))),
    ];
    write_parquet(&path, columns, Compression::ZSTD(Default::default()));
    // All rows together would be more text than Arrow can hold, and its error would name no limit.
    let error = refused(read_trials(&path));
    assert!(error.allowed.starts_with("at most 1000 bytes"), "{error}");
}
