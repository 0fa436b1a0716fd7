use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::reach;
use crate::disk::{
    ArmText, Dataset, DatasetPlan, DatasetWriter, FileText, PlannedEpisode, Provenance, SceneText, write_recording,
};
use crate::stop::{Stopped, listen};
use crate::{DiskError, InputError, NamedStop, Outcome, Recording, SafetyStop};

/// Numbers of frames of the reaches of the test set. The third is longer than one batch.
const FRAMES: [usize; 5] = [40, 25, 1500, 10, 33];
/// Reach indices of the test set: a shard of a larger campaign.
const REACHES: [u64; 5] = [4, 9, 14, 19, 24];

pub(crate) fn recordings() -> Vec<Recording> {
    let mut recordings: Vec<_> = REACHES.iter().zip(FRAMES).map(|(&index, frames)| reach(index, frames)).collect();
    // A reach without objects, goals and contacts.
    let quiet = &mut recordings[3];
    quiet.frames.iter_mut().for_each(|frame| frame.taxels.clear());
    quiet.objects.clear();
    quiet.bodies.truncate(1);
    for frame in &mut quiet.frames {
        frame.contact_force_world.fill(glam::DVec3::ZERO);
        frame.contact_points.clear();
    }
    quiet.goals.clear();
    quiet.contacts.clear();
    recordings[1].scene = "trunks".into();
    // A contact of a bare link.
    let bare = &mut recordings[1].contacts[0];
    bare.patch = None;
    bare.link = "upper arm".into();
    // An aborted reach.
    let stopped = &mut recordings[2].goals[0];
    stopped.outcome = Outcome::Aborted;
    stopped.safety_stop =
        Some(SafetyStop { object: Some(0), link: "forearm_link".into(), patch: Some(0), force_n: 101.5 });
    recordings
}

pub(super) fn scene_text(name: &str, text: &str) -> SceneText {
    SceneText { name: name.into(), reaches: 25, arm: 0, file: FileText::new(format!("{name}.toml"), text) }
}

pub(super) fn plan() -> DatasetPlan {
    let recordings = recordings();
    let first = &recordings[0];
    let episode = |recording: &Recording| PlannedEpisode {
        scene: recording.scene.clone(),
        task: format!("reach the goal through {}", recording.scene),
        reach_index: recording.reach_index,
    };
    DatasetPlan {
        provenance: Provenance {
            program: "underbrush".into(),
            program_version: "0.1.0".into(),
            arithmetic: String::new(),
            engine: "an engine 1.0".into(),
            options: BTreeMap::from([("step_s".to_string(), 0.004.into())]),
            scenes: vec![scene_text("foliage", "[leaf]\n"), scene_text("trunks", "[trunk]\n")],
            arms: vec![ArmText {
                name: "cody".into(),
                files: vec![FileText::new("cody.toml", "stiff\n"), FileText::new("cody.urdf", "<robot/>\n")],
            }],
            seed: 7,
            controller: "cody-2013".into(),
            controller_parameters: BTreeMap::new(),
            shard: None,
        },
        robot: "cody".into(),
        rate_hz: 100.0,
        joint_names: first.joint_names.clone(),
        layout: first.layout.clone(),
        categories: Vec::new(),
        episodes: recordings.iter().map(episode).collect(),
    }
}

pub(crate) fn begin(dir: &Path, resume: bool) -> DatasetWriter {
    let mut writer = DatasetWriter::create(dir, plan(), resume).unwrap();
    // So small that the reaches fill several data files.
    writer.staging.bytes_per_file = 60_000;
    writer
}

/// A finished set of [`recordings`].
pub(crate) fn make(dir: &Path) -> Dataset {
    let writer = begin(dir, false);
    for (position, recording) in recordings().iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    writer.finish().unwrap()
}

/// Copies a folder with its subfolders, as a crash at this moment would leave it.
pub(crate) fn copy(from: &Path, to: &Path) {
    for (name, bytes) in contents(from) {
        let path = to.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

/// All files below a folder with their bytes.
pub(crate) fn contents(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fn gather(root: &Path, folder: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                gather(root, &path, files);
            } else {
                files.insert(path.strip_prefix(root).unwrap().to_path_buf(), fs::read(&path).unwrap());
            }
        }
    }
    let mut files = BTreeMap::new();
    gather(dir, dir, &mut files);
    files
}

