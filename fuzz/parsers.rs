//! The parsers of input from users and other programs, each as a function of bytes.
//!
//! The fuzz targets beside this file call them with bytes that libFuzzer makes up, and the tests of the command line
//! replay the corpus. A parser may return a value or an error; a panic that reaches the caller is a finding. So is an
//! exhausted stack or memory.

use std::collections::BTreeMap;
use std::fs;
use std::io::BufReader;
use std::path::Path;

use underbrush_classifier::any_model;
use underbrush_exchange::import::{Mapping, import};
use underbrush_exchange::live::{LineParser, Lines};
use underbrush_experiments::definition::Experiment;
use underbrush_experiments::suite::Suite;
use underbrush_recording::disk::{Dataset, read_recording, read_trials};
use underbrush_sim::arm::mesh::read_triangles;
use underbrush_sim::arm::{Arm, ArmSource, load_layout};
use underbrush_sim::scene::Scene;

/// Calls a parser; returns whether it read the bytes.
pub type Parser = fn(&[u8]) -> bool;

/// All parsers, by the name of their fuzz target.
#[allow(dead_code, reason = "each fuzz target calls one")]
pub const PARSERS: [(&str, Parser); 15] = [
    ("arm", arm),
    ("data_set", data_set),
    ("experiment", experiment),
    ("frame_lines", frame_lines),
    ("import_csv", import_csv),
    ("mapping", mapping),
    ("mesh", mesh),
    ("model", model),
    ("recording", recording),
    ("scene", scene),
    ("skin", skin),
    ("suite", suite),
    ("trials_csv", trials_csv),
    ("trials_parquet", trials_parquet),
    ("urdf", urdf),
];

/// Calls `read` with a file that holds the bytes, in a folder that also holds the seeds' arm and its scene under two
/// names.
fn in_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> bool) -> bool {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scenes = [("thicket.toml", THICKET), ("grove.toml", THICKET)];
    for (name, text) in FINGER.into_iter().chain(scenes) {
        fs::write(folder.path().join(name), text).expect("a file of the seeds");
    }
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a file");
    read(&path)
}

/// The arm of the seeds: its file, its URDF and its skin.
const FINGER: [(&str, &str); 3] = [
    ("finger.toml", include_str!("seeds/finger.toml")),
    ("finger.urdf", include_str!("seeds/finger.urdf")),
    ("finger.skin.toml", include_str!("seeds/finger.skin.toml")),
];

/// A scene with that arm.
const THICKET: &str = include_str!("seeds/thicket.toml");

/// The arm of the seeds with one of its files replaced.
fn finger_with(replaced: &str, bytes: &[u8]) -> bool {
    let Ok(own) = std::str::from_utf8(bytes) else {
        return false;
    };
    let files = FINGER.map(|(name, text)| ArmSource {
        name: name.to_owned(),
        text: if name == replaced { own } else { text }.to_owned(),
    });
    Arm::from_files(&files).is_ok()
}

/// The file of an arm.
pub fn arm(bytes: &[u8]) -> bool {
    finger_with("finger.toml", bytes)
}

/// The URDF of an arm.
pub fn urdf(bytes: &[u8]) -> bool {
    finger_with("finger.urdf", bytes)
}

/// The skin of an arm, parsed alone and with the arm.
pub fn skin(bytes: &[u8]) -> bool {
    in_file("skin.toml", bytes, |path| load_layout(path).is_ok());
    finger_with("finger.skin.toml", bytes)
}

/// A mesh, in every format.
pub fn mesh(bytes: &[u8]) -> bool {
    let read = |name: &&str| in_file(name, bytes, |path| read_triangles(path).is_ok());
    ["part.stl", "part.obj", "part.dae"].iter().filter(|name| read(name)).count() > 0
}

/// A scene.
pub fn scene(bytes: &[u8]) -> bool {
    let text = std::str::from_utf8(bytes);
    text.is_ok_and(|text| Scene::parse("scene.toml", text.to_owned()).is_ok())
}

/// A regression suite whose scene is that of the seeds.
pub fn suite(bytes: &[u8]) -> bool {
    in_file("suite.toml", bytes, |path| Suite::load(path).is_ok())
}

/// An experiment whose scene is that of the seeds.
pub fn experiment(bytes: &[u8]) -> bool {
    in_file("experiment.toml", bytes, |path| Experiment::load(path).is_ok())
}

/// A model of trials or of touch.
pub fn model(bytes: &[u8]) -> bool {
    in_file("model.json", bytes, |path| any_model::load(path).is_ok())
}

/// A table of trials as CSV.
pub fn trials_csv(bytes: &[u8]) -> bool {
    in_file("trials.csv", bytes, |path| read_trials(path).is_ok())
}

/// A table of trials as Parquet.
pub fn trials_parquet(bytes: &[u8]) -> bool {
    in_file("trials.parquet", bytes, |path| read_trials(path).is_ok())
}

/// A recording. Its checksum is corrected first, so that the reader does not stop there.
pub fn recording(bytes: &[u8]) -> bool {
    in_file("reach.parquet", &sealed(bytes), |path| read_recording(path).is_ok())
}

