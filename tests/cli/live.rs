//! `underbrush classify MODEL -`: frames as JSON lines, each of which is answered before the next is read.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use underbrush_recording::Frame;
use underbrush_recording::disk::read_recording;

use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::{Answer, arm, call, call_with_bytes, underbrush};

/// The frames of a reach that touches the forearm.
fn frames(folder: &Path) -> (PathBuf, Vec<Frame>) {
    let recording = folder.join("reach.parquet");
    recording_with_trials(&fixture().trunk_scene(), &recording);
    let frames = read_recording(&recording).unwrap().frames;
    (recording, frames)
}

/// A frame as a robot sends it: only the time and the sensed forces of the forearm.
fn robots_line(frame: &Frame) -> String {
    let forearm = frame.taxels.iter().filter(|taxel| taxel.patch == 0);
    let taxels: Vec<Value> = forearm
        .map(|taxel| json!({ "patch": "forearm", "taxel": taxel.taxel, "sensed_force_n": taxel.sensed_force_n }))
        .collect();
    json!({ "time_s": frame.time_s, "taxels": taxels }).to_string()
}

fn classify(model: &Path, options: &[&str], stdin: &str) -> Answer {
    let mut arguments = vec!["classify".into(), model.into(), "-".into()];
    arguments.extend(options.iter().map(Into::into));
    call(arguments, stdin)
}

/// Tests that each line, even an invalid one, is answered while stdin stays open and before the next line is written.
#[test]
fn each_line_is_answered_before_the_next_is_sent() {
    let folder = tempfile::tempdir().unwrap();
    let (_, frames) = frames(folder.path());
    let mut robot = Command::new(env!("CARGO_BIN_EXE_underbrush"))
        .args(["classify".as_ref(), fixture().model().as_os_str(), "-".as_ref()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = robot.stdin.take().unwrap();
    let mut stdout = BufReader::new(robot.stdout.take().unwrap());
    let mut ask = |line: &str| -> Value {
        writeln!(stdin, "{line}").unwrap();
        stdin.flush().unwrap();
        let mut answer = String::new();
        stdout.read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap()
    };
    for frame in &frames[..3] {
        assert_eq!(ask(&serde_json::to_string(frame).unwrap())["time_s"], frame.time_s);
    }
    assert_eq!(ask("{\"time_s\": ")["line"], 4);
    assert_eq!(ask(&robots_line(&frames[3]))["time_s"], frames[3].time_s);
    assert_eq!(ask("{\"reset\": true}"), json!({ "line": 6, "reset": true }));
    assert_eq!(ask(&robots_line(&frames[0]))["time_s"], frames[0].time_s);
    drop(stdin);
    assert!(robot.wait().unwrap().success());
}

/// Tests that a stream continues after any invalid line and keeps the history of every contact: the answers to the
/// valid lines equal those of a stream without the invalid lines. A model of force needs neither ground truth nor poses
/// nor joints.
#[test]
fn bad_lines_are_answered_and_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, frames) = frames(folder.path());
    let long = "x".repeat(2_000_000);
    let reading = |text: &str| format!("{{\"time_s\":1e6,\"taxels\":[{text}]}}");
    let bad = [
        ("{\"time_s\": ".to_owned(), "line"),
        (long, "line"),
        ("{\"time_s\":-1,\"taxels\":[]}".into(), "time_s"),
        ("{\"taxels\":[]}".into(), "time_s"),
        (reading("{\"patch\":\"elbow\",\"taxel\":1,\"sensed_force_n\":1}"), "taxels[0].patch"),
        (reading("{\"patch\":7,\"taxel\":1,\"sensed_force_n\":1}"), "taxels[0].patch"),
        (reading("{\"patch\":0,\"taxel\":384,\"sensed_force_n\":1}"), "taxels[0].taxel"),
        (reading("{\"patch\":0,\"taxel\":1,\"sensed_force_n\":-1}"), "taxels[0].sensed_force_n"),
        (reading("{\"patch\":0,\"taxel\":1,\"sensed_force_n\":1e300}"), "taxels[0].sensed_force_n"),
        (
            reading(
                "{\"patch\":0,\"taxel\":1,\"sensed_force_n\":1},{\"patch\":\"forearm\",\"taxel\":1,\"sensed_force_n\":2}",
            ),
            "taxels[1].taxel",
        ),
    ];
    let mut stdin = String::new();
    let mut lines = 0;
    let mut expected_errors = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        stdin += &(robots_line(frame) + "\n");
        lines += 1;
        // Blank lines are counted but not answered.
        stdin += "\n";
        lines += 1;
        if index % 7 == 3 {
            let (line, field) = &bad[index / 7 % bad.len()];
            stdin += &format!("{line}\n");
            lines += 1;
            expected_errors.push((lines, *field));
        }
    }
    assert!(expected_errors.len() >= bad.len(), "a longer reach is needed");
    let answer = classify(&fixture().model(), &[], &stdin);
    assert!(answer.stderr.contains(&format!("{} bad lines", expected_errors.len())), "{}", answer.stderr);
    let (mut good, mut errors) = (String::new(), Vec::new());
    let text = answer.success();
    for line in text.lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        match value["error"].as_object() {
            None => good += &format!("{line}\n"),
            Some(error) => {
                assert!(error["found"].is_string() && error["allowed"].is_string(), "{line}");
                errors.push((value["line"].as_u64().unwrap(), error["field"].as_str().unwrap().to_owned()));
            }
        }
    }
    let expected_errors: Vec<_> = expected_errors.into_iter().map(|(line, field)| (line, field.to_owned())).collect();
    assert_eq!(errors, expected_errors);
    assert!(good == underbrush!["classify", fixture().model(), recording, "--online"].success());
}

