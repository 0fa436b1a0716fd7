//! `train`, `classify`, `evaluate`, `inspect` and `schema` with the classifier `touch`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use serde_json::{Value, json};
use underbrush_recording::disk::read_recording;

use crate::support::fixture::fixture;
use crate::support::json_schema::faults;
use crate::support::{call, underbrush};

/// A model fitted to the shared data set, and the report of the training, made once for all tests.
static TRAINED: LazyLock<(PathBuf, Value)> = LazyLock::new(|| {
    let model = Path::new(env!("CARGO_TARGET_TMPDIR")).join("touch.json");
    let report = train(&model, "2");
    (model, report)
});

/// The shared touch model.
pub fn model() -> PathBuf {
    TRAINED.0.clone()
}

fn train(model: &Path, jobs: &str) -> Value {
    let train = underbrush![
        "train",
        fixture().dataset(),
        "--classifier",
        "touch",
        "--out",
        model,
        "--jobs",
        jobs,
        "--json"
    ];
    train.json()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Writes the first reach of `scene` from this index on in which an object truly presses on the forearm; returns its index.
fn touched(scene: &Path, first: usize, recording: &Path) -> usize {
    for number in first..first + 20 {
        let index = number.to_string();
        underbrush!["reach", scene, "--seed", "1", "--index", index, "--out", recording].success();
        let frames = read_recording(recording).unwrap().frames;
        let mut taxels = frames.iter().flat_map(|frame| &frame.taxels);
        if taxels.any(|taxel| taxel.patch == 0 && taxel.true_normal_force_n > 0.0 && taxel.sensed_force_n > 0.1) {
            return number;
        }
    }
    panic!("nothing touches the forearm in twenty reaches of {}", scene.display());
}

/// A recording of trunks that touch the forearm.
fn recording(folder: &Path) -> PathBuf {
    let recording = folder.join("reach.parquet");
    touched(&fixture().trunk_scene(), 0, &recording);
    recording
}

fn sum(probabilities: &Value) -> f64 {
    let own = probabilities.as_object().unwrap().values();
    own.map(|probability| probability.as_f64().unwrap()).sum()
}

/// Pins that training reports its rows and the chosen decision, that the file holds that decision, and that the file has the same
/// bytes with one thread and with two.
#[test]
fn the_model_is_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let again = folder.path().join("again.json");
    let (path, report) = &*TRAINED;
    let other = train(&again, "1");
    assert!(
        std::fs::read(path).unwrap() == std::fs::read(&again).unwrap(),
        "the models differ"
    );
    assert_eq!(other["rows"], report["rows"]);
    assert_eq!(report["categories"], json!(["leaf", "trunk"]));
    let rows = &report["rows"];
    assert_eq!((&rows["reaches"], &rows["held_out_parts"]), (&json!(6), &json!(2)));
    for count in [
        &rows["touched_taxels"],
        &rows["regions"]["leaf"],
        &rows["regions"]["trunk"],
    ] {
        assert!(count.as_u64().unwrap() > 0, "{rows}");
    }
    let model = read(path);
    assert_eq!(model["format"], "underbrush-touch/1");
    assert_eq!(model["decision"], report["decision"]);
}

/// Pins that limits of risk choose the decision that is stored, that so few reaches cannot show small shares, and that the limits are
/// refused where they would be ignored or say otherwise than another option.
#[test]
fn limits_of_risk_choose_the_decision() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("touch.json");
    let data = fixture().dataset();
    let train = |limit: &str| {
        underbrush![
            "train",
            data,
            "--classifier",
            "touch",
            "--limit-wrong",
            limit,
            "--out",
            model
        ]
    };
    train("0.05").refused(&["6 reaches cannot show that at most 0.05", "19 reaches or more"]);
    assert!(!model.exists());
    train("0.2").success();
    let decision = &read(&model)["decision"];
    let usual = &read(&TRAINED.0)["decision"];
    assert_ne!(decision["cost_of_uncertain"], usual["cost_of_uncertain"]);
    assert_eq!(decision["unknown_share"], usual["unknown_share"]);
    let refused = [
        underbrush!["train", data, "--limit-wrong", "0.2", "--out", model],
        underbrush!["evaluate", data, "--limit-false-alarms", "0.2"],
        underbrush!["evaluate", data, "--model", model, "--limit-wrong", "0.2"],
        underbrush![
            "evaluate",
            data,
            "--classifier",
            "touch",
            "--limit-wrong",
            "0.2",
            "--cost-of-uncertain",
            "0.1"
        ],
    ];
    for call in refused {
        call.refused(&["--limit-", "leave"]);
    }
}