/// The content of `meta/info.json`.
pub(crate) fn info(dir: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(dir.join("meta/info.json")).unwrap()).unwrap()
}

fn input_error<T: std::fmt::Debug>(result: Result<T, DiskError>) -> InputError {
    match result {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Tests that frames, ground truth, layout and metadata of a reach survive a round trip through a data set.
#[test]
fn every_reach_comes_back_as_it_was_staged() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    for (index, recording) in recordings().iter().enumerate() {
        assert_eq!(&set.read_reach(index).unwrap(), recording, "reach {index}");
    }
    assert!(matches!(set.read_reach(5), Err(DiskError::NoSuchReach { index: 5, count: 5, .. })));
    assert_eq!(set.plan().layout, plan().layout);
    assert_eq!(set.plan().provenance, plan().provenance);
    set.verify().unwrap();
}

/// Tests that the check of all files and reads end on a thread that is told to stop.
#[test]
fn a_thread_that_is_told_to_stop_ends_checks_and_reads() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    std::thread::scope(|scope| {
        scope.spawn(|| {
            listen(Arc::new(AtomicBool::new(true)));
            assert!(catch_unwind(AssertUnwindSafe(|| set.verify())).unwrap_err().is::<Stopped>());
            assert!(catch_unwind(AssertUnwindSafe(|| set.read_reach(0))).unwrap_err().is::<Stopped>());
        });
    });
}

/// Tests the columns that LeRobot reads and those that this program adds.
#[test]
fn episodes_say_where_their_frames_are_and_how_they_ended() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let episodes = set.episodes();
    let starts: Vec<_> = episodes.iter().map(|episode| episode.first_index).collect();
    assert_eq!(starts, [0, 40, 65, 1565, 1575]);
    assert_eq!(episodes.iter().map(|episode| episode.frames).collect::<Vec<_>>(), FRAMES);
    let files: Vec<_> = episodes.iter().map(|episode| episode.file_index).collect();
    assert!(files.is_sorted() && files[0] == 0 && files[4] > 0, "several data files in order: {files:?}");
    let outcomes: Vec<_> = episodes.iter().map(|episode| episode.outcome).collect();
    let (reached, stuck, aborted) = (Outcome::Reached, Outcome::Stuck, Outcome::Aborted);
    assert_eq!(outcomes, [reached, stuck, aborted, reached, reached]);
    let stops: Vec<_> = episodes.iter().map(|episode| episode.safety_stop.clone()).collect();
    let stop = NamedStop {
        object_index: Some(0),
        object_kind: "trunk".into(),
        link: "forearm_link".into(),
        patch: Some("forearm".into()),
        force_n: 101.5,
    };
    assert_eq!(stops, [None, None, Some(stop), None, None]);
    assert_eq!(episodes.iter().map(|episode| episode.goal_outcomes.reached).collect::<Vec<_>>(), [1, 0, 0, 0, 1]);
    // In episode 1 only a bare link has contact, in episode 3 nothing.
    let touched_frames = |patch: &str| -> Vec<u32> {
        let frames = episodes.iter().map(|episode| episode.touched_frames[patch]);
        frames.collect()
    };
    assert_eq!(touched_frames("forearm"), [39, 0, 1499, 0, 32]);
    assert_eq!(touched_frames("tip"), [0; 5]);
    assert_eq!(episodes.iter().map(|episode| episode.reach_index).collect::<Vec<_>>(), REACHES);
    assert_eq!(episodes[1].task, "reach the goal through trunks");
    let info = info(folder.path());
    let counts = ["total_episodes", "total_frames", "total_tasks"].map(|name| info[name].as_u64().unwrap());
    assert_eq!((counts, set.plan().rate_hz), ([5, 1608, 2], 100.0));
    assert_eq!(info["features"]["observation.tactile.forearm"]["shape"], serde_json::json!([12]));
    assert_eq!(info["features"]["observation.tactile.tip"]["dtype"], "float32");
    assert!(fs::read_to_string(folder.path().join("meta/info.json")).unwrap().contains("\"fps\": 100,"));
}

