//! `underbrush validate`.

use serde_json::Value;
use underbrush_validation::CHECKS;

use crate::support::underbrush;

/// Quantity and verdict of a comparison.
type Found = (String, String);

/// The checks of a report: name, verdict and comparisons.
fn verdicts(report: &Value) -> Vec<(String, String, Vec<Found>)> {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let checks = report["checks"].as_array().unwrap().iter();
    checks
        .map(|check| {
            let comparisons = check["comparisons"].as_array().unwrap().iter();
            let comparisons = comparisons.map(|found| (text(&found["quantity"]), text(&found["verdict"])));
            (text(&check["name"]), text(&check["verdict"]), comparisons.collect())
        })
        .collect()
}

/// Tests that no check fails, and that every comparison of every check fails under at least one wrong parameter.
#[test]
fn every_check_holds_and_every_comparison_can_fail() {
    let report = underbrush!["validate", "--json"].json();
    let found = verdicts(&report);
    assert_eq!(found.len(), CHECKS.len());
    assert!(found.iter().all(|(_, verdict, _)| verdict == "pass"), "{found:?}");
    let comparisons = || {
        let checks = found.iter();
        checks.flat_map(|(name, _, comparisons)| comparisons.iter().map(move |found| (name, found)))
    };
    assert_eq!(report["sound"], true);

    let falsified = underbrush!["validate", "--falsify", "--json"].json();
    let broken: Vec<(&str, &str)> = falsified["checks"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|check| {
            let comparisons = check["comparisons"].as_array().unwrap().iter();
            let broken = comparisons.filter(|found| found["broken"] == true);
            broken.map(|found| (check["name"].as_str().unwrap(), found["quantity"].as_str().unwrap()))
        })
        .collect();
    let all: Vec<(&str, &str)> =
        comparisons().map(|(name, (quantity, _))| (name.as_str(), quantity.as_str())).collect();
    assert_eq!(broken, all);
    assert_eq!(falsified["sound"], true);
    assert_eq!(falsified["broken"], all.len());
}

/// Tests that `--falsify` fails and names the check if a wrong parameter is not noticed, as with a huge tolerance.
#[test]
fn unnoticed_mistakes_are_an_error() {
    let answer = underbrush!["validate", "--falsify", "--only", "resting-load", "--tolerance-scale", "1e9"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    for part in ["0 of 3 comparisons fail as they should", "HOLDS", "3 comparisons of 1 checks with 1 wrong parameters"]
    {
        assert!(answer.stdout.contains(part), "no {part:?} in:\n{}", answer.stdout);
    }
    assert!(answer.stderr.contains("resting-load"), "{}", answer.stderr);
}

/// Tests that every comparison fails at scale 0, that the table is still printed, and that the exit status is 1.
#[test]
fn a_scale_of_zero_fails_everything() {
    let answer = underbrush!["validate", "--only", "hmm", "--only", "resting-load", "--tolerance-scale", "0", "--json"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    let report: Value = serde_json::from_str(&answer.stdout).unwrap();
    for (name, _, comparisons) in verdicts(&report) {
        assert!(!comparisons.is_empty(), "{name} broke off");
        assert!(comparisons.iter().all(|(_, verdict)| verdict == "fail"), "{name}");
    }
    assert!(answer.stderr.contains("these checks fail: resting-load, hmm"), "{}", answer.stderr);
}

/// Tests that `--only` takes several names, keeps the order of the list, and prints closed form, residual and reason.
#[test]
fn only_what_is_named_runs() {
    let text = underbrush!["validate", "--only", "hmm", "--only", "resting-load"].success();
    let (load, hmm) = (text.find("4 resting-load: pass"), text.find("17 hmm: pass"));
    assert!(load.is_some() && load < hmm, "{text}");
    for part in ["closed form", "residual", "load under a ball / N", "[1] 1e-6: a state of rest"] {
        assert!(text.contains(part), "no {part:?} in:\n{text}");
    }
    assert!(!text.contains("leaf"), "{text}");
}

/// Tests that an unknown name is a usage error that lists the names, and that the scale must be a number, zero or
/// more.
#[test]
fn unknown_checks_and_scales_are_refused() {
    underbrush!["validate", "--only", "gravity"].refused(&["gravity", "leaf-small-load", "resting-load", "hmm"]);
    for scale in ["-1", "nan", "much"] {
        let scale = format!("--tolerance-scale={scale}");
        underbrush!["validate", scale].refused(&["--tolerance-scale", "zero or more"]);
    }
}