/// Pins that the text of training names what was held out and the decision, and that recordings can be given instead of a data
/// set, with the options of contacts.
#[test]
fn several_recordings_train_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let [leaves, trunks, model] =
        ["leaves.parquet", "trunks.parquet", "model.json"].map(|name| folder.path().join(name));
    touched(&fixture().trunk_scene(), 0, &trunks);
    touched(&fixture().leaf_scene(), 0, &leaves);
    let text = underbrush![
        "train",
        leaves,
        trunks,
        "--classifier",
        "touch",
        "--threshold-n",
        "0.05",
        "--patch",
        "forearm",
        "--out",
        model
    ]
    .success();
    for part in [
        "Classifier touch",
        "regions, leaf",
        "From 2 reaches",
        "held out",
        "called nothing above",
        "Model written to",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert_eq!(
        read(&model)["options"],
        json!({ "patch": "forearm", "threshold_n": 0.05 })
    );
}

/// Pins that every frame is answered, that taxels refer to regions, that probabilities sum to 1, and that verdicts follow from
/// them by the model's decision.
#[test]
fn verdicts_follow_from_the_probabilities() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let answers = lines(&underbrush!["classify", model(), recording].success());
    assert_eq!(answers.len(), read_recording(&recording).unwrap().frames.len());
    let decision = &read(&model())["decision"];
    let limit = |key: &str| decision[key].as_f64().unwrap();
    let mut seen = 0;
    for answer in &answers {
        let regions: BTreeMap<u64, &Value> = answer["regions"]
            .as_array()
            .unwrap()
            .iter()
            .map(|region| (region["contact"].as_u64().unwrap(), region))
            .collect();
        let of_region = |region: &Value| {
            let own = region["probabilities"].as_object().unwrap();
            let (best, probability) = own
                .iter()
                .max_by(|a, b| a.1.as_f64().unwrap().total_cmp(&b.1.as_f64().unwrap()))
                .unwrap();
            if region["share_beyond"].as_f64().unwrap() <= limit("unknown_share") {
                "unknown"
            } else if probability.as_f64().unwrap() > 1.0 - limit("cost_of_uncertain") {
                best.as_str()
            } else {
                "uncertain"
            }
            .to_owned()
        };
        let mut taxels: BTreeMap<u64, [u64; 2]> = BTreeMap::new();
        for taxel in answer["taxels"].as_array().unwrap() {
            let contact = taxel["contact"].as_u64().unwrap();
            let region = regions[&contact];
            let nothing = taxel["nothing"].as_f64().unwrap();
            assert!((nothing + sum(&taxel["probabilities"]) - 1.0).abs() < 1e-9, "{taxel}");
            let is_nothing = nothing > limit("nothing_above");
            let expected = if is_nothing {
                "nothing".to_owned()
            } else {
                of_region(region)
            };
            assert_eq!(taxel["verdict"], expected, "{taxel} in {region}");
            let counts = taxels.entry(contact).or_default();
            counts[0] += 1;
            counts[1] += u64::from(!is_nothing);
            seen += 1;
        }
        for (contact, region) in &regions {
            let [all, touched] = taxels[contact];
            assert_eq!(
                [&region["taxels"], &region["touched_taxels"]],
                [&json!(all), &json!(touched)]
            );
            assert!((sum(&region["probabilities"]) - 1.0).abs() < 1e-9, "{region}");
            let expected = if touched == 0 {
                "nothing".to_owned()
            } else {
                of_region(region)
            };
            assert_eq!(region["verdict"], expected, "{region}");
        }
    }
    assert!(seen > 0, "the reach has contacts");
}

