//! Tells the program which sources it was built from, so that data of one build are never taken for those of another.

use std::path::{Path, PathBuf};

/// What decides the frames of a reach.
const DATA_SOURCES: [&str; 5] = [
    "../sim/src",
    "../sim/arms",
    "../recording/src",
    "src/dataset.rs",
    "../Cargo.lock",
];
/// What decides the results that are computed from them: this crate and the classifier, whole.
const ANALYSIS_SOURCES: [&str; 2] = ["src", "../classifier/src"];

fn main() {
    for (variable, sources) in [
        ("UNDERBRUSH_DATA_SOURCES", &DATA_SOURCES[..]),
        ("UNDERBRUSH_ANALYSIS_SOURCES", &ANALYSIS_SOURCES[..]),
    ] {
        for source in sources {
            println!("cargo::rerun-if-changed={source}");
        }
        println!("cargo::rustc-env={variable}={}", hash(&files_of(sources)));
    }
}

/// All files in these folders, sorted.
fn files_of(sources: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for source in sources {
        collect(Path::new(source), &mut files);
    }
    files.sort();
    files
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(path.to_path_buf()),
    }
}

/// 16 hexadecimal digits of BLAKE3 over names and contents: enough to notice changes.
fn hash(files: &[PathBuf]) -> String {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let name = file.to_string_lossy().replace('\\', "/");
        let contents = std::fs::read(file).unwrap_or_else(|error| panic!("{name}: {error}"));
        // Each part follows its length, so that no two lists of files can run together to the same bytes.
        for part in [name.as_bytes(), &contents] {
            hasher.update(&(part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
    }
    hasher.finalize().to_hex()[..16].to_string()
}
