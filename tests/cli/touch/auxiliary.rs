//! `train` and `evaluate` with auxiliary sets of unknown objects, and `train` with scene files in place of data sets.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{lines, read};
use crate::support::fixture::fixture;
use crate::support::{call, scenes, underbrush};

/// A scene of posts, which are trunks of another category.
pub fn posts(folder: &Path) -> PathBuf {
    let text = scenes::TRUNKS_AT_FOREARM.replace("count = 6", "count = 6\ncategory = \"post\"\ndiameter_m = 0.06");
    scenes::write(folder, "posts.toml", &text)
}

/// Tests that a model fitted to simulated reaches and auxiliary ones equals that of data sets of the same scenes but for the
/// names of the sets, says where it comes from, leaves no reaches behind, and judges objects, whose counts `evaluate` sums.
#[test]
fn auxiliary_objects_are_a_family() {
    let folder = tempfile::tempdir().unwrap();
    let [out, set, aux, again] = ["model.json", "set", "aux", "again.json"].map(|name| folder.path().join(name));
    let (leaf, trunk, posts) = (fixture().leaf_scene(), fixture().trunk_scene(), posts(folder.path()));
    let touch = ["--classifier", "touch"];
    let [classifier, kind] = touch;
    let trained = underbrush![
        "train",
        leaf,
        trunk,
        classifier,
        kind,
        "--auxiliary",
        posts,
        "--reaches",
        "8",
        "--seed",
        "2",
        "--out",
        out,
        "--json"
    ]
    .json();
    assert_eq!((&trained["families"], &trained["rows"]["auxiliary_reaches"]), (&json!(["post"]), &json!(8)));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");

    underbrush!["generate", leaf, trunk, "--reaches", "8", "--seed", "2", "--out", set].success();
    underbrush!["generate", posts, "--reaches", "8", "--seed", "2", "--out", aux].success();
    underbrush!["train", set, classifier, kind, "--auxiliary", aux, "--out", again].success();
    let [mut one, mut other] = [&out, &again].map(|path| read(path));
    let sources = one["provenance"]["data"].as_array().unwrap().clone();
    assert_eq!(sources[0]["reaches"], json!({ "leaf": 8, "trunk": 8 }));
    assert_eq!((&sources[1]["reaches"], &sources[1]["seed"]), (&json!({ "posts": 8 }), &json!(2)));
    for (own, other) in sources.iter().zip(other["provenance"]["data"].as_array().unwrap()) {
        assert_eq!(own["blake3"], other["blake3"]);
    }
    for model in [&mut one, &mut other] {
        for key in ["provenance", "seal"] {
            model.as_object_mut().unwrap().remove(key);
        }
    }
    assert_eq!(one["unknown"], other["unknown"]);
    assert_eq!(one["category"], other["category"]);

    let found = underbrush!["evaluate", aux, "--model", out, "--json"].json();
    let objects = found["objects"].as_array().unwrap();
    let count = |holds: &dyn Fn(&Value) -> bool| json!(objects.iter().filter(|own| holds(own)).count());
    let unknown = &found["unknown"];
    assert_eq!(unknown["unknown_objects"], count(&|own| own["truth"] == "post"));
    assert_eq!(unknown["found_objects"], count(&|own| own["truth"] == "post" && own["at_end"] == "unknown"));
    let called = &["leaf", "trunk", "uncertain", "unknown"];
    for own in objects {
        assert!(called.contains(&own["at_end"].as_str().unwrap()), "{own}");
    }
    assert!(objects.len() >= 8, "{}", objects.len());
    let reach = folder.path().join("reach.parquet");
    underbrush!["reach", posts, "--seed", "2", "--index", "1", "--out", reach].success();
    let answers = lines(&underbrush!["classify", out, reach].success());
    let judged = answers.iter().flat_map(|line| line["objects"].as_array().unwrap());
    assert!(judged.count() > 0);
}

