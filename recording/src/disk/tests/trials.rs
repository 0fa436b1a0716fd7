use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow_array::types::Int8Type;
use arrow_array::{
    ArrayRef, DictionaryArray, Float32Array, Float64Array, Int16Array, LargeStringArray, NullArray, RecordBatch,
    StringArray, UInt8Array,
};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::properties::WriterProperties;
use proptest::prelude::*;

use super::Change;
use crate::disk::{DiskError, read_trials, write_trials};
use crate::limits::{self, Limits};
use crate::{InputError, Region, Sample, Trial};

/// Any number within these limits, including extreme ones.
fn within(limits: Limits) -> impl Strategy<Value = f64> {
    let awkward = [0.0, -0.0, f64::MIN_POSITIVE / 8.0, 0.1, limits.min, limits.max];
    let awkward: Vec<f64> = awkward.into_iter().filter(|value| limits.hold(*value)).collect();
    prop_oneof![
        3 => limits.min..limits.max,
        1 => prop::sample::select(awkward),
    ]
}

fn any_region() -> impl Strategy<Value = Region> {
    (1..=65_536u32, within(limits::REGION_LARGEST_FORCE_N), 0.0..1.0f64).prop_map(|(taxels, largest, share)| Region {
        taxels,
        largest_force_n: largest,
        force_sum_n: (largest * (1.0 + share * f64::from(taxels - 1))).min(limits::REGION_FORCE_SUM_N.max),
    })
}

