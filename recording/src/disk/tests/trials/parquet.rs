//! Trials in Parquet files that others wrote.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::properties::{WriterProperties, WriterVersion};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::refused;
use crate::disk::{read_trials, write_trials};
use crate::{Sample, Trial};

/// The values of a column, some of which may be missing.
enum Values {
    Int32(Vec<Option<i32>>),
    Int64(Vec<Option<i64>>),
    Float(Vec<Option<f32>>),
    Double(Vec<Option<f64>>),
    Flag(Vec<Option<bool>>),
    Text(Vec<Option<ByteArray>>),
}

/// A column of another program: its name, its type in Parquet's schema language, and its values.
type Foreign = (&'static str, &'static str, Values);

const INT16: &str = "int32 NAME (INTEGER(16, true))";
const UINT8: &str = "int32 NAME (INTEGER(8, false))";
const NOTHING: &str = "int32 NAME (UNKNOWN)";
const DOUBLE: &str = "double NAME";
const TEXT: &str = "byte_array NAME (UTF8)";
const FLAG: &str = "boolean NAME";

fn all<T>(values: impl IntoIterator<Item = T>) -> Vec<Option<T>> {
    values.into_iter().map(Some).collect()
}

fn texts(values: &[&str]) -> Values {
    Values::Text(values.iter().map(|text| Some(ByteArray::from(*text))).collect())
}

/// Writes a file as other programs do: text by dictionary, plain or compressed, in pages of version 1 or 2.
fn write_parquet(path: &Path, columns: &[Foreign], compression: Compression, version: WriterVersion) {
    let fields = columns.iter().map(|(name, kind, _)| format!("optional {};", kind.replace("NAME", name)));
    let schema = format!("message schema {{ {} }}", fields.collect::<String>());
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .set_writer_version(version)
        .set_dictionary_page_size_limit(32 << 20)
        .build();
    let file = fs::File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for (_, _, values) in columns {
        let mut column = group.next_column().unwrap().unwrap();
        macro_rules! write {
            ($kind:ty, $values:expr) => {{
                let levels: Vec<i16> = $values.iter().map(|value| i16::from(value.is_some())).collect();
                let values: Vec<<$kind as DataType>::T> = $values.iter().flatten().cloned().collect();
                column.typed::<$kind>().write_batch(&values, Some(&levels), None).unwrap();
            }};
        }
        match values {
            Values::Int32(values) => write!(Int32Type, values),
            Values::Int64(values) => write!(Int64Type, values),
            Values::Float(values) => write!(FloatType, values),
            Values::Double(values) => write!(DoubleType, values),
            Values::Flag(values) => write!(BoolType, values),
            Values::Text(values) => write!(ByteArrayType, values),
        }
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

fn write_snappy(path: &Path, columns: &[Foreign]) {
    write_parquet(path, columns, Compression::SNAPPY, WriterVersion::PARQUET_1_0);
}

fn write_zstd(path: &Path, columns: &[Foreign]) {
    write_parquet(path, columns, Compression::ZSTD(Default::default()), WriterVersion::PARQUET_1_0);
}

fn foreign_columns() -> Vec<Foreign> {
    vec![
        ("noise", NOTHING, Values::Int32(vec![None; 3])),
        ("category", TEXT, texts(&["leaf", "leaf", "trunk"])),
        ("trial", INT16, Values::Int32(all([1, 1, 2]))),
        ("patch", TEXT, Values::Text(vec![Some("forearm".into()), Some("forearm".into()), None])),
        ("taxel", DOUBLE, Values::Double(vec![Some(5.0), Some(5.0), None])),
        ("reach", UINT8, Values::Int32(all([3, 3, 4]))),
        ("time_s", "float NAME", Values::Float(all([0.0, 0.5, 0.25]))),
        ("force_n", DOUBLE, Values::Double(all([0.1, 0.2, 0.3]))),
        ("motion_m", NOTHING, Values::Int32(vec![None; 3])),
    ]
}

/// Tests that narrow integers, single precision, text, gaps, columns without values, both versions of pages, snappy and
/// zstd are read.
#[test]
fn types_that_pandas_and_polars_write_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    for (compression, version) in [
        (Compression::SNAPPY, WriterVersion::PARQUET_1_0),
        (Compression::ZSTD(Default::default()), WriterVersion::PARQUET_2_0),
        (Compression::UNCOMPRESSED, WriterVersion::PARQUET_2_0),
    ] {
        write_parquet(&path, &foreign_columns(), compression, version);
        let trials = read_trials(&path).unwrap();
        let facts = |t: &Trial| (t.trial, t.category.clone(), t.reach, t.patch.clone(), t.taxel, t.samples.len());
        assert_eq!(facts(&trials[0]), (1, Some("leaf".into()), Some(3), Some("forearm".into()), Some(5), 2));
        assert_eq!(facts(&trials[1]), (2, Some("trunk".into()), Some(4), None, None, 1));
        assert_eq!(trials[0].samples[1], Sample { time_s: 0.5, force_n: 0.2, ..Sample::default() });
    }
}

/// Tests the row and column of each kind of fault in Parquet.
#[test]
fn every_fault_of_a_parquet_table_is_named_with_its_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let faults: [(Foreign, Option<usize>); 7] = [
        (("force_n", DOUBLE, Values::Double(all([0.1, f64::NAN, 0.3]))), Some(2)),
        (("force_n", DOUBLE, Values::Double(vec![Some(0.1), Some(0.2), None])), Some(3)),
        (("time_s", DOUBLE, Values::Double(all([0.5, 0.5, 0.0]))), Some(2)),
        (("taxel", DOUBLE, Values::Double(all([5.5, 5.5, 1.0]))), Some(1)),
        (("trial", INT16, Values::Int32(all([1, -1, 2]))), Some(2)),
        (("reach", TEXT, texts(&["3", "4", "5"])), Some(2)),
        (("motion_m", FLAG, Values::Flag(all([true; 3]))), None),
    ];
    for (fault, row) in faults {
        let mut columns = foreign_columns();
        let field = fault.0;
        *columns.iter_mut().find(|(name, ..)| *name == field).unwrap() = fault;
        write_snappy(&path, &columns);
        let error = refused(read_trials(&path));
        assert_eq!((error.field.as_str(), error.line), (field, row), "{error}");
    }
    for gone in ["trial", "time_s", "force_n"] {
        let columns: Vec<_> = foreign_columns().into_iter().filter(|(name, ..)| *name != gone).collect();
        write_snappy(&path, &columns);
        assert_eq!(refused(read_trials(&path)).field, gone);
    }
    write_trials(&path, &[]).unwrap();
    assert_eq!(refused(read_trials(&path)).field, "rows");
    write_snappy(&path, &foreign_columns());
    let bytes = fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(53) {
        fs::write(&path, &bytes[..length]).unwrap();
        assert_eq!(refused(read_trials(&path)).field, "Parquet");
    }
}

