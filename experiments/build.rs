//! Computes two hashes for the crate, one of the sources that decide data and one of the sources that decide results.
//! They keep a build from using data or cached results of another build.

use std::env::var_os;
use std::path::{Path, PathBuf};

/// Only the versions of `LIBRARIES` in this file are hashed. Each package has a lock file of its own, which lists fewer
/// crates. Even so, sets made by a package and by the repository must have the same version.
const LOCK_FILE: &str = "Cargo.lock";

/// The libraries whose versions may change what a data set holds: those with which the simulator and the recordings
/// compute, draw, read and write, and the ones below these that compute.
pub const LIBRARIES: &[&str] = &[
    "blake3",
    "csv",
    "fearless_simd",
    "glam",
    "glamx",
    "libm",
    "matrixmultiply",
    "nalgebra",
    "num-traits",
    "parquet",
    "parry3d-f64",
    "postcard",
    "rand",
    "rand_chacha",
    "rand_core",
    "rand_distr",
    "rapier3d-f64",
    "robust",
    "roxmltree",
    "serde",
    "serde_json",
    "simba",
    "toml",
    "wide",
    "zmij",
    "zstd",
];

/// The folders of the crates whose sources are hashed, by name. Crates that this one depends on report their folders
/// through cargo (`links` in their manifests). This works in the repository and with packages from a registry.
pub struct Folders {
    /// This crate.
    pub experiments: PathBuf,
    /// The simulator.
    pub sim: PathBuf,
    /// The recordings and data sets.
    pub recording: PathBuf,
    /// The classifiers.
    pub classifier: PathBuf,
}

impl Folders {
    /// The sources that decide the frames of a reach. The versions of libraries come from the lock file.
    pub fn data_sources(&self) -> Vec<(&'static str, PathBuf)> {
        vec![
            (LOCK_FILE, self.lock()),
            ("experiments/src/dataset", self.experiments.join("src/dataset")),
            ("experiments/src/dataset.rs", self.experiments.join("src/dataset.rs")),
            ("recording/src", self.recording.join("src")),
            ("sim/arms", self.sim.join("arms")),
            ("sim/src", self.sim.join("src")),
        ]
    }

    /// The sources that decide the results computed from the frames: all of this crate and all of the classifier. The
    /// report is a separate crate and is not included. Experiment files and scenes are hashed when they are read.
    pub fn analysis_sources(&self) -> Vec<(&'static str, PathBuf)> {
        vec![("classifier/src", self.classifier.join("src")), ("experiments/src", self.experiments.join("src"))]
    }

    /// The lock file with the versions of all dependencies: in a package the one that it was published with, otherwise
    /// the one of the workspace.
    fn lock(&self) -> PathBuf {
        let packaged = self.experiments.join("Cargo.lock");
        if packaged.exists() {
            return packaged;
        }
        self.experiments.join("../Cargo.lock")
    }
}

fn main() {
    let folder = |variable| PathBuf::from(var_os(variable).unwrap_or_else(|| panic!("{variable} is not set")));
    let folders = Folders {
        experiments: folder("CARGO_MANIFEST_DIR"),
        sim: folder("DEP_UNDERBRUSH_SIM_FOLDER"),
        recording: folder("DEP_UNDERBRUSH_RECORDING_FOLDER"),
        classifier: folder("DEP_UNDERBRUSH_CLASSIFIER_FOLDER"),
    };
    println!("cargo::rerun-if-changed=build.rs");
    for (variable, sources) in [
        ("UNDERBRUSH_DATA_SOURCES", folders.data_sources()),
        ("UNDERBRUSH_ANALYSIS_SOURCES", folders.analysis_sources()),
    ] {
        for (_, source) in &sources {
            println!("cargo::rerun-if-changed={}", source.display());
        }
        println!("cargo::rustc-env={variable}={}", hash(&sources));
    }
}

/// 16 hexadecimal digits of BLAKE3 over the names and contents of all files in these folders: enough to notice changes.
pub fn hash(sources: &[(&'static str, PathBuf)]) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, source) in sources {
        let mut files = Vec::new();
        collect(source, &mut files);
        files.sort();
        for file in files {
            let below = file.strip_prefix(source).unwrap_or(&file);
            let path = Path::new(name).join(below);
            let path = path.to_string_lossy().replace('\\', "/");
            let mut contents = std::fs::read(&file).unwrap_or_else(|error| panic!("{path}: {error}"));
            if *name == LOCK_FILE {
                contents = versions(&String::from_utf8_lossy(&contents)).into_bytes();
            }
            // Each part is preceded by its length, so that different files cannot give the same bytes.
            for part in [path.as_bytes(), &contents] {
                hasher.update(&(part.len() as u64).to_le_bytes());
                hasher.update(part);
            }
        }
    }
    hasher.finalize().to_hex()[..16].to_string()
}

/// Name and version of each of `LIBRARIES` in the text of a lock file, one in a line.
fn versions(lock: &str) -> String {
    let packages = lock.split("[[package]]").filter_map(|package| {
        let value = |key| package.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
        let (name, version) = (value("name")?.trim_matches('"'), value("version")?);
        LIBRARIES.contains(&name).then(|| format!("{name} {version}\n"))
    });
    packages.collect()
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| collect(&entry.path(), files)),
        Err(_) => files.push(path.to_path_buf()),
    }
}