/// Tests that bytes that are not UTF-8 make an invalid line like any other.
#[test]
fn bytes_that_are_no_text() {
    let arguments = vec!["classify".into(), fixture().model().into(), "-".into()];
    let output = call_with_bytes(arguments, b"\xff\xfe\x00\n{\"time_s\":1,\"taxels\":[]}");
    let answers: Vec<Value> = output.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(answers[0]["error"]["field"], "line");
    assert_eq!(answers[1], json!({ "time_s": 1.0, "taxels": [] }));
    assert_eq!((answers.len(), output.status), (2, 0));
}

/// Tests that `--strict` also answers an invalid line, and then ends with exit status 2 and the number of the line.
#[test]
fn strict_ends_at_the_first_bad_line() {
    let good = "{\"time_s\":1,\"taxels\":[]}\n";
    let answer = classify(&fixture().model(), &["--strict"], &format!("{good}\n{{\"time_s\":2}}\n{good}"));
    assert_eq!(answer.status, 2, "{}", answer.stderr);
    assert!(answer.stderr.contains("<stdin>:3") && answer.stderr.contains("--strict"), "{}", answer.stderr);
    assert_eq!(answer.stdout.lines().count(), 2);
    assert!(answer.stdout.contains("\"line\":3"), "{}", answer.stdout);
    for option in ["--strict", "--skin=x"] {
        let refused = underbrush!["classify", fixture().model(), fixture().table_csv(), option];
        refused.refused(&["--skin and --strict are for frames on standard input"]);
    }
}

/// Tests that a model that uses motion needs only the pose of its own patch, and gives the same answers as for the
/// recording.
#[test]
fn motion_needs_a_pose() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, frames) = frames(folder.path());
    let model = folder.path().join("motion.json");
    underbrush!["train", fixture().table_csv(), "--out", model, "--states", "2", "--features", "force+motion"]
        .success();
    let without = classify(&model, &[], &robots_line(&frames[0])).success();
    assert_eq!(serde_json::from_str::<Value>(&without).unwrap()["error"]["field"], "patch_pose_world");
    let with_pose = |frame: &Frame| {
        let mut line: Value = serde_json::from_str(&robots_line(frame)).unwrap();
        line["patch_pose_world"] = json!({ "forearm": frame.patch_pose_world[0] });
        line.to_string() + "\n"
    };
    let stdin: String = frames.iter().map(with_pose).collect();
    assert!(classify(&model, &[], &stdin).success() == underbrush!["classify", model, recording, "--online"].success());
}

/// Tests that the skin of a stream comes from the given data set, recording, arm file or skin file, and is Cody's only
/// by default.
#[test]
fn the_skin_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = arm::write(folder.path(), arm::flipper_alone);
    let [recording, set] = ["reach.parquet", "set"].map(|name| folder.path().join(name));
    underbrush!["reach", scene, "--out", recording].success();
    underbrush!["generate", scene, "--reaches", "1", "--out", set].success();
    let line = "{\"time_s\":0,\"taxels\":[{\"patch\":0,\"taxel\":68,\"sensed_force_n\":1}]}\n\
                {\"time_s\":1,\"taxels\":[{\"taxel\":69,\"sensed_force_n\":1}]}\n";
    let skins = ["cody.toml", "cody.skin.toml", "reach.parquet", "set"];
    for skin in skins.map(|name| folder.path().join(name)) {
        let skin = format!("--skin={}", skin.display());
        let text = classify(&fixture().model(), &[&skin], line).success();
        let answers: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(answers[0]["taxels"][0]["taxel"], 68, "{skin}: {text}");
        // The flipper has 69 taxels. It is the only patch, so it need not be named.
        assert_eq!(answers[1]["error"]["field"], "taxels[0].taxel", "{skin}: {text}");
        assert_eq!(answers[1]["error"]["allowed"], "a taxel of patch flipper: 0 to 68");
    }
    // Cody's forearm has a taxel 69, but Cody has two patches.
    let text = classify(&fixture().model(), &[], line).success();
    assert!(text.contains("taxels[0].patch") && text.contains("forearm"), "{text}");
    let table = format!("--skin={}", fixture().table_csv().display());
    classify(&fixture().model(), &[&table], line).refused(&["trials.csv", "bytes that are not Parquet"]);
    classify(&fixture().model(), &["--skin=absent.toml"], line).refused(&["absent.toml", "no such file"]);
}
