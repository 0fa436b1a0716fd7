//! `underbrush benchmark`.

use std::fs;
use std::path::Path;

use serde_json::Value;

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
        underbrush!["generate", scene, "--reaches", "2", "--seed", "910022", "--shard", part, "--out", out].success();
    }
    let merged = parts.join("quick-sets/reaching-public-cody-2013");
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
    let public = &printed["figures"]["reaching"]["public"];
    assert_eq!(public["reached"]["value"], reached / public["goals"].as_f64().unwrap());
    assert_eq!(printed["complete"], false);
}

/// Tests that the class "nothing" is fitted for a model without it and not for a touch model, that the audit half has a seed of the
/// model's own, and that the public half has the same objects for all models.
#[test]
fn the_audit_half_is_the_models_own() {
    let folder = tempfile::tempdir().unwrap();
    let [model, out] = ["bayes.json", "out"].map(|name| folder.path().join(name));
    underbrush!["train", fixture().dataset(), "--classifier", "naive-bayes", "--out", model].success();
    let first = underbrush!["benchmark", "verdicts", "--model", model, "--quick", "--json", "--out", out].json();
    let seed = |row: &Value, half: usize| row["sets"][half]["seed"].as_u64().unwrap();
    assert_eq!((seed(&first, 0), seed(&first, 2)), (910_020, 910_023));
    let verdicts = |row: &Value| row["figures"]["verdicts"].clone();
    let fitted_n = verdicts(&first)["public"]["nothing_up_to_n"].as_f64().unwrap();
    assert!((0.03..5.0).contains(&fitted_n), "{fitted_n}");
    let touch = concat!(env!("CARGO_MANIFEST_DIR"), "/suites/touch.json");
    let text = underbrush!["benchmark", "verdicts", "--model", touch, "--quick", "--out", out].success();
    assert!(text.contains("The public and the audit half"), "{text}");
    let row: Value = serde_json::from_slice(&fs::read(out.join("quick-rows/verdicts-touch.json")).unwrap()).unwrap();
    assert!(verdicts(&row)["public"]["nothing_up_to_n"].is_null() && row["sets"][2].is_null());
    assert!(seed(&first, 1) >= 1 << 52 && seed(&first, 1) != seed(&row, 1) && seed(&row, 0) == 910_020);
    // The same public objects are judged, whatever the model.
    for patch in ["forearm", "flipper"] {
        let objects = [&first, &row].map(|row| verdicts(row)["public"][patch]["objects"].clone());
        assert!(objects[0] == objects[1] && objects[0].is_array(), "{patch}: {objects:?}");
    }
}

/// Tests that options that do not belong to a track are refused, and that the message names the option that is needed.
#[test]
fn what_does_not_go_with_a_track_is_refused() {
    let remedy = "give a model for verdicts and transfer, a controller for reaching";
    let allowed = "allowed: verdicts or transfer with a model, reaching with a controller";
    underbrush!["benchmark", "verdicts"].refused(&["verdicts\" with no model and no controller", allowed, remedy]);
    underbrush!["benchmark", "transfer", "--controller", "blind"].refused(&["with no model and a controller", remedy]);
    underbrush!["benchmark", "reaching", "--model", "touch.json"].refused(&["with a model and no controller", remedy]);
    underbrush!["benchmark", "reaching", "--verdicts", "touch.json"].refused(&["--controller <NAME>"]);
    underbrush!["benchmark", "speed"].refused(&["verdicts, transfer, reaching"]);
    underbrush!["benchmark", "reaching", "--controller", "cody-2013", "--verdicts", "truth"]
        .refused(&["verdicts", "truth"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("touch.json");
    fs::write(&path, "{}").unwrap();
    underbrush!["benchmark", "verdicts", "--model", path].refused(&["touch.json", "format"]);
}