/// Tests stats.json against sums over the recordings themselves.
#[test]
fn statistics_cover_every_feature_number_by_number() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let text = fs::read_to_string(folder.path().join("meta/stats.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (name, feature) in info(folder.path())["features"].as_object().unwrap() {
        let width = feature["shape"][0].as_u64().unwrap() as usize;
        for figure in ["min", "max", "mean", "std", "q01", "q50", "q99"] {
            assert_eq!(stats[name][figure].as_array().unwrap().len(), width, "{name} {figure}");
        }
    }
    let frames: Vec<_> = recordings().into_iter().flat_map(|recording| recording.frames).collect();
    let sensed = |frame: &crate::Frame| {
        let reading = frame.taxels.iter().find(|reading| (reading.patch, reading.taxel) == (0, 6));
        reading.map_or(0.0, |reading| reading.sensed_force_n)
    };
    let forces: Vec<f64> = frames.iter().map(sensed).collect();
    let mean = forces.iter().sum::<f64>() / forces.len() as f64;
    let column = &stats["observation.tactile.forearm"];
    assert!((column["mean"][6].as_f64().unwrap() - mean).abs() < 1e-12);
    assert_eq!(column["max"][6].as_f64(), forces.iter().copied().reduce(f64::max));
    assert_eq!(column["max"][7].as_f64(), Some(0.0));
    assert_eq!(stats["index"]["max"][0].as_f64(), Some(1607.0));
}

/// Tests that each kind of folder that is not a data set has its own message and remedy.
#[test]
fn a_folder_that_is_no_finished_set_is_named_for_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("set");
    assert_eq!(input_error(Dataset::open(&dir)).found, "no such folder");
    fs::create_dir(&dir).unwrap();
    assert_eq!(input_error(Dataset::open(&dir)).found, "no meta/info.json");
    let file = folder.path().join("reach.parquet");
    write_recording(&file, &reach(0, 5)).unwrap();
    assert_eq!(input_error(Dataset::open(&file)).found, "a file");
    let unfinished = folder.path().join("unfinished");
    begin(&unfinished, false).stage(0, &recordings()[0]).unwrap();
    let error = Dataset::open(&unfinished).unwrap_err();
    assert!(matches!(error, DiskError::Unfinished { .. }) && error.to_string().contains("--resume"), "{error}");
    make(&dir);
    let (info, provenance) = (dir.join("meta/info.json"), dir.join("meta/provenance.json"));
    for (path, from, to, field) in [
        (&info, "v3.0", "v2.1", "codebase_version"),
        (&provenance, "underbrush-dataset/3", "underbrush-dataset/2", "format"),
        (&info, "\"total_frames\": 1608", "\"total_frames\": 1609", "checksum"),
        (&info, "{", "", "JSON"),
    ] {
        let text = fs::read_to_string(path).unwrap();
        fs::write(path, text.replacen(from, to, 1)).unwrap();
        let error = input_error(Dataset::open(&dir));
        assert_eq!((error.field.as_str(), &error.file), (field, path));
        fs::write(path, text).unwrap();
    }
    Dataset::open(&dir).unwrap();
    fs::rename(&provenance, folder.path().join("aside")).unwrap();
    assert_eq!(input_error(Dataset::open(&dir)).found, "a data set without meta/provenance.json");
    let others = ["checksums.json", "taxels.parquet"].map(|name| dir.join("meta").join(name));
    for name in &others {
        fs::rename(name, name.with_extension("aside")).unwrap();
    }
    assert_eq!(input_error(Dataset::open(&dir)).found, "a LeRobot data set of another program");
    for name in &others {
        fs::rename(name.with_extension("aside"), name).unwrap();
    }
    fs::rename(folder.path().join("aside"), &provenance).unwrap();
    fs::remove_file(&info).unwrap();
    assert_eq!(input_error(Dataset::open(&dir)).found, "a data set without meta/info.json");
}

