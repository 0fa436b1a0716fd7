//! CSV files, and mappings.

use std::path::Path;

use underbrush_recording::Trial;

use super::super::{Imported, Mapping};
use super::{file, imported, refused, samples, written};

const LOG: &str = "\
run, stamp, left, ft_0, ft_1, label
0, 1000, x, 0, 500, leaf
0, 1010, x, 250, 500, leaf
0, 1020, x, 250, 0, leaf
0, 1030, x, 0, 125, leaf

1, 1000, x, 0, 125, trunk
1, 1010, x, 40, 125, trunk
";

const MAPPING: &str = "\
[time]
from = \"stamp\"
unit = \"ms\"
[force]
from = \"ft_{taxel}\"
taxels = 2
unit = \"mN\"
[trial]
patch = \"palm\"
threshold_n = 0.1
category_from = \"label\"
reach_from = \"run\"
";

/// Tests how rows of a CSV file become trials: a trial lasts while the force is above the threshold, units are
/// converted, and a new reach ends all contacts.
#[test]
fn rows_become_trials() {
    let (_folder, path) = file("log.csv");
    written(&path, LOG);
    let Imported { trials, frames, reaches, .. } = imported(&path, MAPPING).unwrap();
    assert_eq!((frames, reaches), (6, 2));
    let facts: Vec<_> = trials
        .iter()
        .map(|trial| (trial.trial, trial.reach.unwrap(), trial.taxel.unwrap(), trial.category.as_deref().unwrap()))
        .collect();
    assert_eq!(facts, [(0, 0, 1, "leaf"), (1, 0, 0, "leaf"), (2, 0, 1, "leaf"), (3, 1, 1, "trunk")]);
    assert!(trials.iter().all(|trial| trial.patch.as_deref() == Some("palm")));
    assert_eq!(samples(&trials[0]), [(1.0, 0.5), (1.01, 0.5)]);
    assert_eq!(samples(&trials[1]), [(1.01, 0.25), (1.02, 0.25)]);
    assert_eq!(samples(&trials[2]), [(1.03, 0.125)]);
    assert_eq!(samples(&trials[3]), [(1.0, 0.125), (1.01, 0.125)]);
    let sample = &trials[0].samples[0];
    assert_eq!((sample.motion_m, sample.region, sample.touched), (None, None, None));

    let longer = MAPPING.replace("threshold_n = 0.1", "threshold_n = 0.03\nmin_samples = 2");
    let taxels =
        |trials: &[Trial]| trials.iter().map(|trial| (trial.taxel.unwrap(), trial.samples.len())).collect::<Vec<_>>();
    assert_eq!(taxels(&imported(&path, &longer).unwrap().trials), [(1, 2), (0, 2), (1, 2)]);
}

/// Tests that a category that could be mistaken for the verdict `uncertain` is refused with its place.
#[test]
fn a_category_called_uncertain_is_refused() {
    let (_folder, path) = file("log.csv");
    written(&path, &LOG.replace("trunk", "uncertain"));
    let error = refused(&path, MAPPING);
    assert_eq!((error.field.as_str(), error.found.as_str()), ("category", "\"uncertain\""));
    assert!(error.line.is_some() && error.allowed.contains("which is a verdict"), "{error}");
}

/// Tests that scale and offset are applied to raw readings, that times may follow from a rate, and that one taxel needs
/// no placeholder.
#[test]
fn raw_readings_are_scaled() {
    let (_folder, path) = file("log.csv");
    written(&path, "adc\n512\n600\n700\n512\n");
    let mapping = "[time]\nrate_hz = 50\n[force]\nfrom = \"adc\"\nscale_n = 0.01\noffset_n = -5.12\n[trial]\ncategory = \"leaf\"\n";
    let trials = imported(&path, mapping).unwrap().trials;
    assert_eq!(trials.len(), 1);
    let [first, second] = samples(&trials[0])[..] else { panic!("{trials:?}") };
    assert_eq!((first.0, second.0), (0.02, 0.04));
    assert!((first.1 - 0.88).abs() < 1e-12 && (second.1 - 1.88).abs() < 1e-12, "{first:?} {second:?}");
    assert_eq!((trials[0].category.as_deref(), trials[0].reach), (Some("leaf"), Some(0)));
}

