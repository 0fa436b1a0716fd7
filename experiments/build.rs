//! Gives the crate a hash of the sources that decide data, and one of those that decide results, so that data and cached
//! results of one build are never taken for those of another.

use std::path::{Path, PathBuf};

/// What decides the frames of a reach, relative to this crate.
pub const DATA_SOURCES: [&str; 5] = [
    "../sim/src",
    "../sim/arms",
    "../recording/src",
    "src/dataset.rs",
    "../Cargo.lock",
];
/// What decides the results that are computed from them: this crate and the classifier, whole. The report is a crate of
/// its own and not included. Experiment files and scenes are hashed when they are read.
pub const ANALYSIS_SOURCES: [&str; 2] = ["src", "../classifier/src"];

fn main() {
    for (variable, sources) in [
        ("UNDERBRUSH_DATA_SOURCES", &DATA_SOURCES[..]),
        ("UNDERBRUSH_ANALYSIS_SOURCES", &ANALYSIS_SOURCES[..]),
    ] {
        for source in sources {
            println!("cargo::rerun-if-changed={source}");
        }
        println!("cargo::rustc-env={variable}={}", hash(Path::new("."), sources));
    }
}

/// 16 hexadecimal digits of BLAKE3 over the names and contents of all files in these folders: enough to notice changes.
pub fn hash(crate_folder: &Path, sources: &[&str]) -> String {
    let mut files = Vec::new();
    for source in sources {
        collect(&crate_folder.join(source), &mut files);
    }
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let name = file.strip_prefix(crate_folder).unwrap_or(&file);
        let name = name.to_string_lossy().replace('\\', "/");
        let contents = std::fs::read(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        // Each part is preceded by its length, so that different files cannot give the same bytes.
        for part in [name.as_bytes(), &contents] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
    }
    hasher.finalize().to_hex()[..16].to_string()
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(path.to_path_buf()),
    }
}
