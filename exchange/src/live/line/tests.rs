//! The parser of lines: good lines, every kind of bad line, and arbitrary text.

use proptest::prelude::*;
use underbrush_recording::{Patch, Taxel};

use super::*;

/// Two patches: `sleeve` with 4 taxels and `tip` with 2.
fn layout() -> SkinLayout {
    let taxel = Taxel { position_link: DVec3::ZERO, normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1e-4 };
    let patch =
        |name: &str, taxels| Patch { name: name.into(), link: "link".into(), grid: None, taxels: vec![taxel; taxels] };
    SkinLayout { patches: vec![patch("sleeve", 4), patch("tip", 2)] }
}

fn force_alone() -> LineParser {
    LineParser::new(layout(), None)
}

fn with_motion() -> LineParser {
    LineParser::new(layout(), Some(0))
}

#[track_caller]
fn frame(parser: &mut LineParser, text: &str) -> Frame {
    match parser.parse(1, text) {
        Ok(Message::Frame(frame)) => *frame,
        other => panic!("{text}: {other:?}"),
    }
}

/// Tests that models of force need only time and readings, with patches by name or index in any order, and that unused
/// fields of a recording's frame, such as ground truth, are ignored.
#[test]
fn only_what_is_used_is_asked_for() {
    let line = r#"{"taxels":[{"taxel":1,"patch":"tip","sensed_force_n":2,"true_normal_force_n":"lost","object":-7},
        {"patch":0,"taxel":3,"sensed_force_n":0.5}],"time_s":1.5,"patch_pose_world":"none","joint_angle_rad":null}"#;
    let found = frame(&mut force_alone(), line);
    let felt = found.taxels.iter().map(|taxel| (taxel.patch, taxel.taxel, taxel.sensed_force_n));
    let felt: Vec<_> = felt.collect();
    assert_eq!(felt, [(0, 3, 0.5), (1, 1, 2.0)]);
    assert_eq!(found.time_s, 1.5);
    assert_eq!(frame(&mut force_alone(), r#"{"time_s":0,"taxels":[]}"#).taxels, []);
}

/// Tests that the patch need not be named if the skin has only one.
#[test]
fn the_only_patch_need_not_be_named() {
    let mut layout = layout();
    layout.patches.truncate(1);
    let line = r#"{"time_s":0,"taxels":[{"taxel":3,"sensed_force_n":1}]}"#;
    assert_eq!(frame(&mut LineParser::new(layout, None), line).taxels[0].patch, 0);
}

/// Tests that models of motion read the pose of their patch by name, or by index in a list of all patches; that a
/// quaternion with three digits is normalized, and one of unit length up to rounding is kept bit for bit.
#[test]
fn poses_by_name_or_in_a_list() {
    let pose = r#"{"position":[1,2,3],"orientation":[0,0,0.6,0.8]}"#;
    let by_name = format!(r#"{{"time_s":0,"taxels":[],"patch_pose_world":{{"sleeve":{pose}}}}}"#);
    let listed = format!(r#"{{"time_s":0,"taxels":[],"patch_pose_world":[{pose},null]}}"#);
    for line in [by_name, listed] {
        let found = frame(&mut with_motion(), &line).patch_pose_world[0];
        assert_eq!(found.position, DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(found.orientation.to_array(), [0.0, 0.0, 0.6, 0.8]);
        let rounded = frame(&mut with_motion(), &line.replace("0.8", "0.801")).patch_pose_world[0];
        assert!((rounded.orientation.length() - 1.0).abs() < 1e-15);
    }
}

/// Tests what is refused, and that the error names the field, quotes its value and says what is allowed.
#[test]
fn every_fault_is_named() {
    let reading =
        |text: &str| format!(r#"{{"time_s":9,"taxels":[{{"patch":0,"taxel":0,"sensed_force_n":1}},{text}]}}"#);
    let posed = |text: &str| format!(r#"{{"time_s":9,"taxels":[],"patch_pose_world":{text}}}"#);
    let pose = |position: &str, orientation: &str| {
        posed(&format!(r#"{{"sleeve":{{"position":{position},"orientation":{orientation}}}}}"#))
    };
    let unit = "[0,0,0,1]";
    let long = "x".repeat(5000);
    let cases: Vec<(String, &str, &str, &str)> = vec![
        ("{\"time_s\": ".into(), "line", "EOF while parsing", "one JSON object"),
        ("[]".into(), "line", "[]", "one JSON object"),
        ("17 taxels".into(), "line", "trailing characters at byte 4", "one JSON object"),
        (long.clone(), "line", "xxxx…", "one JSON object"),
        (r#"{"taxels":[]}"#.into(), "time_s", "nothing", "a number from"),
        (r#"{"time_s":"9","taxels":[]}"#.into(), "time_s", "\"9\"", "a number from"),
        (r#"{"time_s":1e300,"taxels":[]}"#.into(), "time_s", "1e+300", "a number from"),
        (r#"{"time_s":1e999,"taxels":[]}"#.into(), "line", "number out of range", "one JSON object"),
        (r#"{"time_s":NaN,"taxels":[]}"#.into(), "line", "expected value", "one JSON object"),
        (r#"{"time_s":5,"taxels":[]}"#.into(), "time_s", "5", "later than 5 s, the time of line 1"),
        (r#"{"time_s":4.9,"taxels":[]}"#.into(), "time_s", "4.9", "{\"reset\":true}"),
        (r#"{"time_s":9}"#.into(), "taxels", "nothing", "a list of readings"),
        (r#"{"time_s":9,"taxels":{}}"#.into(), "taxels", "{}", "a list of readings"),
        (reading("7"), "taxels[1]", "7", "an object with patch, taxel"),
        (reading("[0,1,1]"), "taxels[1]", "[0,1,1]", "an object with patch, taxel"),
        (reading(r#"{"taxel":1,"sensed_force_n":1}"#), "taxels[1].patch", "nothing", "0 or \"sleeve\", 1 or \"tip\""),
        (reading(r#"{"patch":2,"taxel":1,"sensed_force_n":1}"#), "taxels[1].patch", "2", "0 or \"sleeve\""),
        (reading(r#"{"patch":-1,"taxel":1,"sensed_force_n":1}"#), "taxels[1].patch", "-1", "0 or \"sleeve\""),
        (reading(r#"{"patch":65536,"taxel":1,"sensed_force_n":1}"#), "taxels[1].patch", "65536", "0 or \"sleeve\""),
        (reading(r#"{"patch":"elbow","taxel":1,"sensed_force_n":1}"#), "taxels[1].patch", "\"elbow\"", "\"tip\""),
        (reading(r#"{"patch":0,"sensed_force_n":1}"#), "taxels[1].taxel", "nothing", "patch sleeve: 0 to 3"),
        (reading(r#"{"patch":0,"taxel":4,"sensed_force_n":1}"#), "taxels[1].taxel", "4", "patch sleeve: 0 to 3"),
        (reading(r#"{"patch":"tip","taxel":2,"sensed_force_n":1}"#), "taxels[1].taxel", "2", "patch tip: 0 to 1"),
        (reading(r#"{"patch":0,"taxel":1.5,"sensed_force_n":1}"#), "taxels[1].taxel", "1.5", "0 to 3"),
        (reading(r#"{"patch":0,"taxel":65537,"sensed_force_n":1}"#), "taxels[1].taxel", "65537", "0 to 3"),
        (
            reading(r#"{"patch":"sleeve","taxel":0,"sensed_force_n":1}"#),
            "taxels[1].taxel",
            "0",
            "taxels[0].taxel names it",
        ),
        (reading(r#"{"patch":0,"taxel":1}"#), "taxels[1].sensed_force_n", "nothing", "0 to 10000 N"),
        (
            reading(r#"{"patch":0,"taxel":1,"sensed_force_n":null}"#),
            "taxels[1].sensed_force_n",
            "nothing",
            "0 to 10000 N",
        ),
        (reading(r#"{"patch":0,"taxel":1,"sensed_force_n":-5}"#), "taxels[1].sensed_force_n", "-5", "a number from 0"),
        (
            reading(r#"{"patch":0,"taxel":1,"sensed_force_n":"1"}"#),
            "taxels[1].sensed_force_n",
            "\"1\"",
            "a number from 0",
        ),
        (
            reading(r#"{"patch":0,"taxel":1,"sensed_force_n":1e300}"#),
            "taxels[1].sensed_force_n",
            "1e+300",
            "a number from 0",
        ),
        (r#"{"time_s":9,"taxels":[]}"#.into(), "patch_pose_world", "nothing", "as this model uses motion"),
        (posed("[]"), "patch_pose_world", "[]", "a list of 2 poses"),
        (posed("[null,null]"), "patch_pose_world[0]", "nothing", "the pose of patch sleeve"),
        (posed("{}"), "patch_pose_world.sleeve", "nothing", "the pose of patch sleeve"),
        (posed(r#"{"sleeve":[1,2,3]}"#), "patch_pose_world.sleeve", "[1,2,3]", "the pose of patch sleeve"),
        (posed(r#"{"elbow":{}}"#), "patch_pose_world", "key \"elbow\"", "sleeve, tip"),
        (posed(r#"{"sleeve":{"orientation":[0,0,0,1]}}"#), "patch_pose_world.sleeve.position", "nothing", "metres"),
        (pose("[1,2]", unit), "patch_pose_world.sleeve.position", "[1,2]", "x, y and z"),
        (pose("[1,2,1e300]", unit), "patch_pose_world.sleeve.position", "[1,2,1e+300]", "from -1e8 to 1e8 m"),
        (pose("[1,2,3]", "[0,0,0,0]"), "patch_pose_world.sleeve.orientation", "[0,0,0,0]", "of length 1"),
        (pose("[1,2,3]", "[0,0,0,2]"), "patch_pose_world.sleeve.orientation", "[0,0,0,2]", "of length 1"),
        (pose("[1,2,3]", "[1e200,1e200,0,0]"), "patch_pose_world.sleeve.orientation", "1e+200", "of length 1"),
        (pose("[1,2,3]", "[0,0,1]"), "patch_pose_world.sleeve.orientation", "[0,0,1]", "x, y, z, w"),
        (r#"{"reset":1}"#.into(), "reset", "1", "true, in a line of its own"),
        (r#"{"reset":false}"#.into(), "reset", "false", "true, in a line of its own"),
        (r#"{"reset":true,"time_s":1}"#.into(), "reset", "true", "in a line of its own"),
    ];
    for (line, field, found, allowed) in cases {
        // Only models that use motion see faults of poses. All models see the other faults.
        let mut parsers = vec![with_motion()];
        if !field.starts_with("patch_pose_world") {
            parsers.push(force_alone());
        }
        for mut parser in parsers {
            parser.last = Some((5.0, 1));
            let error = parser.parse(2, &line).unwrap_err();
            assert_eq!(error.field, field, "{line}");
            let quoted = found.strip_suffix('…').unwrap_or(found);
            assert!(error.found.contains(quoted), "{line}: {error:?}");
            assert!(error.allowed.contains(allowed), "{line}: {error:?}");
            assert!(error.found.len() < 400, "{error:?}");
            assert_eq!(parser.last, Some((5.0, 1)), "a bad line leaves all as it was");
        }
    }
}

/// Tests that taxel 0 of a patch without taxels is refused, with an error that says so.
#[test]
fn an_empty_patch_has_no_taxel() {
    let mut layout = layout();
    layout.patches[1].taxels.clear();
    let line = r#"{"time_s":0,"taxels":[{"patch":"tip","taxel":0,"sensed_force_n":1}]}"#;
    let error = LineParser::new(layout, None).parse(1, line).unwrap_err();
    assert_eq!(error.field, "taxels[0].taxel");
    assert_eq!(error.allowed, "no reading of patch tip, which has no taxels");
}

/// Tests that time may start again with a new reach.
#[test]
fn a_reset_lets_time_begin_anew() {
    let mut parser = force_alone();
    frame(&mut parser, r#"{"time_s":5,"taxels":[]}"#);
    assert_eq!(parser.parse(2, r#"{"reset":true}"#), Ok(Message::Reset));
    assert_eq!(frame(&mut parser, r#"{"time_s":0,"taxels":[]}"#).time_s, 0.0);
}

/// Possible values in a reading, valid and invalid.
fn reading() -> impl Strategy<Value = String> {
    let patch = prop_oneof![Just("0"), Just("1"), Just("\"sleeve\""), Just("\"tip\""), Just("2"), Just("null")];
    let force = prop_oneof![
        4 => (0.0..1e4_f64).prop_map(|force| force.to_string()),
        1 => any::<f64>().prop_map(|force| force.to_string()),
    ];
    (patch, 0..5_u32, force)
        .prop_map(|(patch, taxel, force)| format!(r#"{{"patch":{patch},"taxel":{taxel},"sensed_force_n":{force}}}"#))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Tests that no text, JSON or not, makes the parser panic, that errors are short whatever the line is, and that a
    /// good line after any of them is read as usual.
    #[test]
    fn anything_is_answered(
        text in prop_oneof![
            any::<String>(),
            r#"[\[\]{}",:0-9eE.\-+ a-z_\\]{0,80}"#,
            r#"\{"time_s":[0-9.eE-]{1,6},"taxels":[\[\]{}",:0-9a-z_]{0,60}\}"#,
        ],
        motion in any::<bool>(),
    ) {
        let mut parser = if motion { with_motion() } else { force_alone() };
        if let Err(error) = parser.parse(1, &text) {
            prop_assert!(error.found.len() < 1000 && !error.field.is_empty() && !error.allowed.is_empty());
        }
        let good = r#"{"time_s":1e10,"taxels":[],"patch_pose_world":{"sleeve":{"position":[0,0,0],"orientation":[0,0,0,1]}}}"#;
        parser.last = None;
        prop_assert!(parser.parse(2, good).is_ok());
    }

    /// Tests, against a simple reader of the same JSON, that a line is accepted if and only if each of its readings is
    /// valid and no taxel occurs twice, and that the frame then holds exactly these readings.
    #[test]
    fn sound_lines_and_no_others_are_taken(readings in prop::collection::vec(reading(), 0..6)) {
        let text = format!(r#"{{"time_s":0,"taxels":[{}]}}"#, readings.join(","));
        let mut expected = std::collections::BTreeMap::new();
        let mut sound = true;
        match serde_json::from_str::<serde_json::Value>(&text) {
            // Numbers such as `inf`.
            Err(_) => sound = false,
            Ok(line) => for reading in line["taxels"].as_array().unwrap() {
                let patch = match &reading["patch"] {
                    name if name == "sleeve" || *name == 0 => 0,
                    name if name == "tip" || *name == 1 => 1,
                    _ => { sound = false; continue }
                };
                let (taxel, force_n) = (reading["taxel"].as_u64().unwrap(), reading["sensed_force_n"].as_f64().unwrap());
                sound &= taxel < [4, 2][patch] && (0.0..=1e4).contains(&force_n);
                sound &= expected.insert((patch as u64, taxel), force_n).is_none();
            },
        }
        match force_alone().parse(1, &text) {
            Ok(Message::Frame(frame)) => {
                prop_assert!(sound, "{}", text);
                let found: Vec<_> = frame.taxels.iter()
                    .map(|taxel| ((u64::from(taxel.patch), u64::from(taxel.taxel)), taxel.sensed_force_n)).collect();
                prop_assert_eq!(found, expected.into_iter().collect::<Vec<_>>());
            }
            Ok(Message::Reset) => prop_assert!(false),
            Err(error) => prop_assert!(!sound, "{}: {:?}", text, error),
        }
    }
}
