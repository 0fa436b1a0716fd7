use std::path::{Path, PathBuf};

#[path = "../../build.rs"]
#[expect(dead_code, clippy::print_stdout, reason = "a build script prints for cargo; only its hashes are wanted")]
mod build_script;

use build_script::{Folders, LIBRARIES, hash};

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

/// Tests which sources each hash covers. The hash for results changes with this crate and with the classifier, also for
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
    ];
    files.iter().for_each(|file| write(file, "1"));
    let lock = |packages: &[[&str; 2]]| -> String {
        let package = |[name, version]: &[&str; 2]| {
            format!("[[package]]\nname = \"{name}\"\nversion = \"{version}\"\nsource = \"registry\"\n\n")
        };
        packages.iter().map(package).collect()
    };
    write("Cargo.lock", &lock(&[["glam", "1.0.0"], ["indicatif", "1.0.0"]]));
    let folders = side_by_side(folder.path());
    let hashes = || (hash(&folders.analysis_sources()), hash(&folders.data_sources()));
    let mut before = hashes();
    let mut writes = |path: &str, text: &str| {
        write(path, text);
        let now = hashes();
        let changed = (now.0 != before.0, now.1 != before.1);
        before = now;
        changed
    };
    let mut changes = |path: &str| writes(path, &format!("{path} changed"));
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
    // Of the lock file, only libraries that decide data count.
    let mut locks = |path: &str, packages| writes(path, &lock(packages));
    let root = "Cargo.lock";
    assert_eq!(locks(root, &[["glam", "1.0.1"], ["indicatif", "1.0.0"]]), (false, true));
    assert_eq!(locks(root, &[["glam", "1.0.1"], ["indicatif", "1.0.1"]]), (false, false));
    // A package has a lock file of its own, which lists fewer crates.
    let packaged = "experiments/Cargo.lock";
    assert_eq!(locks(packaged, &[["glam", "1.0.1"]]), (false, false));
    assert_eq!(locks(packaged, &[["glam", "1.0.2"]]), (false, true));
    assert_eq!(locks(root, &[["glam", "1.0.3"]]), (false, false));
}

/// Tests that no library which may decide data is forgotten: every dependency of the simulator and of the recordings is
/// among those whose versions are hashed, or is known to decide nothing. A name that is not in the lock file is
/// misspelt.
#[test]
fn the_hash_covers_the_libraries_that_decide_data() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let decide_nothing = ["base64", "bytes", "rayon", "schemars", "tempfile", "thiserror"];
    // These are the names of the dependencies for which the workspace's manifest gives packages.
    let renamed = [("parry3d", "parry3d-f64"), ("rapier3d", "rapier3d-f64")];
    for manifest in ["sim/Cargo.toml", "recording/Cargo.toml"] {
        let parsed: toml::Table = read(manifest).parse().unwrap();
        for name in parsed["dependencies"].as_table().unwrap().keys() {
            let package = renamed.iter().find(|(from, _)| from == name).map_or(name.as_str(), |(_, to)| to);
            let known = LIBRARIES.contains(&package) || decide_nothing.contains(&package);
            assert!(known || package.starts_with("underbrush-"), "{manifest}: {package}");
        }
    }
    let lock = read("Cargo.lock");
    for name in LIBRARIES {
        assert!(lock.contains(&format!("\nname = \"{name}\"\n")), "{name}");
    }
}

/// Tests that the hashes built into the program are those of the sources beside this test.
#[test]
fn the_program_holds_the_hashes_of_its_sources() {
    let folders = side_by_side(&Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    assert_eq!(crate::run_folder::ANALYSIS_VERSION, hash(&folders.analysis_sources()));
    assert!(crate::dataset::PROGRAM_VERSION.ends_with(&hash(&folders.data_sources())));
}
