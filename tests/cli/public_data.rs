//! The excerpts of public data sets in `examples/public-data`.

use std::path::Path;

use serde_json::Value;

use crate::support::underbrush;

/// What `evaluate` tells of an excerpt with a classifier, over four folds.
fn evaluated(excerpt: &str, classifier: &str, features: &str) -> Value {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/public-data").join(excerpt);
    underbrush!["evaluate", table, "--folds", "4", "--classifier", classifier, "--features", features, "--json"].json()
}

/// Tests that in the excerpt of a gripper's wrenches, 12 trials of each of three categories, trees and MiniRocket on all channels
/// are right far more often than the most common category.
#[test]
fn a_wrench_tells_failures_of_a_gripper() {
    let wrench = "force,column:fx,column:fy,column:fz,column:tx,column:ty,column:tz";
    for classifier in ["trees", "mini-rocket"] {
        let found = evaluated("lp4-excerpt.csv", classifier, wrench);
        assert_eq!(found["predictions"].as_array().unwrap().len(), 36);
        assert_eq!(found["majority_baseline"].as_f64(), Some(1.0 / 3.0));
        assert!(found["balanced_accuracy"].as_f64().unwrap() > 0.7, "{classifier}: {found}");
    }
}

/// Tests that without a classifier all are compared on the chosen channels, the best first and each once.
#[test]
fn all_classifiers_are_compared_on_the_chosen_channels() {
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/public-data/lp4-excerpt.csv");
    let found =
        underbrush!["evaluate", table, "--folds", "4", "--features", "column:fx,column:tz,force", "--json"].json();
    let compared = found["comparison"].as_array().unwrap();
    let balanced = |own: &Value| own["balanced_accuracy"].as_f64().unwrap();
    assert!(compared.is_sorted_by(|a, b| balanced(a) >= balanced(b)), "{compared:?}");
    let mut names: Vec<_> = compared.iter().map(|own| own["classifier"].as_str().unwrap()).collect();
    names.sort_unstable();
    let all = [
        "echo-state-network",
        "hmm",
        "logistic",
        "mini-rocket",
        "naive-bayes",
        "nearest-neighbours",
        "peak-force",
        "trees",
    ];
    assert_eq!(names, all);
}

/// Tests that in the excerpt of a hand's grasps, five of each of ten objects, the fingertips tell most objects.
#[test]
fn fingertips_tell_objects() {
    let fingers = ["thumb", "index", "middle", "ring", "little"];
    let features = fingers.map(|finger| format!(",column:{finger}_mean,column:{finger}_max")).concat();
    let found = evaluated("grasps-excerpt.csv", "mini-rocket", &format!("force{features}"));
    assert_eq!(found["predictions"].as_array().unwrap().len(), 50);
    assert_eq!(found["majority_baseline"].as_f64(), Some(0.1));
    assert!(found["balanced_accuracy"].as_f64().unwrap() > 0.6, "{found}");
}