/// Pins that frames on standard input give the lines of the recording, byte for byte and with any number of threads, that only
/// times, forces and the pose of the patch are needed, and that a line without the pose is refused.
#[test]
fn frames_on_standard_input_are_answered_alike() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let from_file = underbrush!["classify", model(), recording, "--jobs", "1"].success();
    assert_eq!(
        from_file,
        underbrush!["classify", model(), recording, "--online", "--jobs", "2"].success()
    );
    let frames = read_recording(&recording).unwrap().frames;
    let line = |pose: bool, frame: &underbrush_recording::Frame| {
        let forearm = frame.taxels.iter().filter(|taxel| taxel.patch == 0);
        let taxels: Vec<Value> = forearm
            .map(|taxel| json!({ "patch": "forearm", "taxel": taxel.taxel, "sensed_force_n": taxel.sensed_force_n }))
            .collect();
        let mut line = json!({ "time_s": frame.time_s, "taxels": taxels });
        if pose {
            line["patch_pose_world"] = json!({ "forearm": frame.patch_pose_world[0] });
        }
        line.to_string() + "\n"
    };
    let stdin: String = frames.iter().map(|frame| line(true, frame)).collect();
    let answer = call(vec!["classify".into(), model().into(), "-".into()], &stdin);
    assert!(
        answer
            .stderr
            .contains(&format!("{} frames answered: median ", frames.len())),
        "{}",
        answer.stderr
    );
    assert!(answer.success() == from_file, "the lines differ");
    let without = call(
        vec!["classify".into(), model().into(), "-".into()],
        &line(false, &frames[0]),
    );
    assert_eq!(lines(&without.success())[0]["error"]["field"], "patch_pose_world");
    // After a reset the same frames are answered alike.
    let first: String = frames.iter().take(50).map(|frame| line(true, frame)).collect();
    let twice = format!("{first}{{\"reset\":true}}\n{first}");
    let twice = call(vec!["classify".into(), model().into(), "-".into()], &twice).success();
    let twice: Vec<&str> = twice.lines().collect();
    assert_eq!(twice[..50], twice[51..]);
}

/// Pins that each option of the decision changes the verdicts as it says.
#[test]
fn the_decision_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let verdicts = |options: &[&str]| -> Vec<String> {
        let mut arguments = vec!["classify".into(), model().into(), recording.clone().into()];
        arguments.extend(options.iter().map(Into::into));
        let answers = lines(&call(arguments, "").success());
        let taxels = answers
            .iter()
            .flat_map(|answer| answer["taxels"].as_array().unwrap().clone());
        taxels
            .map(|taxel| taxel["verdict"].as_str().unwrap().to_owned())
            .collect()
    };
    let never_nothing = ["--nothing-above", "1"];
    let all_are = |options: &[&str], name: &str| {
        let found = verdicts(&[&never_nothing[..], options].concat());
        assert!(
            !found.is_empty() && found.iter().all(|own| own == name),
            "{options:?}: {found:?}"
        );
    };
    all_are(&["--unknown-share", "1"], "unknown");
    all_are(&["--unknown-share", "0", "--cost-of-uncertain", "0"], "uncertain");
    let sure = verdicts(
        &[
            &never_nothing[..],
            &["--unknown-share", "0", "--cost-of-uncertain", "1"],
        ]
        .concat(),
    );
    assert!(sure.iter().all(|own| own == "leaf" || own == "trunk"), "{sure:?}");
    // Probabilities are above 0.
    let nothing = verdicts(&["--nothing-above", "0"]);
    assert!(nothing.iter().all(|own| own == "nothing"), "{nothing:?}");
}

/// Pins that the evaluation with a stored model counts what `classify` says, by ground truth that is read independently.
#[test]
fn the_evaluation_counts_the_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(folder.path());
    let answers = lines(&underbrush!["classify", model(), path].success());
    let recording = read_recording(&path).unwrap();
    let mut counts: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
    for (frame, answer) in recording.frames.iter().zip(&answers) {
        for taxel in answer["taxels"].as_array().unwrap() {
            let own = frame
                .taxels
                .iter()
                .find(|own| own.patch == 0 && taxel["taxel"] == own.taxel)
                .unwrap();
            let object = own.object.filter(|_| own.true_normal_force_n > 0.0);
            let truth = object.map_or("nothing", |object| {
                recording.objects[usize::from(object)].category.name()
            });
            let count = counts.entry(truth).or_default();
            count[0] += 1.0;
            count[1] += f64::from(u8::from(taxel["verdict"] == truth));
        }
    }
    let found = underbrush!["evaluate", path, "--model", model(), "--json"].json();
    assert_eq!(found["reaches"], 1);
    let truths = found["truths"].as_array().unwrap();
    let names: Vec<&str> = truths.iter().map(|own| own["truth"].as_str().unwrap()).collect();
    assert_eq!(names, ["nothing", "leaf", "trunk", "anything else"]);
    assert!(counts.contains_key("trunk"), "{counts:?}");
    for own in truths {
        let [all, right] = counts.get(own["truth"].as_str().unwrap()).copied().unwrap_or_default();
        assert_eq!(own["taxel_frames"].as_f64(), Some(all));
        match own["right"].as_f64() {
            Some(share) => assert!((share - right / all).abs() < 1e-12, "{own}"),
            None => assert_eq!(all, 0.0),
        }
    }
}

