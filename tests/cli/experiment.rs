//! `underbrush reproduce --experiment`: experiments other than the paper's.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::support::underbrush;

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/examples/three-categories")
}

/// Copies the example with fewer reaches and smaller models, and names its arm by the full path. Of five reaches of a
/// scene, more than two have contacts; two folds need at least two.
fn tiny(folder: &Path) -> PathBuf {
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/arms/panda/panda.toml");
    for entry in std::fs::read_dir(example()).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let text = text
            .replace("../../../docs/arms/panda/panda.toml", arm.to_str().unwrap())
            .replace("reaches = 12", "reaches = 5\nsetting_reaches = 3")
            .replace("states = [5, 10]", "states = [4, 5]")
            .replace("truncations = [50, 10]", "truncations = [5]")
            .replace("states = 10", "states = 5");
        std::fs::write(folder.join(path.file_name().unwrap()), text).unwrap();
    }
    folder.join("three-categories.toml")
}

/// The number of a stage and the number of all, from a line such as "stage 3 of 17: Models".
fn stage(line: &str) -> Option<(usize, usize)> {
    let (number, rest) = line.strip_prefix("stage ")?.split_once(" of ")?;
    Some((number.parse().ok()?, rest.split_once(": ")?.0.parse().ok()?))
}

/// Tests the example of a Panda and three categories, made small, from scenes to report, with numbered stages: trials
/// of all three labels, a confusion matrix of three categories, every classifier and setting of the file, and no
/// mention of the paper.
#[test]
fn an_experiment_with_another_arm_and_three_categories_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (tiny(folder.path()), folder.path().join("out"));
    let answer = underbrush!["reproduce", "--experiment", &file, "--out", &out, "--json"];
    // In a pipe, lines tell how far the work is.
    let stages: Vec<(usize, usize)> = answer.stderr.lines().filter_map(stage).collect();
    assert_eq!(stages.first(), Some(&(1, 17)), "{}", answer.stderr);
    assert!(stages.is_sorted_by(|a, b| a.0 < b.0 && a.1 == b.1) && stages.len() > 10, "{stages:?}");
    let summary = answer.json();
    assert_eq!(summary["experiment"], "three-categories");
    let labels = ["leaf", "trunk", "foam roll"];
    let rows = summary["trials_per_reach"].as_array().unwrap();
    for label in labels {
        let own = rows.iter().find(|row| row["category"] == label && row["by"] == "taxel").unwrap();
        assert!(own["trials"].as_u64().unwrap() > 0, "no trial of {label}: {rows:?}");
        assert!(own["paper"].is_null());
    }
    let matrix = &summary["figure_7"];
    let truths: Vec<&str> = matrix["truth"].as_array().unwrap().iter().map(|own| own.as_str().unwrap()).collect();
    assert_eq!(truths, ["foam roll", "leaf", "trunk"]);
    assert_eq!(summary["classifiers"].as_array().unwrap().len(), 4);
    // Two classifiers, trained and tested at two settings.
    assert_eq!(summary["splits"].as_array().unwrap().len(), 8);
    assert_eq!(summary["figure_11"].as_array().unwrap().len(), 0);
    let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
    assert!(page.contains("foam roll") && !page.contains("In the paper") && !page.contains("NaN"), "{page}");
    assert!(!page.contains("the paper's experiment"));
    // The replay pages hold exactly the reaches that figures link to.
    let mut files = 0;
    for name in ["replay.html", "replay-engineered.html", "replay-training.html"] {
        let address = format!("href=\"{name}#reach=");
        let links = page.split(&address).skip(1);
        let places: BTreeSet<&str> = links.map(|rest| rest.split(['&', '"']).next().unwrap()).collect();
        let file = std::fs::read_to_string(out.join("report").join(name));
        files += usize::from(file.is_ok());
        let held = file.map_or(0, |file| file.matches("<script type=\"application/octet-stream\"").count());
        assert_eq!(held, places.len(), "{name}");
        let expected: BTreeSet<String> = (0..held).map(|place| place.to_string()).collect();
        assert!(places.iter().all(|place| expected.contains(*place)), "{name}: {places:?}");
    }
    assert!(files > 0);
    // A folder can be continued only with the same experiment.
    underbrush!["reproduce", "--out", &out, "--quick"].refused(&["another run"]);
}

/// Tests that a mistake in an experiment file is reported with its key, the value found and a remedy.
#[test]
fn a_mistake_in_an_experiment_file_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = tiny(folder.path());
    let text = std::fs::read_to_string(&file).unwrap();
    let wrong = text.replace("method = \"naive-bayes\"", "method = \"naive\"");
    assert_ne!(wrong, text);
    std::fs::write(&file, wrong).unwrap();
    let out = folder.path().join("out");
    underbrush!["reproduce", "--experiment", &file, "--out", &out].refused(&["method", "naive", "schema experiment"]);
    assert!(!out.exists());
}

/// Tests that an experiment whose trials are all too short names the number that excludes them.
#[test]
fn trials_that_are_all_too_short_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = tiny(folder.path());
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("min_samples = 10\n", "min_samples = 100000\n")).unwrap();
    underbrush!["reproduce", "--experiment", &file, "--out", folder.path().join("out")]
        .refused(&["has 100000 samples or more; lower trials.min_samples"]);
}

/// Tests that the schema of experiment files is printed and has the main keys of the example.
#[test]
fn the_schema_has_the_main_keys() {
    let schema: serde_json::Value = serde_json::from_str(&underbrush!["schema", "experiment"].success()).unwrap();
    for key in ["title", "training", "classifiers", "settings", "published", "trials"] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
}
