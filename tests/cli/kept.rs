//! Files of earlier versions, in `tests/kept/VERSION/`, and a set with forces in double precision. Every later version
//! reads them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use underbrush_classifier::registry::CLASSIFIERS;
use underbrush_recording::disk::{Dataset, read_recording};

use crate::support::fixture::fixture;
use crate::support::underbrush;

/// The folders of all versions.
fn versions() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/kept");
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let versions: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    assert!(!versions.is_empty());
    versions
}

/// Tests that the set and the recording of every version are whole, and hold the same reach.
#[test]
fn sets_and_recordings_of_all_versions_are_read() {
    for version in versions() {
        let set = Dataset::open(version.join("set")).unwrap();
        set.verify().unwrap();
        let (from_set, alone) = (set.read_reach(0).unwrap(), read_recording(&version.join("reach.parquet")).unwrap());
        assert!(from_set.frames.len() > 10 && !from_set.objects.is_empty(), "{}", version.display());
        assert_eq!(from_set.frames, alone.frames, "{}", version.display());
    }
}

/// Tests that the models of every version are used without a warning and judge contacts of today, and that there is one of
/// each kind of classifier.
#[test]
fn models_of_all_versions_are_used() {
    let mut kinds = BTreeSet::new();
    for version in versions() {
        let entries = fs::read_dir(version).unwrap().map(|entry| entry.unwrap().path());
        for model in entries.filter(|path| path.extension().is_some_and(|ending| ending == "json")) {
            kinds.insert(model.file_stem().unwrap().to_str().unwrap().to_owned());
            let call = if model.ends_with("touch.json") {
                underbrush!["evaluate", fixture().dataset(), "--model", &model, "--json"]
            } else {
                underbrush!["classify", &model, fixture().table_csv()]
            };
            assert_eq!((call.status, call.stderr.as_str()), (0, ""), "{}", model.display());
            let judged = call.stdout.contains("leaf") && call.stdout.contains("trunk");
            assert!(judged, "{}: {}", model.display(), call.stdout);
        }
    }
    let all: BTreeSet<_> = CLASSIFIERS.iter().map(|kind| kind.name.to_owned()).chain(["touch".into()]).collect();
    assert_eq!(kinds, all);
}