/// The bytes of a Parquet file with the correct hash under the key `underbrush.blake3`.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    const DIGITS: usize = 64;
    let mut bytes = bytes.to_vec();
    let entry = [&b"underbrush.blake3"[..], &[0x18, DIGITS as u8]].concat();
    let found = bytes.windows(entry.len()).rposition(|window| window == entry);
    let Some(start) = found.map(|place| place + entry.len()) else {
        return bytes;
    };
    if start + DIGITS <= bytes.len() {
        bytes[start..start + DIGITS].fill(b'0');
        let hash = blake3::hash(&bytes).to_hex();
        bytes[start..start + DIGITS].copy_from_slice(hash.as_bytes());
    }
    bytes
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_bytes!(concat!("set/", $name)).as_slice())),*]
    };
}

/// A data set of one reach of the seeds, without its checksums.
pub const SET: [(&str, &[u8]); 17] = files![
    "README.md",
    "controller/map/chunk-000/file-000.parquet",
    "data/chunk-000/file-000.parquet",
    "meta/episodes/chunk-000/file-000.parquet",
    "meta/info.json",
    "meta/provenance.json",
    "meta/stats.json",
    "meta/tasks.parquet",
    "meta/taxels.parquet",
    "truth/bodies/chunk-000/file-000.parquet",
    "truth/contact_points/chunk-000/file-000.parquet",
    "truth/contacts/chunk-000/file-000.parquet",
    "truth/goals/chunk-000/file-000.parquet",
    "truth/objects/chunk-000/file-000.parquet",
    "truth/patches/chunk-000/file-000.parquet",
    "truth/poses/chunk-000/file-000.parquet",
    "truth/taxels/chunk-000/file-000.parquet",
];

/// A data set with one file replaced. The first byte is the number of the file in [`SET`], and the other bytes are its
/// new content. The checksums are corrected, so that the reader does not stop there.
pub fn data_set(bytes: &[u8]) -> bool {
    let Some((number, own)) = bytes.split_first() else {
        return false;
    };
    let mut files: BTreeMap<&str, &[u8]> = SET.into();
    let (replaced, _) = SET[usize::from(*number) % SET.len()];
    files.insert(replaced, own);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (mut list, mut sums) = (String::new(), Vec::new());
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder of the set");
        fs::write(path, bytes).expect("a file of the set");
        let hash = blake3::hash(bytes).to_hex().to_string();
        list.push_str(&format!("{name} {} {hash}\n", bytes.len()));
        sums.push(format!(
            "    \"{name}\": {{\n      \"bytes\": {},\n      \"blake3\": \"{hash}\"\n    }}",
            bytes.len()
        ));
    }
    let hash = blake3::hash(list.as_bytes()).to_hex().to_string();
    // The reader takes no other bytes than those that the program writes.
    let checksums = format!("{{\n  \"blake3\": \"{hash}\",\n  \"files\": {{\n{}\n  }}\n}}\n", sums.join(",\n"));
    fs::write(folder.path().join("meta/checksums.json"), checksums).expect("the checksums");
    let Ok(set) = Dataset::open(folder.path()) else {
        return false;
    };
    let whole = set.verify().is_ok() && set.peak_contact_forces_n().is_ok();
    // Limited, because the number of episodes comes from a file.
    whole && (0..set.episodes().len().min(8)).all(|episode| set.read_reach(episode).is_ok())
}

/// Lines of a live stream, for a model that needs poses.
pub fn frame_lines(bytes: &[u8]) -> bool {
    let files = FINGER.map(|(name, text)| ArmSource { name: name.to_owned(), text: text.to_owned() });
    let layout = Arm::from_files(&files).expect("the arm of the seeds").skin.layout;
    let mut parser = LineParser::new(layout, Some(0));
    let mut lines = Lines::new(BufReader::new(bytes), parser.max_bytes());
    let mut all = true;
    while let Some((number, line)) = lines.next_line().expect("bytes in memory") {
        all &= line.is_ok_and(|text| parser.parse(number, text).is_ok());
    }
    all
}

/// The mapping of an import.
pub fn mapping(bytes: &[u8]) -> bool {
    in_file("mapping.toml", bytes, |path| {
        let Ok(mapping) = Mapping::load(path) else {
            return false;
        };
        let seeds = [("log.csv", &include_bytes!("corpus/import_csv/palm.csv")[..])];
        for (name, bytes) in seeds {
            let file = path.with_file_name(name);
            fs::write(&file, bytes).expect("a file to import");
            let _ = import(&file, &mapping, false);
        }
        true
    })
}

/// Imports a file with a mapping.
fn imported(name: &str, bytes: &[u8], mapping: &str) -> bool {
    in_file(name, bytes, |path| {
        let file = path.with_file_name("mapping.toml");
        fs::write(&file, mapping).expect("the mapping");
        let mapping = Mapping::load(&file).expect("the seeds' mapping");
        import(path, &mapping, false).is_ok()
    })
}

/// A robot's CSV file.
pub fn import_csv(bytes: &[u8]) -> bool {
    imported("log.csv", bytes, include_str!("corpus/mapping/csv.toml"))
}