/// Tests that a wrong mapping is refused with its line and field, and with what is allowed.
#[test]
fn a_wrong_mapping_is_refused_by_line_and_field() {
    let (_folder, path) = file("log.csv");
    written(&path, LOG);
    let long = format!("patch = \"{}\"", "p".repeat(1001));
    let changes: [(&str, &str, usize, &str, &str); 15] = [
        ("unit = \"mN\"", "unit = \"N/m\"", 7, "force.unit", "N, mN, kN, gf, kgf, lbf"),
        ("unit = \"ms\"", "unit = \"min\"", 3, "time.unit", "s, ms, us, ns"),
        ("from = \"stamp\"", "from = \"t\"", 2, "time.from", "run, stamp, left, ft_0, ft_1, label"),
        ("from = \"stamp\"", "rate_hz = 0", 2, "time.rate_hz", "0.01 to 100000 Hz"),
        ("from = \"stamp\"", "rate_hz = 100", 3, "time.unit", "one of"),
        ("from = \"stamp\"", "", 1, "time.from", "or `rate_hz`"),
        ("taxels = 2", "taxels = 3", 5, "force.from", "a column of"),
        ("taxels = 2", "", 4, "force.taxels", "`taxels = N`"),
        ("ft_{taxel}", "ft_0", 5, "force.from", "{taxel}"),
        ("threshold_n = 0.1", "threshold_n = -1", 10, "trial.threshold_n", "0 to 10000 N"),
        ("threshold_n = 0.1", "treshold_n = 1", 10, "mapping, trial.treshold_n", "underbrush schema mapping"),
        ("patch = \"palm\"", "category = \"leaf\"", 11, "trial.category_from", "one of"),
        ("patch = \"palm\"", "patch = \"left/palm\"", 9, "trial.patch", "a name without `/`"),
        ("patch = \"palm\"", "patch = \"\\u001b\"", 9, "trial.patch", "control characters"),
        ("patch = \"palm\"", &long, 9, "trial.patch", "1 to 1000 bytes"),
    ];
    for (before, after, line, field, allowed) in changes {
        assert!(MAPPING.contains(before));
        let error = refused(&path, &MAPPING.replace(before, after));
        assert_eq!((error.line, error.field.as_str()), (Some(line), field), "{error}");
        assert!(error.file.ends_with("log.toml") && error.allowed.contains(allowed), "{error}");
    }
    // What the whole file lacks is in none of its tables.
    let error = refused(&path, "[time]\nrate_hz = 100\n");
    assert_eq!((error.line, error.field.as_str()), (None, "mapping"), "{error}");
    assert_eq!(error.found, "missing field `force`");
    let nowhere = Mapping::load(Path::new("nowhere.toml"));
    assert!(matches!(nowhere, Err(error) if error.found == "no such file"));
}

/// Tests that columns of taxels that are numbered from 1 are refused, and two columns of one name.
#[test]
fn columns_of_taxels_are_numbered_from_0() {
    let (_folder, path) = file("log.csv");
    for (columns, found) in [("ft_1, ft_2", "which is no column"), ("ft_0, ft_0", "which two columns have")] {
        written(&path, &LOG.replace("ft_0, ft_1", columns));
        let error = refused(&path, MAPPING);
        assert!(error.field == "force.from" && error.found.ends_with(found), "{error}");
    }
}

