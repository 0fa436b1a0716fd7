//! Tells the program which sources it was built from, so that data of one build are never taken for those of another.

use std::path::{Path, PathBuf};

/// What decides the frames of a reach.
const DATA_SOURCES: [&str; 5] = ["sim/src", "sim/arms", "recording/src", "src/dataset.rs", "Cargo.lock"];
/// What decides the figures that are computed from them.
const ANALYSIS_SOURCES: [&str; 5] = [
    "classifier/src",
    "src/command/reproduce/data.rs",
    "src/command/reproduce/campaign.rs",
    "src/command/reproduce/splits.rs",
    "src/command/reproduce/ablation.rs",
];
/// What only draws them.
const DRAWING_SOURCES: &str = "classifier/src/report";

fn main() {
    for (variable, sources) in [
        ("UNDERBRUSH_DATA_SOURCES", &DATA_SOURCES[..]),
        ("UNDERBRUSH_ANALYSIS_SOURCES", &ANALYSIS_SOURCES[..]),
    ] {
        let mut files = Vec::new();
        for source in sources {
            println!("cargo::rerun-if-changed={source}");
            collect(Path::new(source), &mut files);
        }
        files.sort();
        println!("cargo::rustc-env={variable}={:016x}", hash(&files));
    }
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if path == Path::new(DRAWING_SOURCES) {
        return;
    }
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(path.to_path_buf()),
    }
}

/// FNV-1a over names and contents: it has to notice changes, not attacks.
fn hash(files: &[PathBuf]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in files {
        let name = file.to_string_lossy().replace('\\', "/");
        let contents = std::fs::read(file).unwrap_or_else(|error| panic!("{name}: {error}"));
        for byte in name.bytes().chain([0]).chain(contents).chain([0]) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
    hash
}
