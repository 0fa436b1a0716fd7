//! `underbrush benchmark`.

use std::fs;
use std::path::Path;

use crate::support::fixture::fixture;
use crate::support::underbrush;

/// The frozen scenes as files.
const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benchmarks/incidental-contact-1/scenes");

/// Tests that a row is the same, byte for byte, for any number of threads and from parts that were made elsewhere, that
/// `--json` prints this row, and that the scene files beside the benchmark's description are the ones built into the
/// program.
#[test]
fn a_row_does_not_depend_on_who_made_the_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two, parts] = ["one", "two", "parts"].map(|name| folder.path().join(name));
    let printed = underbrush![
        "benchmark",
        "reaching",
        "--controller",
        "cody-2013",
        "--quick",
        "--jobs",
        "1",
        "--json",
        "--out",
        one
    ]
    .json();
    let scene = Path::new(SCENES).join("mixed.toml");
    for part in ["1/2", "2/2"] {
        let out = folder.path().join(part.replace('/', "-"));
        underbrush!["generate", scene, "--reaches", "2", "--seed", "910002", "--shard", part, "--out", out].success();
    }
    let merged = parts.join("quick-sets/reaching-cody-2013");
    fs::create_dir_all(merged.parent().unwrap()).unwrap();
    underbrush!["merge", folder.path().join("1-2"), folder.path().join("2-2"), "--out", merged].success();
    let before = fs::metadata(merged.join("meta/info.json")).unwrap().modified().unwrap();
    for (out, jobs) in [(&two, "2"), (&parts, "2")] {
        let text =
            underbrush!["benchmark", "reaching", "--controller", "cody-2013", "--quick", "--jobs", jobs, "--out", out]
                .success();
        assert!(text.contains("a quick run that is no row of the table"), "{text}");
    }
    let row = |out: &Path| fs::read(out.join("quick-rows/reaching-cody-2013.json")).unwrap();
    assert!(row(&one) == row(&two) && row(&one) == row(&parts));
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&row(&one)).unwrap(), printed);
    let after = fs::metadata(merged.join("meta/info.json")).unwrap().modified().unwrap();
    assert_eq!(before, after, "the set was made again");
    // The share of goals reached, computed from what `inspect` prints.
    let goals = underbrush!["inspect", merged, "--json"].json();
    let reached = goals["goals"]["reached"].as_f64().unwrap();
    let all = printed["figures"]["reaching"]["goals"].as_f64().unwrap();
    assert_eq!(printed["figures"]["reaching"]["reached"]["value"], reached / all);
    assert_eq!(printed["complete"], false);
}

/// Tests that the accuracy after one sample equals the accuracy that `evaluate` finds on trials cut to one sample, and
/// that there are as many contacts as such trials.
#[test]
fn accuracies_after_one_sample_are_those_of_trials_of_one_sample() {
    let folder = tempfile::tempdir().unwrap();
    let [model, out, table, cut] = ["bayes.json", "out", "trials.csv", "cut.csv"].map(|name| folder.path().join(name));
    underbrush!["train", fixture().dataset(), "--classifier", "naive-bayes", "--out", model].success();
    let row = underbrush!["benchmark", "verdicts", "--model", model, "--quick", "--json", "--out", out].json();
    underbrush!["trials", out.join("quick-sets/verdicts"), "--out", table].success();
    let text = fs::read_to_string(table).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    let column = header.split(',').position(|name| name == "trial").unwrap();
    let mut first_lines = vec![header];
    let mut last = None;
    for line in lines {
        let trial = line.split(',').nth(column);
        if trial != last {
            first_lines.push(line);
        }
        last = trial;
    }
    fs::write(&cut, first_lines.join("\n")).unwrap();
    let evaluated = underbrush!["evaluate", cut, "--model", model, "--json"].json();
    let verdicts = &row["figures"]["verdicts"];
    let mut recalls = Vec::new();
    for category in evaluated["categories"].as_array().unwrap() {
        let Some(name) = category["category"].as_str().filter(|name| ["leaf", "trunk"].contains(name)) else {
            continue;
        };
        assert_eq!(verdicts["contacts"][name], category["trials"], "{category}");
        recalls.push(category["recall"].as_f64().unwrap());
    }
    let ours = verdicts["moments"][0]["leaf_or_trunk"]["value"].as_f64().unwrap();
    assert_eq!((verdicts["moments"][0]["samples"].as_u64(), recalls.len()), (Some(1), 2));
    let theirs = (recalls[0] + recalls[1]) / 2.0;
    assert!((ours - theirs).abs() < 1e-12, "{ours} {theirs}");
    // The last moment is the end of the contacts.
    assert!(verdicts["moments"][9]["samples"].is_null());
}

/// Tests that options that do not belong to a track are refused, and that the message names the option that is needed.
#[test]
fn what_does_not_go_with_a_track_is_refused() {
    underbrush!["benchmark", "verdicts"].refused(&["--model <MODEL>"]);
    underbrush!["benchmark", "transfer", "--controller", "blind"].refused(&["--model <MODEL>"]);
    underbrush!["benchmark", "reaching", "--model", "touch.json"].refused(&["--controller <NAME>"]);
    underbrush!["benchmark", "reaching", "--verdicts", "touch.json"].refused(&["--controller <NAME>"]);
    underbrush!["benchmark", "speed"].refused(&["verdicts, transfer, reaching"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("touch.json");
    fs::write(&path, "{}").unwrap();
    underbrush!["benchmark", "verdicts", "--model", path].refused(&["touch.json", "format"]);
}
