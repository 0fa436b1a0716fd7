//! `underbrush benchmark`.

use std::fs;
use std::path::Path;

use crate::support::fixture::fixture;
use crate::support::underbrush;

/// The frozen scenes as files.
const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benchmarks/incidental-contact-1/scenes");

/// Pins that a row is the same to the byte at any number of threads and from parts that were made elsewhere, that it is what
/// `--json` prints, and that the scenes beside the benchmark's description are those that the program has built in.
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
        underbrush![
            "generate",
            scene,
            "--reaches",
            "2",
            "--seed",
            "910002",
            "--shard",
            part,
            "--out",
            out
        ]
        .success();
    }
    let merged = parts.join("quick-sets/reaching-cody-2013");
    fs::create_dir_all(merged.parent().unwrap()).unwrap();
    underbrush![
        "merge",
        folder.path().join("1-2"),
        folder.path().join("2-2"),
        "--out",
        merged
    ]
    .success();
    let before = fs::metadata(merged.join("meta/info.json")).unwrap().modified().unwrap();
    for (out, jobs) in [(&two, "2"), (&parts, "2")] {
        let text = underbrush![
            "benchmark",
            "reaching",
            "--controller",
            "cody-2013",
            "--quick",
            "--jobs",
            jobs,
            "--out",
            out
        ]
        .success();
        assert!(text.contains("a quick run that is no row of the table"), "{text}");
    }
    let row = |out: &Path| fs::read(out.join("quick-rows/reaching-cody-2013.json")).unwrap();
    assert!(row(&one) == row(&two) && row(&one) == row(&parts));
    assert_eq!(
        serde_json::from_slice::<serde_json::Value>(&row(&one)).unwrap(),
        printed
    );
    let after = fs::metadata(merged.join("meta/info.json")).unwrap().modified().unwrap();
    assert_eq!(before, after, "the set was made again");
    // The same share by another way.
    let goals = underbrush!["inspect", merged, "--json"].json();
    let reached = goals["goals"]["reached"].as_f64().unwrap();
    let all = printed["figures"]["reaching"]["goals"].as_f64().unwrap();
    assert_eq!(printed["figures"]["reaching"]["reached"]["value"], reached / all);
    assert_eq!(printed["complete"], false);
}

/// Pins that the accuracy at the end of contacts is that of `evaluate` on the same set, for a model of trials and an arm with
/// another skin, and that the numbers of contacts are those of its trials.
#[test]
fn accuracies_at_the_end_are_those_of_whole_trials() {
    let folder = tempfile::tempdir().unwrap();
    let [model, out] = ["bayes.json", "out"].map(|name| folder.path().join(name));
    underbrush![
        "train",
        fixture().dataset(),
        "--classifier",
        "naive-bayes",
        "--out",
        model
    ]
    .success();
    let row = underbrush![
        "benchmark",
        "transfer",
        "--model",
        model,
        "--quick",
        "--json",
        "--out",
        out
    ]
    .json();
    let set = out.join("quick-sets/transfer-other-arm");
    let evaluated = underbrush!["evaluate", set, "--model", model, "--json"].json();
    let settings = row["figures"]["transfer"]["settings"].as_array().unwrap();
    let other_arm = settings.iter().find(|setting| setting["scene"] == "other-arm").unwrap();
    for (place, category) in evaluated["categories"].as_array().unwrap().iter().enumerate() {
        assert_eq!(other_arm["contacts"][place], category["trials"], "{category}");
    }
    let [ours, theirs] = [&other_arm["leaf_or_trunk"]["value"], &evaluated["balanced_accuracy"]];
    assert!(
        (ours.as_f64().unwrap() - theirs.as_f64().unwrap()).abs() < 1e-12,
        "{ours} {theirs}"
    );
    assert!(ours.as_f64().unwrap() > 0.5);
}

/// Pins that what does not go with a track is refused, and that the message says what to give.
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