/// Tests that cross-validation with auxiliary sets counts the verdicts of two models, each of which is trained on every second reach of
/// both kinds and judges the others, says when it calls nothing unknown, and refuses fewer auxiliary reaches than folds.
#[test]
fn auxiliary_sets_are_cross_validated() {
    let folder = tempfile::tempdir().unwrap();
    let record = |scene: &Path, count: usize| -> Vec<PathBuf> {
        let name = scene.file_stem().unwrap().to_string_lossy();
        let record = |index: usize| {
            let path = folder.path().join(format!("{name}-{index}.parquet"));
            underbrush!["reach", scene, "--seed", "2", "--index", index.to_string(), "--out", path].success();
            path
        };
        (0..count).map(record).collect()
    };
    let known = [record(&fixture().leaf_scene(), 8), record(&fixture().trunk_scene(), 8)].concat();
    let auxiliary = record(&posts(folder.path()), 16);
    let run = |command: &str, inputs: &[PathBuf], options: &[&str], auxiliary: &[PathBuf]| {
        let mut words: Vec<OsString> = vec![command.into()];
        words.extend(inputs.iter().map(Into::into));
        words.extend(options.iter().map(Into::into));
        if !auxiliary.is_empty() {
            words.push("--auxiliary".into());
            words.extend(auxiliary.iter().map(Into::into));
        }
        call(words, "")
    };
    let counts = |found: &Value| {
        let keys = ["unknown_objects", "found_objects", "known_objects", "false_alarm_objects"];
        keys.map(|key| found["unknown"][key].as_u64().unwrap())
    };
    let half =
        |paths: &[PathBuf], first: usize| -> Vec<PathBuf> { paths.iter().skip(first).step_by(2).cloned().collect() };
    let mut expected = [0; 4];
    for judged in 0..2 {
        let model = folder.path().join(format!("model-{judged}.json")).display().to_string();
        let (fitted, tested) = (1 - judged, [half(&known, judged), half(&auxiliary, judged)].concat());
        let auxiliary = half(&auxiliary, fitted);
        run("train", &half(&known, fitted), &["--classifier", "touch", "--out", &model], &auxiliary).success();
        let own = run("evaluate", &tested, &["--model", &model, "--unknown-share", "0.5", "--json"], &[]).json();
        expected.iter_mut().zip(counts(&own)).for_each(|(sum, count)| *sum += count);
    }
    let touch = ["--classifier", "touch"];
    let found =
        run("evaluate", &known, &["--classifier", "touch", "--unknown-share", "0.5", "--json"], &auxiliary).json();
    assert_eq!((counts(&found), &found["reaches"]), (expected, &json!(32)));
    assert!(expected[1] > 0, "{expected:?}");
    let mut unknown = found["objects"].as_array().unwrap().iter().filter(|own| own["truth"] == "post");
    assert!(unknown.all(|own| own["reach"].as_u64().unwrap() >= 16));
    let text = run("evaluate", &known, &touch, &auxiliary).success();
    assert!(text.contains("Each model calls no object unknown, because with these training data that takes"), "{text}");
    run("evaluate", &known, &touch, &auxiliary[..1]).refused(&["1 auxiliary reaches are fewer than the 2 folds"]);
}

/// Tests that auxiliary sets without unknown objects, or with too few, one that is also a data set, scene files without
/// `--reaches`, and options without their classifier are refused by name, and leave nothing behind.
#[test]
fn bad_auxiliary_sets_are_refused() {
    let (inputs, outputs) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let out = outputs.path().join("model.json");
    let (set, leaf, posts) = (fixture().dataset(), fixture().leaf_scene(), posts(inputs.path()));
    let train = |auxiliary: &Path, options: &[&str]| {
        let words = ["train".into(), set.clone().into(), "--classifier".into(), "touch".into(), "--out".into()];
        let mut words: Vec<OsString> = words.into();
        words.extend([out.clone().into(), "--auxiliary".into(), auxiliary.into()]);
        words.extend(options.iter().map(Into::into));
        call(words, "")
    };
    train(&leaf, &["--reaches", "2"])
        .refused(&["no unknown objects in the auxiliary sets", "a category that the data sets lack"]);
    train(&posts, &["--reaches", "1"]).refused(&["objects of the auxiliary category post", "10 or more"]);
    train(Path::new("leaf"), &[]).refused(&["leaf", "is a scene", "--reaches"]);
    train(&posts, &[]).refused(&["posts.toml", "is a scene", "--reaches"]);
    train(&set, &[]).refused(&["the same data twice"]);
    let none = inputs.path().join("none");
    train(&none, &[]).refused(&["none", "no such file or folder", "with --reaches, scenes"]);
    // The million reaches are not simulated first.
    underbrush!["train", "leaf", none, "--classifier", "touch", "--reaches", "1000000", "--out", out]
        .refused(&["none"]);
    train(&set.join("meta"), &["--reaches", "1"]).refused(&["--reaches", "applies to scenes", "leave it out"]);
    for options in [&["--auxiliary", "x"][..], &["--reaches", "3"]] {
        let mut words: Vec<OsString> = vec!["train".into(), fixture().table_csv().into(), "--out".into()];
        words.push(out.clone().into());
        words.extend(options.iter().map(Into::into));
        call(words, "").refused(&[options[0], "applies to --classifier touch only", "leave it out"]);
    }
    underbrush!["evaluate", fixture().table_csv(), "--auxiliary", "x"].refused(&[
        "--auxiliary",
        "applies to --classifier touch only",
        "leave it out",
    ]);
    let left: Vec<_> = std::fs::read_dir(outputs.path()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}