/// Tests that wrong cells, times that do not rise, forces out of range and rows of a reach that are not adjacent are
/// refused with the line of the file, and that a file without a contact is refused, too.
#[test]
fn wrong_data_are_refused_by_line() {
    let (_folder, path) = file("log.csv");
    let changes: [(&str, &str, usize, &str, &str); 6] = [
        ("1020, x, 250", "1020, x, ", 4, "ft_0", "a number"),
        ("1020, x, 250", "1020, x, NaN", 4, "force of taxel 0", "-1 to 10000 N"),
        ("0, 1020", "0, 1010", 4, "time", "more than 1.01"),
        ("1, 1000", "-1, 1000", 7, "run", "a whole number"),
        ("40, 125", "4e9, 125", 8, "force of taxel 0", "-1 to 10000 N"),
        ("0, 1030, x, 0, 125, leaf", "0, 1030", 5, "CSV", "6 cells, as in the header"),
    ];
    for (before, after, line, field, allowed) in changes {
        assert!(LOG.contains(before));
        written(&path, &LOG.replace(before, after));
        let error = refused(&path, MAPPING);
        assert_eq!((error.line, error.field.as_str()), (Some(line), field), "{error}");
        assert!(error.file == path && error.allowed.contains(allowed), "{error}");
    }
    written(&path, &format!("{LOG}0, 1040, x, 0, 125, leaf\n"));
    let error = refused(&path, MAPPING);
    assert_eq!((error.line, error.field.as_str()), (Some(9), "reach"), "{error}");
    assert!(error.found.contains("ended before"), "{error}");
    written(&path, LOG);
    let error = refused(&path, &MAPPING.replace("threshold_n = 0.1", "threshold_n = 0.5"));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("trials", "none in 6 frames"));
    let (_other, text) = file("log.txt");
    written(&text, LOG);
    assert_eq!(refused(&text, MAPPING).field, "file name");
}

/// Tests that an empty log, one without commas, and a header alone are refused as such.
#[test]
fn a_log_without_commas_or_rows_is_refused() {
    let (_folder, path) = file("log.csv");
    for (text, found, allowed) in [
        ("", "\"f0\", which is no column", "a column of"),
        ("time;f0\n0;1\n", "\"f0\", which is no column", "log.csv: time;f0"),
        ("time,f0\n", "a header without rows", "a row for each frame"),
    ] {
        written(&path, text);
        let error = refused(&path, "[time]\nfrom = \"time\"\n[force]\nfrom = \"f0\"\n");
        assert!(error.found.starts_with(found) && error.allowed.contains(allowed), "{error}");
    }
}

/// Tests that comments above the header are passed over and rows keep their numbers, that the name of the first column may begin
/// with `#`, and that a header which is missing or a comment is missed.
#[test]
fn comments_above_the_header_are_passed_over() {
    let (_folder, path) = file("log.csv");
    for comments in ["# palm, left\n", "\u{feff}# a\r\n\r\n# b,\"c\n", "#\n#,\"\n"] {
        written(&path, &format!("{comments}{LOG}"));
        assert_eq!(imported(&path, MAPPING).unwrap().frames, 6, "{comments:?}");
        written(&path, &format!("{comments}{}", LOG.replace("40, 125", "4,5, 125")));
        assert_eq!(refused(&path, MAPPING).line, Some(8 + comments.matches('\n').count()), "{comments:?}");
    }
    written(&path, &LOG.replacen("run", "#", 1));
    assert_eq!(imported(&path, &MAPPING.replace("\"run\"", "\"#\"")).unwrap().frames, 6);
    let rows = LOG.split_once('\n').unwrap().1;
    for text in [format!("# {LOG}"), rows.to_owned()] {
        written(&path, &text);
        let error = refused(&path, MAPPING);
        assert!(error.found.starts_with("\"ft_0\"") && error.allowed.contains(": 0, 1000"), "{error}");
    }
}

/// Tests that reaches may be numbered as programs write them that know only floating point, that a taxel which the mapping leaves
/// out is warned of, and that the remedy for a missing key is to add it.
#[test]
fn what_a_mapping_leaves_out_is_said() {
    let (_folder, path) = file("log.csv");
    written(&path, &LOG.replace("\n0, ", "\n0.0, ").replace("\n1, ", "\n1e0, "));
    let found = imported(&path, &MAPPING.replace("taxels = 2", "taxels = 1")).unwrap();
    assert_eq!(found.reaches, 2);
    assert!(found.warnings[0].contains("\"ft_1\" is left out"), "{:?}", found.warnings);
    assert!(refused(&path, &MAPPING.replace("taxels = 2", "")).remedy.starts_with("add `taxels` to [force] in"));
    written(&path, &LOG.replace("\n0, ", "\n0.5, "));
    assert_eq!(refused(&path, MAPPING).field, "run");
}