/// Tests that a missing or truncated file, and a file with one changed bit, is named.
#[test]
fn every_missing_torn_or_changed_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let files = contents(folder.path());
    assert!(files.len() > 11, "{:?}", files.keys());
    for (name, bytes) in &files {
        let path = folder.path().join(name);
        let check = || Dataset::open(folder.path()).and_then(|set| set.verify());
        let mut changed = bytes.clone();
        changed[bytes.len() / 2] ^= 1;
        for spoiled in [&bytes[..bytes.len() / 2], &changed] {
            fs::write(&path, spoiled).unwrap();
            assert_eq!(input_error(check()).file, path);
        }
        fs::remove_file(&path).unwrap();
        // Without these the folder cannot be recognized as a finished set.
        let decisive =
            ["info.json", "provenance.json", "checksums.json"].iter().any(|decisive| name.ends_with(decisive));
        assert_eq!(input_error(check()).file, if decisive { folder.path() } else { &path });
        fs::write(&path, bytes).unwrap();
        check().unwrap();
    }
}

/// Tests that no file is read before its hash has been checked. If a bit of a large table flips after the set was
/// opened, reading the first reach that needs the table is an error that names it, without a call of `verify`.
#[test]
fn a_changed_table_is_named_when_it_is_first_read() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let set = Dataset::open(folder.path()).unwrap();
    let path = folder.path().join("data/chunk-000/file-000.parquet");
    let mut bytes = fs::read(&path).unwrap();
    let place = bytes.len() / 3;
    bytes[place] ^= 4;
    fs::write(&path, &bytes).unwrap();
    let error = input_error(set.read_reach(0));
    assert_eq!((error.file.as_path(), error.field.as_str()), (path.as_path(), "checksum"));
    bytes[place] ^= 4;
    fs::write(&path, &bytes).unwrap();
    assert_eq!(set.read_reach(0).unwrap(), recordings()[0]);
}

/// Tests that the check of the checksums covers all files. An empty list, a missing entry, an entry that was changed
/// together with its file, and files that are not in the list are found when the set is opened.
#[test]
fn the_list_of_checksums_cannot_be_changed_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    let list = folder.path().join("meta/checksums.json");
    let whole = fs::read_to_string(&list).unwrap();
    let stored: serde_json::Value = serde_json::from_str(&whole).unwrap();
    let statistics = folder.path().join("meta/stats.json");
    type Edit = fn(&mut serde_json::Map<String, serde_json::Value>);
    let edits: [(&str, Edit); 3] = [
        ("emptied", |files| files.clear()),
        ("an entry removed", |files| drop(files.remove("meta/stats.json"))),
        ("a size changed", |files| files["meta/stats.json"]["bytes"] = 2.into()),
    ];
    for (what, edit) in edits {
        let mut edited = stored.clone();
        edit(edited["files"].as_object_mut().unwrap());
        fs::write(&list, edited.to_string()).unwrap();
        assert_eq!(input_error(Dataset::open(folder.path())).file, list, "{what}");
    }
    // The same list in other bytes.
    for other in [format!("{whole}\n"), whole.replacen("  ", "   ", 1), stored.to_string()] {
        fs::write(&list, other).unwrap();
        let error = input_error(Dataset::open(folder.path()));
        assert_eq!((&error.file, error.found.as_str()), (&list, "the right list in other bytes"));
    }
    // A file that is not in the list is found even if the list matches its own hash.
    let hash = blake3::hash(b"").to_hex().to_string();
    fs::write(&list, format!("{:#}\n", serde_json::json!({"blake3": hash, "files": {}}))).unwrap();
    let error = input_error(Dataset::open(folder.path()));
    assert_eq!(error.found, "a file that meta/checksums.json does not list");
    fs::write(&list, &whole).unwrap();
    for extra in ["data/chunk-000/file-001.parquet.bak", "meta/notes.txt", "data/extra.parquet", "truth/x.parquet"] {
        let path = folder.path().join(extra);
        let made_folder = !path.parent().unwrap().exists();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::copy(&statistics, &path).unwrap();
        assert_eq!(input_error(Dataset::open(folder.path())).file, path);
        fs::remove_file(&path).unwrap();
        if made_folder {
            fs::remove_dir(path.parent().unwrap()).unwrap();
        }
    }
    // Hidden files come from file managers, and readers of data sets ignore them.
    fs::write(folder.path().join("data/.directory"), "").unwrap();
    Dataset::open(folder.path()).unwrap().verify().unwrap();
}