fn any_trials() -> impl Strategy<Value = Vec<Trial>> {
    let felt = (
        within(limits::FORCE_N),
        prop::option::of(within(limits::MOTION_M)),
        prop::option::of(any_region()),
        prop::option::of(any::<bool>()),
    );
    let samples = prop::collection::btree_map(-1_000_000..1_000_000i32, felt, 1..9);
    type Felt = (f64, Option<f64>, Option<Region>, Option<bool>);
    let sample = |(time, (force_n, motion_m, region, touched)): (i32, Felt)| Sample {
        time_s: f64::from(time) * 0.01,
        force_n,
        motion_m,
        region,
        touched,
    };
    let name = || prop::option::of("\\PC{1,8}");
    let facts = (
        name(),
        prop::option::of(any::<u64>()),
        name(),
        prop::option::of(any::<u32>()),
    );
    prop::collection::btree_map(any::<u64>(), (facts, samples), 1..9).prop_map(move |trials| {
        let trial = move |(trial, ((category, reach, patch, taxel), samples))| {
            let samples: std::collections::BTreeMap<_, _> = samples;
            Trial {
                trial,
                category,
                reach,
                patch,
                taxel,
                samples: samples.into_iter().map(sample).collect(),
            }
        };
        // Largest number first, because the order of the rows counts, not that of the numbers.
        trials.into_iter().rev().map(trial).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Pins that reading gives back what was written, down to the sign of a zero, and with quotes and line breaks in
    /// names.
    #[test]
    fn any_trials_come_back_from_both_formats(trials in any_trials()) {
        let folder = tempfile::tempdir().unwrap();
        for name in ["trials.csv", "trials.parquet", "TRIALS.CSV"] {
            let path = folder.path().join(name);
            write_trials(&path, trials.clone()).unwrap();
            prop_assert_eq!(format!("{:?}", read_trials(&path).unwrap()), format!("{trials:?}"));
        }
    }

    #[test]
    fn no_text_panics_the_reader(text in "(trial,time_s,force_n\n)?([0-9.,\"\n\r-]|\\PC){0,60}") {
        // Pins that any text is either a table or an error.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trials.csv");
        fs::write(&path, text).unwrap();
        if let Ok(trials) = read_trials(&path) {
            prop_assert!(trials.iter().all(|trial| !trial.samples.is_empty()));
        }
    }
}

/// Pins how other programs may write truth values, that `touched` is unknown in a table without them, that one sample
/// in contact makes a trial touched, and that a trial with gaps is not untouched.
#[test]
fn touched_is_true_or_false_or_unknown() {
    let touched = |text: &str| -> Vec<Option<bool>> {
        let trials = read_text(text).unwrap();
        trials.iter().map(Trial::touched).collect()
    };
    assert_eq!(touched("trial,time_s,force_n\n1,0.0,0.1\n"), [None]);
    let head = "trial,time_s,force_n,touched\n";
    let rows = "1,0.0,0.1,true\n2,0.0,0.1,FALSE\n3,0.0,0.1,1.0\n4,0.0,0.1,0\n5,0.0,0.1,\n";
    let expected = [Some(true), Some(false), Some(true), Some(false), None];
    assert_eq!(touched(&format!("{head}{rows}")), expected);
    let rows = "1,0.0,0.1,false\n1,0.1,0.1,true\n1,0.2,0.1,\n2,0.0,0.1,false\n2,0.1,0.1,\n";
    assert_eq!(touched(&format!("{head}{rows}")), [Some(true), None]);
    for wrong in ["maybe", "2", "0.5", "-1", "NaN"] {
        let error = refused(read_text(&format!("{head}1,0.0,0.1,true\n1,0.1,0.1,{wrong}\n")));
        assert_eq!((error.line, error.field.as_str()), (Some(3), "touched"), "{wrong}");
    }
}

/// Pins the same for Parquet: truth values, numbers, and a column without values.
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

fn read_text(text: &str) -> Result<Vec<Trial>, DiskError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.csv");
    fs::write(&path, text).unwrap();
    read_trials(&path)
}

fn refused(result: Result<Vec<Trial>, DiskError>) -> InputError {
    match result {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Pins that tables are read with columns in any order, unknown columns, interleaved trials, and integers as pandas
/// writes them in columns with gaps.
#[test]
fn a_table_of_another_hand_is_understood() {
    let text = "\u{feff}note,force_n,time_s,trial,taxel,motion_m\r\n\
                x,0.5,0.00,7,3.0,\r\n\
                y,1e-1, 0.50,2,,0.002\r\n\
                \"z,z\",-0.7,0.01,7.0,3,\r\n";
    let trial = |trial, taxel, samples| Trial {
        trial,
        category: None,
        reach: None,
        patch: None,
        taxel,
        samples,
    };
    let sample = |time_s, force_n, motion_m| Sample {
        time_s,
        force_n,
        motion_m,
        region: None,
        touched: None,
    };
    let expected = vec![
        trial(7, Some(3), vec![sample(0.0, 0.5, None), sample(0.01, -0.7, None)]),
        trial(2, None, vec![sample(0.5, 0.1, Some(0.002))]),
    ];
    assert_eq!(read_text(text).unwrap(), expected);
}

/// Pins that each row has all three columns of a region or none, and that the missing one is named with its line.
#[test]
fn a_region_is_whole_or_absent() {
    let head = "trial,time_s,force_n,region_taxels,region_largest_force_n,region_force_sum_n\n1,0.0,0.1,,,\n";
    let trials = read_text(&format!("{head}1,0.01,0.5,3,1.5,2.25\n")).unwrap();
    let regions: Vec<_> = trials[0].samples.iter().map(|sample| sample.region).collect();
    let region = Region {
        taxels: 3,
        largest_force_n: 1.5,
        force_sum_n: 2.25,
    };
    assert_eq!(regions, [None, Some(region)]);
    let error = refused(read_text(&format!("{head}1,0.01,0.5,3,,2.25\n")));
    assert_eq!((error.line, error.field.as_str()), (Some(3), "region_largest_force_n"));
}

/// Pins the line and column of each kind of fault.
#[test]
fn every_fault_of_a_csv_table_is_named_with_its_line() {
    let head = "trial,category,reach,taxel,time_s,force_n\n1,leaf,0,5,0.0,0.1\n";
    for (rest, line, field) in [
        ("1,leaf,0,5,0.01,NaN\n", 3, "force_n"),
        ("1,leaf,0,5,inf,0.1\n", 3, "time_s"),
        ("1,leaf,0,5,0.01,\n", 3, "force_n"),
        ("1,leaf,0,5,0.01,strong\n", 3, "force_n"),
        (",leaf,0,5,0.01,0.1\n", 3, "trial"),
        ("1.5,leaf,0,5,0.01,0.1\n", 3, "trial"),
        ("-1,leaf,0,5,0.01,0.1\n", 3, "trial"),
        ("2,leaf,0,4294967296,0.0,0.1\n", 3, "taxel"),
        ("2,leaf,0,5,0.0,0.1\n1,trunk,0,5,0.01,0.1\n", 4, "category"),
        ("1,,0,5,0.01,0.1\n", 3, "category"),
        ("1,leaf,1,5,0.01,0.1\n", 3, "reach"),
        ("1,leaf,0,6,0.01,0.1\n", 3, "taxel"),
        ("2,leaf,0,5,0.5,0.1\n1,leaf,0,5,0.0,0.1\n", 4, "time_s"),
        ("1,leaf,0,5,0.01\n", 3, "row"),
    ] {
        let error = refused(read_text(&format!("{head}{rest}")));
        assert_eq!(
            (error.line, error.field.as_str()),
            (Some(line), field),
            "{rest}: {error}"
        );
    }
    for (text, field) in [
        ("", "trial"),
        ("trial,time_s,force\n1,0,0\n", "force_n"),
        ("trial,time_s,force_n,time_s\n1,0,0,0\n", "time_s"),
        ("trial,time_s,force_n\n", "rows"),
    ] {
        let error = refused(read_text(text));
        assert_eq!(error.field, field, "{text}: {error}");
        assert!(!error.remedy.is_empty());
    }
}

/// Pins that blank lines, line breaks in quotes and Windows line ends do not shift the line number of a fault, both
/// in cells and in errors of the CSV parser.
#[test]
fn blank_lines_do_not_shift_the_line_of_a_fault() {
    let head = "trial,category,time_s,force_n\n";
    for (rest, line) in [
        ("\n\n1,leaf,0.0,NaN\n", 4),
        ("1,leaf,0.0,0.1\n\n\n1,leaf,0.01,NaN\n", 5),
        ("1,leaf,0.0,0.1\n\n\n\n1,leaf,0.01\n", 6),
        ("1,\"le\naf\",0.0,0.1\n\n1,\"le\naf\",0.01,NaN\n", 5),
        ("1,leaf,0.0,0.1\n\n1,leaf,0.0,0.2\n", 4),
        ("1,leaf,0.0,0.1\n1,leaf,0.01,NaN", 3),
    ] {
        for text in [format!("{head}{rest}"), format!("\n{head}{rest}").replace('\n', "\r\n")] {
            let line = line + usize::from(text.starts_with('\r'));
            let error = refused(read_text(&text));
            assert_eq!(error.line, Some(line), "{text:?}: {error}");
        }
    }
}

/// Pins that numbers that no sensor can report are refused with line and column, and that both ends of each range are
/// read.
#[test]
fn numbers_out_of_range_are_refused() {
    let columns = "trial,time_s,force_n,motion_m,region_taxels,region_largest_force_n,region_force_sum_n";
    let sound = ["1", "0.0", "0.5", "0.001", "3", "1.5", "2.25"];
    let names: Vec<&str> = columns.split(',').collect();
    let read = |column: usize, cell: &str| {
        let mut row = sound;
        row[column] = cell;
        read_text(&format!("{columns}\n{}\n", row.join(",")))
    };
    for (column, name) in names.iter().enumerate() {
        for cell in [
            "NaN", "inf", "-inf", "1e300", "-1e300", "-1e30", "1e308", "1e30", "-5", "much",
        ] {
            if (*name, cell) == ("time_s", "-5") {
                continue;
            }
            let error = refused(read(column, cell));
            assert_eq!((error.line, error.field.as_str()), (Some(2), *name), "{cell}: {error}");
            assert!(error.to_string().len() < 300, "{error}");
        }
    }
    for (column, cell, field) in [
        (4, "0", "region_taxels"),
        (4, "100000", "region_taxels"),
        (6, "1.4", "region_force_sum_n"),
        (6, "4.6", "region_force_sum_n"),
    ] {
        assert_eq!(refused(read(column, cell)).field, field, "{cell}");
    }
    for (column, cell) in [
        (1, "-1e10"),
        (1, "1e10"),
        (1, "1e-300"),
        (2, "-1"),
        (2, "10000"),
        (3, "-0.01"),
        (3, "1000"),
        (6, "1.5"),
        (6, "4.5"),
    ] {
        assert!(read(column, cell).is_ok(), "{cell} in {}", names[column]);
    }
}

/// Pins that the file's extension alone decides its format, and that a missing file is bad input.
#[test]
fn other_extensions_and_absent_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(
        refused(read_trials(folder.path().join("trials.xlsx"))).field,
        "file name"
    );
    let written = write_trials(folder.path().join("trials"), []);
    assert!(matches!(written, Err(DiskError::Input(error)) if error.field == "file name"));
    for name in ["absent.csv", "absent.parquet"] {
        assert_eq!(refused(read_trials(folder.path().join(name))).found, "no such file");
    }
}

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

/// Pins that each rule for tables of trials is checked before the file appears.
#[test]
fn trials_that_could_not_be_read_back_are_not_written() {
    let sample = Sample {
        time_s: 0.0,
        force_n: 1.0,
        motion_m: None,
        region: None,
        touched: None,
    };
    let good = Trial {
        trial: 1,
        category: Some("leaf".into()),
        reach: None,
        patch: None,
        taxel: None,
        samples: vec![sample],
    };
    let changes: [Change<Trial>; 8] = [
        ("trial 1, trial", |trial| trial.trial = 1),
        ("trial 2, category", |trial| trial.category = Some(String::new())),
        ("trial 2, samples", |trial| trial.samples.clear()),
        ("trial 2, motion_m", |trial| {
            trial.samples[0].motion_m = Some(f64::INFINITY)
        }),
        ("trial 2, force_n", |trial| trial.samples[0].force_n = -5.0),
        ("trial 2, time_s", |trial| trial.samples[0].time_s = 1e300),
        ("trial 2, region_force_sum_n", |trial| {
            trial.samples[0].region = Some(Region {
                taxels: 2,
                largest_force_n: 1.0,
                force_sum_n: 0.5,
            });
        }),
        ("trial 2, time_s", |trial| trial.samples.push(trial.samples[0])),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (expected, change) in changes {
        let mut bad = Trial {
            trial: 2,
            ..good.clone()
        };
        change(&mut bad);
        for name in ["trials.csv", "trials.parquet"] {
            let path = folder.path().join(name);
            match write_trials(&path, [good.clone(), bad.clone()]) {
                Err(DiskError::Unwritable { field, .. }) => assert_eq!(field, expected),
                other => panic!("{expected}: {other:?}"),
            }
            assert_eq!(
                fs::read_dir(folder.path()).unwrap().count(),
                0,
                "nothing is left behind"
            );
        }
    }
}
