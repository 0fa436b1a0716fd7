use std::path::{Path, PathBuf};

use crate::progress::Silent;
use crate::result_cache::{self, Run};

fn run(seed: u64, quick: bool, experiment: &str) -> Run {
    Run { seed, quick, experiment: experiment.into() }
}

fn this() -> Run {
    run(3, true, "paper")
}

fn load(path: &Path, run: &Run) -> Option<Vec<f64>> {
    result_cache::load(path, run, &Silent)
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seed-3.json");
    (folder, path)
}

/// Tests that a cached result is used only by the run that made it: another seed, size, experiment, name or build
/// computes it again.
#[test]
fn only_the_same_run_takes_a_kept_result() {
    let (folder, path) = folder();
    assert_eq!(load(&path, &this()), None);
    let values = vec![64.2, 0.1 + 0.2];
    assert_eq!(result_cache::result(&path, &this(), &Silent, || Ok(values.clone())).unwrap(), values);
    let not_made = result_cache::result(&path, &this(), &Silent, || -> Result<Vec<f64>, _> { panic!("made again") });
    assert_eq!(not_made.unwrap(), values);
    for other in [run(4, true, "paper"), run(3, false, "paper"), run(3, true, "other")] {
        assert_eq!(load(&path, &other), None);
    }
    let renamed = folder.path().join("splits-3.json");
    std::fs::copy(&path, &renamed).unwrap();
    assert_eq!(load(&renamed, &this()), None);
    // Another build writes another hash of its sources.
    for hash in [env!("UNDERBRUSH_ANALYSIS_SOURCES"), env!("UNDERBRUSH_DATA_SOURCES")] {
        result_cache::store(&path, &this(), &values).unwrap();
        let content: serde_json::Value = crate::result_cache::read(&path, &Silent).unwrap();
        let other = content.to_string().replace(hash, "0123456789abcdef");
        assert_ne!(other, content.to_string());
        crate::result_cache::write(&path, &serde_json::from_str::<serde_json::Value>(&other).unwrap()).unwrap();
        assert_eq!(load(&path, &this()), None, "{hash}");
    }
}

/// Tests that a result whose numbers were edited, or that is truncated, is not used but computed and cached again.
#[test]
fn an_edited_result_is_made_again() {
    let (_folder, path) = folder();
    result_cache::store(&path, &this(), &vec![64.2, 85.3]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let edited = text.replace("85.3", "95.3");
    for damaged in [edited.as_str(), &text[..text.len() / 2]] {
        assert_ne!(damaged, text);
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(load(&path, &this()), None, "{damaged}");
        result_cache::result(&path, &this(), &Silent, || Ok(vec![64.2, 85.3])).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}
