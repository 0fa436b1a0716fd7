use std::path::{Path, PathBuf};

use crate::kept;
use crate::progress::Silent;

const RUN: (u64, bool) = (3, true);

fn load(path: &Path, run: (u64, bool)) -> Option<Vec<f64>> {
    kept::load(path, run, &Silent)
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seed-3.json");
    (folder, path)
}

/// Pins that a result is taken again only by the run that made it: another seed, size, name or build makes it anew.
#[test]
fn only_the_same_run_takes_a_kept_result() {
    let (folder, path) = folder();
    assert_eq!(load(&path, RUN), None);
    let values = vec![64.2, 0.1 + 0.2];
    assert_eq!(
        kept::result(&path, RUN, &Silent, || Ok(values.clone())).unwrap(),
        values
    );
    let not_made = kept::result(&path, RUN, &Silent, || -> Result<Vec<f64>, _> { panic!("made again") });
    assert_eq!(not_made.unwrap(), values);
    for other in [(4, true), (3, false)] {
        assert_eq!(load(&path, other), None);
    }
    let renamed = folder.path().join("splits-3.json");
    std::fs::copy(&path, &renamed).unwrap();
    assert_eq!(load(&renamed, RUN), None);
    // Another build writes another hash of its sources.
    for hash in [env!("UNDERBRUSH_ANALYSIS_SOURCES"), env!("UNDERBRUSH_DATA_SOURCES")] {
        kept::store(&path, RUN, &values).unwrap();
        let content: serde_json::Value = crate::sealed::read(&path, &Silent).unwrap();
        let other = content.to_string().replace(hash, "0123456789abcdef");
        assert_ne!(other, content.to_string());
        crate::sealed::write(&path, &serde_json::from_str::<serde_json::Value>(&other).unwrap()).unwrap();
        assert_eq!(load(&path, RUN), None, "{hash}");
    }
}

/// Pins that a result whose numbers were edited, or that is cut short, is not shown but made again and kept.
#[test]
fn an_edited_result_is_made_again() {
    let (_folder, path) = folder();
    kept::store(&path, RUN, &vec![64.2, 85.3]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let edited = text.replace("85.3", "95.3");
    for damaged in [edited.as_str(), &text[..text.len() / 2]] {
        assert_ne!(damaged, text);
        std::fs::write(&path, damaged).unwrap();
        assert_eq!(load(&path, RUN), None, "{damaged}");
        kept::result(&path, RUN, &Silent, || Ok(vec![64.2, 85.3])).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}
