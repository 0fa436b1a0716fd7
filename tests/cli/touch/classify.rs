//! `classify` with the classifier `touch`.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use underbrush_recording::disk::{read_recording, write_recording};

use super::{lines, model, read, recording};
use crate::support::fixture::fixture;
use crate::support::{call, underbrush};

fn sum(probabilities: &Value) -> f64 {
    let own = probabilities.as_object().unwrap().values();
    own.map(|probability| probability.as_f64().unwrap()).sum()
}

/// Tests that every frame is answered, that taxels refer to regions, that probabilities sum to 1, that verdicts follow from
/// them by the model's decision, and that objects have an interval of their stiffness.
#[test]
fn verdicts_follow_from_the_probabilities() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let answers = lines(&underbrush!["classify", model(), recording].success());
    assert_eq!(answers.len(), read_recording(&recording).unwrap().frames.len());
    let decision = &read(&model())["decision"];
    let limit = |key: &str| decision[key].as_f64().unwrap();
    let (mut seen, mut told) = (0, 0);
    for answer in &answers {
        let place = |own: &Value| (own["patch"].as_str().unwrap().to_owned(), own["contact"].as_u64().unwrap());
        let regions: BTreeMap<(String, u64), &Value> =
            answer["regions"].as_array().unwrap().iter().map(|region| (place(region), region)).collect();
        let of_region = |region: &Value| {
            let own = region["probabilities"].as_object().unwrap();
            let (best, probability) =
                own.iter().max_by(|a, b| a.1.as_f64().unwrap().total_cmp(&b.1.as_f64().unwrap())).unwrap();
            let objects = answer["objects"].as_array().unwrap().iter();
            let samples = objects.filter(|own| own["object"] == region["object"]).map(|own| own["samples"].as_u64());
            // The share is multiplied by five for an object that was felt in fewer than 60 samples.
            let factor = if samples.flatten().any(|own| own < 60) { 5.0 } else { 1.0 };
            if factor * region["share_beyond"].as_f64().unwrap() <= limit("unknown_share") {
                "unknown"
            } else if probability.as_f64().unwrap() > 1.0 - limit("cost_of_uncertain") {
                best.as_str()
            } else {
                "uncertain"
            }
            .to_owned()
        };
        let mut taxels: BTreeMap<(String, u64), [u64; 2]> = BTreeMap::new();
        for taxel in answer["taxels"].as_array().unwrap() {
            let contact = place(taxel);
            let region = regions[&contact];
            let nothing = taxel["nothing"].as_f64().unwrap();
            assert!((nothing + sum(&taxel["probabilities"]) - 1.0).abs() < 1e-9, "{taxel}");
            let is_nothing = nothing > limit("nothing_above");
            let expected = if is_nothing { "nothing".to_owned() } else { of_region(region) };
            assert_eq!(taxel["verdict"], expected, "{taxel} in {region}");
            let counts = taxels.entry(contact).or_default();
            counts[0] += 1;
            counts[1] += u64::from(!is_nothing);
            seen += 1;
        }
        for (contact, region) in &regions {
            let [all, touched] = taxels[contact];
            assert_eq!([&region["taxels"], &region["touched_taxels"]], [&json!(all), &json!(touched)]);
            assert!((sum(&region["probabilities"]) - 1.0).abs() < 1e-9, "{region}");
            let expected = if touched == 0 { "nothing".to_owned() } else { of_region(region) };
            assert_eq!(region["verdict"], expected, "{region}");
        }
        for object in answer["objects"].as_array().unwrap() {
            let Some(own) = object.get("stiffness") else { continue };
            let [low, median, high] =
                ["low", "median", "high"].map(|end| own[format!("{end}_n_per_m")].as_f64().unwrap());
            assert!(
                0.0 < low && low < median && median < high && object["moved_m"].as_f64().unwrap() >= 0.0,
                "{object}"
            );
            told += 1;
        }
    }
    assert!(seen > 0 && told > 0, "the reach has contacts");
}

/// Tests that frames on standard input give the same lines as the recording, byte for byte and for any number of
/// threads, that only times, forces and the pose of the patch are needed, and that a line without the pose is refused.
#[test]
fn frames_on_standard_input_are_answered_alike() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let from_file = underbrush!["classify", model(), recording, "--jobs", "1"].success();
    assert_eq!(from_file, underbrush!["classify", model(), recording, "--online", "--jobs", "2"].success());
    let frames = read_recording(&recording).unwrap().frames;
    let line = |pose: bool, frame: &underbrush_recording::Frame| {
        let names = ["forearm", "flipper"];
        let taxels = frame.taxels.iter();
        let taxels: Vec<Value> = taxels
            .map(|taxel| json!({ "patch": names[usize::from(taxel.patch)], "taxel": taxel.taxel, "sensed_force_n": taxel.sensed_force_n }))
            .collect();
        let mut line = json!({ "time_s": frame.time_s, "taxels": taxels });
        if pose {
            line["patch_pose_world"] =
                json!({ "forearm": frame.patch_pose_world[0], "flipper": frame.patch_pose_world[1] });
        }
        line.to_string() + "\n"
    };
    let stdin: String = frames.iter().map(|frame| line(true, frame)).collect();
    let answer = call(vec!["classify".into(), model().into(), "-".into()], &stdin);
    assert!(answer.stderr.contains(&format!("{} frames answered: ", frames.len())), "{}", answer.stderr);
    assert!(answer.success() == from_file, "the lines differ");
    let without = call(vec!["classify".into(), model().into(), "-".into()], &line(false, &frames[0]));
    assert_eq!(lines(&without.success())[0]["error"]["field"], "patch_pose_world");
    // After a reset the same frames get the same answers.
    let first: String = frames.iter().take(50).map(|frame| line(true, frame)).collect();
    let twice = format!("{first}{{\"reset\":true}}\n{first}");
    let twice = call(vec!["classify".into(), model().into(), "-".into()], &twice).success();
    let twice: Vec<&str> = twice.lines().collect();
    assert_eq!(twice[..50], twice[51..]);
}

