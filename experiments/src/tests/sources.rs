use std::path::{Path, PathBuf};

#[path = "../../build.rs"]
#[expect(
    dead_code,
    clippy::print_stdout,
    reason = "a build script prints for cargo; only its hashes are wanted"
)]
mod build_script;

use build_script::{Folders, hash};

/// The folders of crates that lie side by side.
fn side_by_side(root: &Path) -> Folders {
    let folder = |name: &str| -> PathBuf { root.join(name) };
    Folders {
        experiments: folder("experiments"),
        sim: folder("sim"),
        recording: folder("recording"),
        classifier: folder("classifier"),
    }
}

/// Pins which sources each hash covers. The hash for results changes with this crate and with the classifier, also for
/// a new file, but not with the report or the simulator. The hash for data changes with the simulator, but not with the
/// classifier.
#[test]
fn each_hash_follows_its_sources() {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let files = [
        "experiments/src/lib.rs",
        "experiments/src/dataset.rs",
        "experiments/src/dataset/write.rs",
        "classifier/src/hmm/model.rs",
        "report/src/lib.rs",
        "sim/src/world.rs",
        "sim/arms/cody/cody.toml",
        "recording/src/lib.rs",
        "Cargo.lock",
    ];
    files.iter().for_each(|file| write(file, "1"));
    let folders = side_by_side(folder.path());
    let hashes = || (hash(&folders.analysis_sources()), hash(&folders.data_sources()));
    let mut before = hashes();
    let mut changes = |path: &str| {
        write(path, &format!("{path} changed"));
        let now = hashes();
        let changed = (now.0 != before.0, now.1 != before.1);
        before = now;
        changed
    };
    // (results, data)
    assert_eq!(changes("report/src/lib.rs"), (false, false));
    assert_eq!(changes("report/src/new.rs"), (false, false));
    assert_eq!(changes("classifier/src/hmm/model.rs"), (true, false));
    assert_eq!(changes("classifier/src/new.rs"), (true, false));
    assert_eq!(changes("experiments/src/lib.rs"), (true, false));
    assert_eq!(changes("experiments/src/dataset.rs"), (true, true));
    assert_eq!(changes("experiments/src/dataset/write.rs"), (true, true));
    assert_eq!(changes("sim/src/world.rs"), (false, true));
    assert_eq!(changes("sim/arms/cody/cody.toml"), (false, true));
    assert_eq!(changes("Cargo.lock"), (false, true));
    // A package has a lock file of its own.
    assert_eq!(changes("experiments/Cargo.lock"), (false, true));
    assert_eq!(changes("Cargo.lock"), (false, false));
}

/// Pins that the hashes built into the program are those of the sources beside this test.
#[test]
fn the_program_holds_the_hashes_of_its_sources() {
    let folders = side_by_side(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    assert_eq!(crate::kept::ANALYSIS_VERSION, hash(&folders.analysis_sources()));
    assert!(crate::dataset::PROGRAM_VERSION.ends_with(&hash(&folders.data_sources())));
}
