use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::super::kept;

/// What the build script takes for the sources of an analysis.
#[path = "../../../../build.rs"]
#[expect(
    dead_code,
    clippy::print_stdout,
    reason = "a build script talks to cargo; only its lists are wanted"
)]
mod build_script;

const RUN: (u64, bool) = (3, true);

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("seed-3.json");
    (folder, path)
}

/// Pins that a result is taken again only by the run that made it: another seed, size, name or build makes it anew.
#[test]
fn only_the_same_run_takes_a_kept_result() {
    let (folder, path) = folder();
    assert_eq!(kept::load::<Vec<f64>>(&path, RUN), None);
    let values = vec![64.2, 0.1 + 0.2];
    assert_eq!(kept::result(&path, RUN, || Ok(values.clone())).unwrap(), values);
    let not_made = kept::result(&path, RUN, || -> Result<Vec<f64>, _> { panic!("made again") });
    assert_eq!(not_made.unwrap(), values);
    for other in [(4, true), (3, false)] {
        assert_eq!(kept::load::<Vec<f64>>(&path, other), None);
    }
    let renamed = folder.path().join("splits-3.json");
    std::fs::copy(&path, &renamed).unwrap();
    assert_eq!(kept::load::<Vec<f64>>(&renamed, RUN), None);
    // Another build writes another hash of its sources.
    for hash in [env!("UNDERBRUSH_ANALYSIS_SOURCES"), env!("UNDERBRUSH_DATA_SOURCES")] {
        kept::store(&path, RUN, &values).unwrap();
        let content: serde_json::Value = crate::sealed::read(&path).unwrap();
        let other = content.to_string().replace(hash, "0123456789abcdef");
        assert_ne!(other, content.to_string());
        crate::sealed::write(&path, &serde_json::from_str::<serde_json::Value>(&other).unwrap()).unwrap();
        assert_eq!(kept::load::<Vec<f64>>(&path, RUN), None, "{hash}");
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
        assert_eq!(kept::load::<Vec<f64>>(&path, RUN), None, "{damaged}");
        kept::result(&path, RUN, || Ok(vec![64.2, 85.3])).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { files_below(&path) } else { vec![path] })
        .collect()
}

/// Pins that every file of this folder either decides kept results, and so is in their hash, or is listed as one that
/// does not; that the list names only what exists; and that no file in the hash uses a listed one, but for `mod.rs`,
/// which shows the results.
#[test]
fn every_file_that_decides_results_is_in_their_hash() {
    let analysis: BTreeSet<PathBuf> = build_script::files_of(&build_script::ANALYSIS_SOURCES)
        .into_iter()
        .collect();
    let listed = |path: &Path| build_script::NOT_ANALYSIS.iter().any(|other| path.starts_with(other));
    for path in files_below(Path::new("src/command/reproduce")) {
        assert!(analysis.contains(&path) != listed(&path), "{}", path.display());
    }
    for name in ["campaign", "classifiers", "comparison", "data", "measurement", "splits"] {
        let path = PathBuf::from(format!("src/command/reproduce/{name}.rs"));
        assert!(analysis.contains(&path), "{name}");
    }
    assert!(analysis.contains(Path::new("classifier/src/evaluate/mod.rs")));
    for other in build_script::NOT_ANALYSIS {
        assert!(Path::new(other).exists(), "{other}");
    }
    let modules = ["figures", "page", "skin_map", "tables", "words"];
    for path in analysis.iter().filter(|path| !path.ends_with("reproduce/mod.rs")) {
        let text = std::fs::read_to_string(path).unwrap();
        for module in modules {
            let used = [format!("super::{module}"), format!(" {module}::")];
            let uses = used.iter().any(|used| text.contains(used));
            assert!(
                !uses || !path.starts_with("src/command"),
                "{} uses {module}",
                path.display()
            );
        }
    }
}
