//! Modules of a crate depend one way: reads the imports of every crate of the workspace and looks for cycles.
//!
//! A module is a file together with the folder of its submodules. Two modules form a cycle when each needs the other,
//! directly or through a third, anywhere in their files. A parent may use its submodules and they may use what the
//! parent itself defines; such a pair is one unit to its neighbours and is not a cycle. Names are followed through
//! re-exports to the module that defines them. Tests (`#[cfg(test)]`, `tests.rs`, `tests/`) may import whatever they
//! like.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

mod cycles;
mod tests;
mod tokens;

use cycles::cycles;
use tokens::references;

/// A module's path below the crate's root: `["arm", "skin"]`; empty for `lib.rs`, or for `main.rs` without it.
type Module = Vec<String>;

/// The sources of one crate, by module: path and text of each file.
type Sources = BTreeMap<Module, (PathBuf, String)>;

/// Every crate's folder of sources, with the crate's name.
fn crates(root: &Path) -> Vec<(String, PathBuf)> {
    let mut found = vec![("underbrush".to_string(), root.join("src"))];
    let mut folders = vec![root.to_path_buf(), root.join("tests")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.join("Cargo.toml").exists() && path.join("src").is_dir() {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                found.push((name, path.join("src")));
            }
        }
    }
    found.sort();
    found
}

/// Reads all modules below a folder of sources, without tests.
fn read(source_root: &Path) -> Sources {
    let mut sources = Sources::new();
    let mut folders = vec![(source_root.to_path_buf(), Module::new())];
    while let Some((folder, module)) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            let below = || module.iter().cloned().chain([stem.clone()]).collect::<Module>();
            if stem == "tests" {
                continue;
            } else if path.is_dir() {
                folders.push((path, below()));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let is_root =
                    stem == "lib" || stem == "mod" || (stem == "main" && !path.with_file_name("lib.rs").exists());
                let module = if is_root { module.clone() } else { below() };
                let text = fs::read_to_string(&path).unwrap();
                sources.insert(module, (path, text));
            }
        }
    }
    sources
}

/// Tests that the modules of every crate depend one way.
#[test]
fn modules_depend_one_way() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut complaints = String::new();
    for (name, source_root) in crates(root) {
        for cycle in cycles(&read(&source_root)) {
            writeln!(complaints, "{name}: {cycle}").unwrap();
        }
    }
    assert!(complaints.is_empty(), "modules form cycles:\n{complaints}");
}