/// Pins that cross-validation judges every reach once, whatever the number of threads, prints all figures as text, and fits
/// elsewhere with --train.
#[test]
fn reaches_are_cross_validated() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = Vec::new();
    for (name, scene) in [("leaf", fixture().leaf_scene()), ("trunk", fixture().trunk_scene())] {
        let mut first = 0;
        for number in 0..2 {
            let path = folder.path().join(format!("{name}{number}.parquet"));
            first = touched(&scene, first, &path) + 1;
            inputs.push(path);
        }
    }
    let evaluate = |options: &[&str]| {
        let mut arguments = vec!["evaluate".into()];
        arguments.extend(inputs.iter().map(Into::into));
        arguments.extend(options.iter().map(Into::into));
        call(arguments, "")
    };
    let by_touch = ["--classifier", "touch"];
    let cross_validate = |options: &[&str]| evaluate(&[&by_touch[..], options].concat());
    let one = cross_validate(&["--json", "--jobs", "1"]).success();
    assert_eq!(one, cross_validate(&["--json", "--jobs", "2"]).success());
    let cross: Value = serde_json::from_str(&one).unwrap();
    let model = model().display().to_string();
    let stored = evaluate(&["--model", &model, "--json"]).json();
    let frames = |found: &Value| -> Vec<Value> {
        let truths = found["truths"].as_array().unwrap().iter();
        truths.map(|own| own["taxel_frames"].clone()).collect()
    };
    assert_eq!(frames(&cross), frames(&stored));
    assert_eq!(
        (&cross["folds"], cross["decisions"].as_array().unwrap().len()),
        (&json!(2), 2)
    );
    assert_eq!(cross["contacts_at_end"]["trials"], stored["contacts_at_end"]["trials"]);
    assert!(stored["folds"].is_null() && cross["outliers"].is_null());
    for key in [
        "expected_calibration_error",
        "brier_score",
        "spurious_called_nothing",
        "touches_lost",
    ] {
        let share = cross[key].as_f64().unwrap();
        assert!((0.0..=2.0).contains(&share), "{key}: {share}");
    }
    let set = fixture().dataset().display().to_string();
    let elsewhere = cross_validate(&["--train", &set, "--json"]).json();
    assert_eq!(elsewhere, stored, "the stored model was fitted to that set");
    let text = cross_validate(&[]).success();
    for part in [
        "called unknown %",
        "balanced accuracy %",
        "majority baseline %",
        "first 0.1 s (10 samples)",
        "contacts with a right verdict by then",
        "Spurious readings called nothing",
        "Expected calibration error",
        "Nothing of an unknown category",
        "4 reaches in 2 folds",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
}

/// Pins that `inspect` shows the model, and that its file follows the schema while broken ones do not.
#[test]
fn the_file_follows_its_schema() {
    let shown = underbrush!["inspect", model(), "--json"].json();
    assert_eq!(
        (&shown["classifier"], &shown["categories"]),
        (&json!("touch"), &json!(["leaf", "trunk"]))
    );
    let schema: Value = serde_json::from_str(&underbrush!["schema", "touch"].success()).unwrap();
    let own = read(&model());
    assert_eq!(faults(&schema, &own), Vec::<String>::new());
    for (place, value) in [
        ("/format", json!("underbrush-touch/0")),
        ("/categories", json!([])),
        ("/decision/nothing_above", json!(1.5)),
        ("/options/threshold_n", json!(-1)),
        ("/touched/network/mean/0", json!("much")),
        ("/usual", json!({})),
    ] {
        let mut broken = own.clone();
        *broken.pointer_mut(place).unwrap() = value;
        assert!(!faults(&schema, &broken).is_empty(), "{place}");
    }
}
