//! The physics engine: its name in every data set, and the one module that uses it.

use std::fs;
use std::path::{Path, PathBuf};

/// Tests that a data set names the engine version in Cargo.lock, so that an update cannot be forgotten.
#[test]
fn provenance_names_the_engine_of_the_lock_file() {
    let lock = include_str!("../../Cargo.lock");
    let package = lock.split("[[package]]").find(|package| package.contains("\nname = \"rapier3d-f64\"\n")).unwrap();
    let version = package.lines().find_map(|line| line.strip_prefix("version = \"")?.strip_suffix('"')).unwrap();
    let named = format!("rapier3d-f64 {version},");
    assert!(underbrush_sim::physics::ENGINE.starts_with(&named), "{} is not {named}", underbrush_sim::physics::ENGINE);
}

/// Every Rust source below `folder` that mentions the engine's crate, relative to `root`.
fn naming_the_engine(root: &Path, folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if !name.starts_with('.') && name != "target" && name != "node_modules" {
                naming_the_engine(root, &path, found);
            }
        } else if name.ends_with(".rs") && fs::read_to_string(&path).unwrap().contains(concat!("rapier3d", "::")) {
            found.push(path.strip_prefix(root).unwrap().to_path_buf());
        }
    }
}

/// Tests that the engine is sealed: of all sources (crates, tests, benches, examples) only those of `sim`'s module
/// `simulation` use the engine's crate, and the check that compares the simulator's joint trees with the engine's.
#[test]
fn only_the_simulation_uses_the_engine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    naming_the_engine(root, root, &mut found);
    let (inside, outside): (Vec<_>, Vec<_>) =
        found.into_iter().partition(|path| path.starts_with("sim/src/simulation"));
    let outside: Vec<_> =
        outside.into_iter().filter(|path| *path != Path::new("validation/src/joint_trees/peer.rs")).collect();
    assert!(inside.len() > 3, "the test looks in the right place: {inside:?}");
    assert!(outside.is_empty(), "these name the engine, too: {outside:?}");
}
