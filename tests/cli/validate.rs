//! `underbrush validate`.

use serde_json::Value;
use underbrush_validation::{CHECKS, SHORTFALLS};

use crate::support::underbrush;

/// The checks of a report, with every comparison's verdict.
fn verdicts(report: &Value) -> Vec<(String, String, Vec<String>)> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let checks = report["checks"].as_array().unwrap().iter();
    checks
        .map(|check| {
            let comparisons = check["comparisons"].as_array().unwrap().iter();
            let comparisons = comparisons.map(|comparison| text(&comparison["verdict"])).collect();
            (text(&check["name"]), text(&check["verdict"]), comparisons)
        })
        .collect()
}

#[test]
fn every_check_holds_and_shortfalls_are_listed() {
    // Pins: no check fails, and what falls short is exactly what the list of known shortfalls says.
    let report = underbrush!["validate", "--json"].json();
    let found = verdicts(&report);
    assert_eq!(found.len(), CHECKS.len());
    assert!(found.iter().all(|(_, verdict, _)| verdict != "fail"), "{found:?}");
    let short: usize = found
        .iter()
        .map(|(.., comparisons)| {
            comparisons
                .iter()
                .filter(|verdict| *verdict == "known_shortfall")
                .count()
        })
        .sum();
    assert_eq!(short, SHORTFALLS.len());
    assert_eq!(report["sound"], true);
}

#[test]
fn every_check_can_fail() {
    // Pins: with one parameter wrong on the simulated side each check fails, and the command is content with that.
    let report = underbrush!["validate", "--falsify", "--json"].json();
    for (name, verdict, comparisons) in verdicts(&report) {
        assert_eq!(verdict, "fail", "{name}");
        assert!(!comparisons.is_empty(), "{name} broke off");
    }
}

#[test]
fn a_scale_of_zero_fails_everything() {
    // Pins: every comparison of every check fails at scale 0, the table is still printed, and the exit status is 1.
    let answer = underbrush!["validate", "--tolerance-scale", "0", "--json"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    let report: Value = serde_json::from_str(&answer.stdout).unwrap();
    for (name, _, comparisons) in verdicts(&report) {
        assert!(comparisons.iter().all(|verdict| verdict == "fail"), "{name}");
    }
    assert!(
        answer.stderr.contains("these checks fail: leaf-small-load"),
        "{}",
        answer.stderr
    );
}

#[test]
fn only_what_is_named_runs() {
    // Pins: --only takes several names, keeps the order of the list, and tells closed form, residual and reason.
    let text = underbrush!["validate", "--only", "hmm", "--only", "resting-load"].success();
    let (load, hmm) = (text.find("4 resting-load: pass"), text.find("17 hmm: pass"));
    assert!(load.is_some() && load < hmm, "{text}");
    for part in [
        "closed form",
        "residual",
        "load under a ball / N",
        "[1] 1e-6: a state of rest",
    ] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert!(!text.contains("leaf"), "{text}");
}

#[test]
fn unknown_checks_and_scales_are_refused() {
    // Pins: an unknown name is a usage error that lists the names; a scale is a number, zero or more.
    underbrush!["validate", "--only", "gravity"].refused(&["gravity", "leaf-small-load", "resting-load", "hmm"]);
    for scale in ["-1", "nan", "much"] {
        let scale = format!("--tolerance-scale={scale}");
        underbrush!["validate", scale].refused(&["--tolerance-scale", "zero or more"]);
    }
}

#[test]
fn pictures_show_three_objects_and_a_loop() {
    // Pins: both pictures are written; the skin's names its three objects, each with a force on some taxels.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pictures");
    let answer = underbrush!["validate", "--only", "sensor", "--pictures", path.to_str().unwrap()];
    assert_eq!(answer.status, 0, "{}", answer.stderr);
    let skin = std::fs::read_to_string(path.join("skin.svg")).unwrap();
    for name in ["leaf, edge: ", "trunk: ", "foam roll: "] {
        let (_, rest) = skin.split_once(name).unwrap();
        let force_n: f64 = rest.split_once(" N on ").unwrap().0.parse().unwrap();
        assert!(force_n > 0.1, "{name}{force_n} N");
    }
    let roll = std::fs::read_to_string(path.join("foam-roll.svg")).unwrap();
    assert_eq!(roll.matches("<polyline").count(), 2, "in and out");
}