/// Tests that a file of another kind is said to be none of Parquet, and that one that only has no footer is damaged.
#[test]
fn another_kind_of_file_is_not_called_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let files = [("summary = \"a scene\"\n", "file"), ("PAR1 and more", "Parquet"), ("PARE and more", "Parquet")];
    for (text, field) in files {
        fs::write(&path, text).unwrap();
        assert_eq!(refused(read_trials(&path)).field, field, "{text}");
    }
}

/// Tests that truth values, numbers and a column without values are read, as in CSV files.
#[test]
fn touched_in_parquet_may_be_a_flag_or_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let columns: [(Foreign, [Option<bool>; 2]); 4] = [
        (("touched", FLAG, Values::Flag(all([false, true, false]))), [Some(true), Some(false)]),
        (("touched", UINT8, Values::Int32(all([0, 0, 1]))), [Some(false), Some(true)]),
        (("touched", DOUBLE, Values::Double(vec![Some(1.0), Some(0.0), None])), [Some(true), None]),
        (("touched", NOTHING, Values::Int32(vec![None; 3])), [None, None]),
    ];
    for (touched, expected) in columns {
        let mut table = foreign_columns();
        table.push(touched);
        write_snappy(&path, &table);
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
    let table = |rows: usize, category: String| -> Vec<Foreign> {
        vec![
            ("trial", "int64 NAME", Values::Int64(all(vec![1; rows]))),
            ("category", TEXT, Values::Text(vec![Some(category.as_str().into()); rows])),
            ("time_s", "int64 NAME", Values::Int64(all(vec![1; rows]))),
            ("force_n", DOUBLE, Values::Double(all(vec![1.0; rows]))),
        ]
    };
    for (rows, category, field, allowed) in [
        (1_000_000, "leaf".to_owned(), "rows", "at most 4 rows for each byte of the file"),
        (3, "x".repeat(17 << 20), "category", "at most 16777216 bytes"),
        (3, "x".repeat(1001), "category", "at most 1000 bytes"),
    ] {
        write_zstd(&path, &table(rows, category));
        let error = refused(read_trials(&path));
        assert_eq!(error.field, field, "{error}");
        assert!(error.allowed.starts_with(allowed), "{error}");
    }
    write_zstd(&path, &table(1, "x".repeat(1000)));
    assert_eq!(read_trials(&path).unwrap().len(), 1);
}

/// Tests that a text of some megabytes, which every row of a dictionary repeats, is not decoded for many rows at once.
#[test]
fn a_long_text_is_refused_before_it_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    let rows = 100;
    let columns: Vec<Foreign> = vec![
        ("trial", "int64 NAME", Values::Int64(all(vec![1; rows]))),
        ("category", TEXT, Values::Text(vec![Some("x".repeat(12 << 20).as_str().into()); rows])),
        ("time_s", "int64 NAME", Values::Int64(all(0..rows as i64))),
        ("force_n", DOUBLE, Values::Double(all(vec![1.0; rows]))),
    ];
    write_zstd(&path, &columns);
    let error = refused(read_trials(&path));
    assert!(error.allowed.starts_with("at most 1000 bytes"), "{error}");
}
