//! Trials in CSV files that others wrote.

use std::fs;

use super::refused;
use crate::disk::{read_trials, write_trials};
use crate::{DiskError, Region, Sample, Trial};

fn read_text(text: &str) -> Result<Vec<Trial>, DiskError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.csv");
    fs::write(&path, text).unwrap();
    read_trials(&path)
}

/// Tests how other programs may write truth values, that `touched` is unknown in a table without them, that one sample
/// in contact makes a trial touched, and that a trial with gaps does not count as untouched.
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

/// Tests that tables are read with columns in any order, unknown columns, interleaved trials, and integers as pandas
/// writes them in columns with gaps.
#[test]
fn a_table_of_another_hand_is_understood() {
    let text = "\u{feff}note,force_n,time_s,trial,taxel,motion_m\r\n\
                x,0.5,0.00,7,3.0,\r\n\
                y,1e-1, 0.50,2,,0.002\r\n\
                \"z,z\",-0.7,0.01,7.0,3,\r\n";
    let trial = |trial, taxel, samples| Trial { trial, category: None, reach: None, patch: None, taxel, samples };
    let sample = |time_s, force_n, motion_m| Sample { time_s, force_n, motion_m, ..Sample::default() };
    let expected = vec![
        trial(7, Some(3), vec![sample(0.0, 0.5, None), sample(0.01, -0.7, None)]),
        trial(2, None, vec![sample(0.5, 0.1, Some(0.002))]),
    ];
    assert_eq!(read_text(text).unwrap(), expected);
}

/// Tests that each row has all three columns of a region or none, and that the missing one is named with its line.
#[test]
fn a_region_is_whole_or_absent() {
    let head = "trial,time_s,force_n,region_taxels,region_largest_force_n,region_force_sum_n\n1,0.0,0.1,,,\n";
    let trials = read_text(&format!("{head}1,0.01,0.5,3,1.5,2.25\n")).unwrap();
    let regions: Vec<_> = trials[0].samples.iter().map(|sample| sample.region).collect();
    let region = Region { taxels: 3, largest_force_n: 1.5, force_sum_n: 2.25 };
    assert_eq!(regions, [None, Some(region)]);
    let error = refused(read_text(&format!("{head}1,0.01,0.5,3,,2.25\n")));
    assert_eq!((error.line, error.field.as_str()), (Some(3), "region_largest_force_n"));
}

/// Tests the line and column of each kind of fault.
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
        assert_eq!((error.line, error.field.as_str()), (Some(line), field), "{rest}: {error}");
    }
    let error = refused(read_text("trial,taxel,time_s,force_n\n1,4294967296,0,0\n"));
    assert_eq!(error.allowed, "a whole number from 0 to 4294967295");
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

/// Tests that a category that could be mistaken for the verdict `uncertain` is refused with line, column and reason,
/// and that an outlier, the other verdict, is a category as well.
#[test]
fn a_category_called_like_a_verdict_is_refused() {
    let head = "trial,category,time_s,force_n\n1,outlier,0.0,0.1\n";
    assert_eq!(read_text(head).unwrap()[0].category.as_deref(), Some("outlier"));
    let error = refused(read_text(&format!("{head}2,uncertain,0.0,0.1\n")));
    assert_eq!((error.line, error.field.as_str()), (Some(3), "category"));
    assert_eq!(error.found, "\"uncertain\"");
    assert!(error.allowed.contains("which is a verdict"), "{error}");
}

/// Tests that names of categories and patches with control characters, line breaks or bidirectional controls are
/// refused, both when they are read and when they are written.
#[test]
fn names_that_change_a_terminal_are_refused() {
    for name in ["le\u{1b}[31maf", "le\u{9b}af", "\u{202e}leaf", "le\naf", "le\taf"] {
        let head = "trial,category,patch,time_s,force_n\n";
        let of_category = refused(read_text(&format!("{head}1,\"{name}\",forearm,0.0,0.1\n")));
        assert_eq!((of_category.line, of_category.field.as_str()), (Some(2), "category"));
        let of_patch = refused(read_text(&format!("{head}1,leaf,\"{name}\",0.0,0.1\n")));
        assert_eq!((of_patch.line, of_patch.field.as_str()), (Some(2), "patch"));
        let mut trial = read_text(&format!("{head}1,leaf,forearm,0.0,0.1\n")).unwrap().remove(0);
        trial.category = Some(name.to_owned());
        let folder = tempfile::tempdir().unwrap();
        let error = write_trials(folder.path().join("t.csv"), &[trial]).unwrap_err().to_string();
        assert!(error.contains("trial 1, category") && error.contains("control characters"), "{error}");
    }
}

/// Tests that blank lines, line breaks in quotes and Windows line ends do not shift the line number of a fault, both
/// in cells and in errors of the CSV parser.
#[test]
fn blank_lines_do_not_shift_the_line_of_a_fault() {
    let head = "trial,category,time_s,force_n\n";
    for (rest, line) in [
        ("\n\n1,leaf,0.0,NaN\n", 4),
        ("1,leaf,0.0,0.1\n\n\n1,leaf,0.01,NaN\n", 5),
        ("1,leaf,0.0,0.1\n\n\n\n1,leaf,0.01\n", 6),
        ("1,leaf,\"0.0\n\",0.1\n\n1,leaf,\"0.01\n\",NaN\n", 5),
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

/// Tests that numbers that no sensor can report are refused with line and column, and that both ends of each range are
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
        for cell in ["NaN", "inf", "-inf", "1e300", "-1e300", "-1e30", "1e308", "1e30", "-5", "much"] {
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

/// Tests that only numbers become channels, and only in columns whose name occurs once.
#[test]
fn other_columns_of_text_are_ignored() {
    let text =
        "trial,time_s,force_n,shear,who,twice,twice\n1,0.0,0.5,0.2,Ann,1,2\n1,0.1,0.5,,Bob,1,2\n1,0.2,0.5,inf,7,1,2\n";
    let trials = read_text(text).unwrap();
    let channels = |index: usize| -> Vec<(String, f64)> {
        trials[0].samples[index].channels.iter().map(|(name, number)| (name.to_string(), number)).collect()
    };
    assert_eq!([channels(0), channels(1)], [vec![("shear".to_owned(), 0.2)], vec![]]);
    assert_eq!(channels(2), [("who".to_owned(), 7.0)]);
}

/// Tests that spaces after commas and at the ends of lines are no part of a cell: they would make a category of their own.
#[test]
fn spaces_around_cells_do_not_count() {
    let text = "trial,category,time_s,force_n,touched\n1,leaf,0.0,0.5,true\n1,leaf,0.1,0.6,true\n2,,0.0,0.4,\n";
    let spaced = text.replace(',', " , ").replace('\n', " \n");
    assert_eq!(read_text(&spaced).unwrap(), read_text(text).unwrap());
}