/// Tests that frames at another rate than those of the training are warned of, in a recording and on standard input, for a model
/// that does not say its rate, and where `evaluate` fits the model.
#[test]
fn another_rate_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let own = recording(folder.path());
    let slow = folder.path().join("slow.parquet");
    let mut frames_of = read_recording(&own).unwrap();
    frames_of.rate_hz /= 2.0;
    frames_of.frames.iter_mut().for_each(|frame| frame.time_s *= 2.0);
    write_recording(&slow, &frames_of).unwrap();
    let line = |frame: usize, period_s: f64| format!("{{\"time_s\":{},\"taxels\":[]}}\n", frame as f64 * period_s);
    let naive = folder.path().join("naive.json");
    underbrush!["train", fixture().dataset(), "--classifier", "naive-bayes", "--features", "force", "--out", naive]
        .success();
    for (path, period_s, warns) in [(&own, 0.01, false), (&slow, 0.02, true)] {
        let stream: String = (0..60).map(|frame| line(frame, period_s)).collect();
        for answer in [
            underbrush!["classify", model(), path],
            underbrush!["classify", naive, path],
            underbrush!["score", naive, path],
            underbrush!["evaluate", path, "--model", model()],
            underbrush!["evaluate", path, "--train", fixture().dataset(), "--classifier", "peak-force"],
            underbrush!["replay", path, "--model", model(), "--out", folder.path().join("page.html"), "--force"],
            call(vec!["classify".into(), naive.clone().into(), "-".into()], &stream),
        ] {
            let found = answer.stderr.contains("frames at 50 Hz, but the model was fitted to frames at 100 Hz");
            assert_eq!(found, warns, "{}", answer.stderr);
        }
    }
    // Models of data sets without a rate are of early builds, which made sets of 100 Hz only.
    let mut early = read(&naive);
    early["provenance"]["data"][0].as_object_mut().unwrap().remove("rate_hz").unwrap();
    early.as_object_mut().unwrap().remove("blake3");
    std::fs::write(&naive, early.to_string()).unwrap();
    // What is fitted and tested at once has one rate, too. One fold is refused after that.
    let set = fixture().dataset();
    for (answer, warning) in [
        (underbrush!["classify", naive, slow], "frames at 50 Hz, but the model was fitted to frames at 100 Hz"),
        (
            underbrush!["evaluate", slow, "--train", set, "--classifier", "peak-force"],
            "frames at 50 Hz, but the model was fitted to frames at 100 Hz",
        ),
        (
            underbrush!["evaluate", set, slow, "--classifier", "touch", "--folds", "1"],
            "the model is fitted to frames at 100 Hz and at 50 Hz",
        ),
    ] {
        assert!(answer.stderr.contains(warning), "{}", answer.stderr);
    }
}

/// Tests that each option of the decision changes the verdicts as described.
#[test]
fn the_decision_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(folder.path());
    let verdicts = |options: &[&str]| -> Vec<String> {
        let mut arguments = vec!["classify".into(), model().into(), recording.clone().into()];
        arguments.extend(options.iter().map(Into::into));
        let answers = lines(&call(arguments, "").success());
        let taxels = answers.iter().flat_map(|answer| answer["taxels"].as_array().unwrap().clone());
        taxels.map(|taxel| taxel["verdict"].as_str().unwrap().to_owned()).collect()
    };
    let never_nothing = ["--nothing-above", "1"];
    let all_are = |options: &[&str], name: &str| {
        let found = verdicts(&[&never_nothing[..], options].concat());
        assert!(!found.is_empty() && found.iter().all(|own| own == name), "{options:?}: {found:?}");
    };
    all_are(&["--unknown-share", "1"], "unknown");
    all_are(&["--unknown-share", "0", "--cost-of-uncertain", "0"], "uncertain");
    let sure = verdicts(&[&never_nothing[..], &["--unknown-share", "0", "--cost-of-uncertain", "1"]].concat());
    assert!(sure.iter().all(|own| own == "leaf" || own == "trunk"), "{sure:?}");
    // Probabilities are above 0.
    let nothing = verdicts(&["--nothing-above", "0"]);
    assert!(nothing.iter().all(|own| own == "nothing"), "{nothing:?}");
}
