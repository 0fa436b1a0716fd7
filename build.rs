//! Tells the program which sources it was built from, so that data of one build are never taken for those of another.

use std::path::{Path, PathBuf};

/// What decides the frames of a reach.
const DATA_SOURCES: [&str; 5] = ["sim/src", "sim/arms", "recording/src", "src/dataset.rs", "Cargo.lock"];
/// What decides the figures that are computed from them: all of these folders but [`NOT_ANALYSIS`]. A new file counts
/// unless it is listed there.
pub const ANALYSIS_SOURCES: [&str; 2] = ["classifier/src", "src/command/reproduce"];
/// What only shows results, or tests the program.
pub const NOT_ANALYSIS: [&str; 10] = [
    "classifier/src/report",
    "src/command/reproduce/figures",
    "src/command/reproduce/page",
    "src/command/reproduce/page.rs",
    "src/command/reproduce/skin_map.rs",
    "src/command/reproduce/tables",
    "src/command/reproduce/tables.rs",
    "src/command/reproduce/tests",
    "src/command/reproduce/words",
    "src/command/reproduce/words.rs",
];

fn main() {
    for (variable, sources) in [
        ("UNDERBRUSH_DATA_SOURCES", &DATA_SOURCES[..]),
        ("UNDERBRUSH_ANALYSIS_SOURCES", &ANALYSIS_SOURCES[..]),
    ] {
        for source in sources {
            println!("cargo::rerun-if-changed={source}");
        }
        println!("cargo::rustc-env={variable}={:016x}", hash(&files_of(sources)));
    }
}

/// The files in these folders, sorted, without those that decide nothing.
pub fn files_of(sources: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for source in sources {
        collect(Path::new(source), &mut files);
    }
    files.sort();
    files
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if NOT_ANALYSIS.iter().any(|other| path == Path::new(other)) {
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
