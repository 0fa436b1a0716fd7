use std::path::Path;
use std::{fs, thread};

use super::Change;
use super::dataset::{begin, contents, copy, make, plan, recordings, scene_text};
use crate::disk::{DatasetPlan, DatasetWriter, FileText, make_room};
use crate::{DiskError, Recording};

/// Tests that reaches staged in reverse order, or by three threads at once, give the same bytes.
#[test]
fn order_and_threads_of_staging_leave_no_trace() {
    let folder = tempfile::tempdir().unwrap();
    let [forwards, backwards, threads] = ["a", "b", "c"].map(|name| folder.path().join(name));
    make(&forwards);
    let recordings = recordings();
    let writer = begin(&backwards, false);
    for (position, recording) in recordings.iter().enumerate().rev() {
        writer.stage(position, recording).unwrap();
    }
    writer.finish().unwrap();
    let writer = begin(&threads, false);
    thread::scope(|scope| {
        for part in 0..3 {
            let (writer, recordings) = (&writer, &recordings);
            scope.spawn(move || {
                for position in (part..recordings.len()).step_by(3) {
                    writer.stage(position, &recordings[position]).unwrap();
                }
            });
        }
    });
    writer.finish().unwrap();
    assert_eq!(contents(&forwards), contents(&backwards));
    assert_eq!(contents(&forwards), contents(&threads));
}

/// Tests that after a crash complete reaches are kept, truncated ones are run again, and the set ends in the same
/// bytes.
#[test]
fn a_crash_costs_only_the_reaches_in_progress() {
    let folder = tempfile::tempdir().unwrap();
    let [unbroken, broken] = ["a", "b"].map(|name| folder.path().join(name));
    make(&unbroken);
    let recordings = recordings();
    let writer = begin(&broken, false);
    assert_eq!(writer.missing().unwrap(), [0, 1, 2, 3, 4]);
    for position in [3, 1, 4] {
        writer.stage(position, &recordings[position]).unwrap();
    }
    assert!(matches!(DatasetWriter::create(&broken, plan(), true), Err(DiskError::InUse { .. })));
    drop(writer);
    let staged = |name: &str| broken.join("incomplete").join(name);
    // Reach 1 is truncated, reach 2 has no checksum yet, and a temporary file of reach 0 is left.
    let bytes = fs::read(staged("reach-000001.bin")).unwrap();
    fs::write(staged("reach-000001.bin"), &bytes[..bytes.len() - 8]).unwrap();
    fs::write(staged("reach-000002.bin"), &bytes).unwrap();
    fs::write(staged(".underbrush-unfinished-x"), b"PAR1").unwrap();
    assert!(matches!(DatasetWriter::create(&broken, plan(), false), Err(DiskError::Unfinished { .. })));
    let writer = begin(&broken, true);
    assert_eq!(writer.missing().unwrap(), [0, 1, 2]);
    let writer = match writer.finish() {
        Err(DiskError::ReachesMissing { count: 3, first: 0, .. }) => begin(&broken, true),
        other => panic!("{other:?}"),
    };
    for position in writer.missing().unwrap() {
        writer.stage(position, &recordings[position]).unwrap();
    }
    writer.finish().unwrap();
    assert_eq!(contents(&unbroken), contents(&broken));
}

/// Tests that a killed finish can be resumed whatever files it had written or removed, and ends in the same bytes.
#[test]
fn a_finish_killed_at_any_file_is_taken_up_again() {
    let folder = tempfile::tempdir().unwrap();
    let [unbroken, staged] = ["a", "b"].map(|name| folder.path().join(name));
    make(&unbroken);
    let whole = contents(&unbroken);
    let writer = begin(&staged, false);
    for (position, recording) in recordings().iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    drop(writer);
    let resume_and_compare = |dir: &Path| {
        begin(dir, true).finish().unwrap();
        assert_eq!(contents(dir), whole);
    };
    // Killed while writing: any number of files is complete, and the next has a temporary name or is truncated.
    let files: Vec<_> = whole.iter().filter(|(name, _)| !name.ends_with("info.json")).collect();
    for written in 0..=files.len() {
        let dir = folder.path().join(format!("writing-{written}"));
        copy(&staged, &dir);
        for (place, (name, bytes)) in files.iter().enumerate().take(written + 1) {
            let path = dir.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, if place < written { &bytes[..] } else { &bytes[..bytes.len() / 2] }).unwrap();
        }
        resume_and_compare(&dir);
    }
    // Killed while removing: the set is complete, and a part of `incomplete/` is left.
    let rest: Vec<_> = contents(&staged).into_keys().filter(|name| !name.ends_with("plan.json")).collect();
    for removed in 0..=rest.len() {
        let dir = folder.path().join(format!("removing-{removed}"));
        copy(&staged, &dir);
        copy(&unbroken, &dir);
        for name in &rest[..removed] {
            fs::remove_file(dir.join(name)).unwrap();
        }
        resume_and_compare(&dir);
    }
}

/// Tests that a file that the operating system cannot read is an error and does not count as missing. Reaches in
/// complete files are no longer staged; if they counted as missing, they would be removed and simulated again. In this
/// test, the unreadable file is a folder.
#[test]
fn what_cannot_be_read_is_not_thrown_away() {
    for name in ["assembled.bin", "reach-000001.json", "reach-000001.bin"] {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("set");
        let writer = begin(&dir, false);
        for (position, recording) in recordings().iter().enumerate() {
            writer.stage(position, recording).unwrap();
        }
        drop(writer);
        let path = dir.join("incomplete").join(name);
        let _ = fs::remove_file(&path);
        fs::create_dir(&path).unwrap();
        let before = contents(&dir);
        let named = |error: DiskError| match error {
            DiskError::Io { path, .. } => path,
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(named(begin(&dir, true).missing().unwrap_err()), path);
        assert_eq!(named(begin(&dir, true).finish().unwrap_err()), path);
        assert_eq!(contents(&dir), before, "{name}");
    }
}

/// Tests that neither a finished set nor other files can be overwritten, with or without resume. Resuming a finished
/// set with another plan reports the difference.
#[test]
fn a_folder_that_holds_something_else_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [finished, foreign, crashed] = ["a", "b", "c"].map(|name| folder.path().join(name));
    make(&finished);
    fs::create_dir_all(foreign.join("data")).unwrap();
    fs::write(foreign.join("data/thesis.txt"), "precious").unwrap();
    for resume in [false, true] {
        let again = DatasetWriter::create(&finished, plan(), resume);
        assert!(matches!(again, Err(DiskError::Finished { .. })));
        let over = DatasetWriter::create(&foreign, plan(), resume);
        assert!(matches!(over, Err(DiskError::FolderNotEmpty { .. })));
    }
    let mut other = plan();
    other.episodes[1].reach_index = 8;
    match DatasetWriter::create(&finished, other, true) {
        Err(DiskError::PlanDiffers { field, .. }) => assert_eq!(field, "episodes[1].reach_index"),
        other => panic!("{other:?}"),
    }
    // A crash before the plan was stored leaves nothing to resume and nothing to lose.
    fs::create_dir_all(crashed.join("incomplete")).unwrap();
    fs::write(crashed.join("incomplete/lock"), "").unwrap();
    fs::write(crashed.join("incomplete/.underbrush-unfinished-x"), "{").unwrap();
    make(&crashed);
    assert_eq!(contents(&crashed), contents(&finished));
}

/// Tests that a set of another program with LeRobot's files, which have the same names, is not overwritten.
#[test]
fn a_lerobot_set_of_another_program_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("set");
    make(&dir);
    for own in ["truth", "controller"] {
        fs::remove_dir_all(dir.join(own)).unwrap();
    }
    for own in ["meta/provenance.json", "meta/checksums.json", "meta/taxels.parquet"] {
        // One of them still tells that the set is ours.
        assert!(matches!(DatasetWriter::create(&dir, plan(), false), Err(DiskError::Finished { .. })), "{own}");
        fs::remove_file(dir.join(own)).unwrap();
    }
    let before = contents(&dir);
    make_room(&dir, true).unwrap();
    for resume in [false, true] {
        let over = DatasetWriter::create(&dir, plan(), resume);
        assert!(matches!(over, Err(DiskError::FolderNotEmpty { .. })), "{over:?}");
    }
    assert_eq!(contents(&dir), before);
}

/// Tests that removing a set can be interrupted at any file and repeated, and that the set is unfinished meanwhile.
#[test]
fn a_removal_that_was_interrupted_can_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    make(&whole);
    let names: Vec<_> = contents(&whole).into_keys().filter(|name| !name.ends_with("info.json")).collect();
    for removed in 0..=names.len() {
        let dir = folder.path().join(removed.to_string());
        copy(&whole, &dir);
        fs::create_dir(dir.join("incomplete")).unwrap();
        fs::rename(dir.join("meta/info.json"), dir.join("incomplete/plan.json")).unwrap();
        for name in &names[..removed] {
            fs::remove_file(dir.join(name)).unwrap();
        }
        assert!(matches!(DatasetWriter::create(&dir, plan(), false), Err(DiskError::Unfinished { .. })));
        make_room(&dir, true).unwrap();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0, "{removed}");
    }
}

/// Tests that another set, whose folders are linked into a set, loses nothing when that set is removed.
#[cfg(unix)]
#[test]
fn links_to_folders_of_another_set_are_removed_alone() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, linked] = ["whole", "linked"].map(|name| folder.path().join(name));
    make(&whole);
    copy(&whole, &linked);
    for part in ["data", "meta"] {
        fs::remove_dir_all(linked.join(part)).unwrap();
        std::os::unix::fs::symlink(whole.join(part), linked.join(part)).unwrap();
    }
    let before = contents(&whole);
    make_room(&linked, true).unwrap();
    assert_eq!(contents(&whole), before);
    assert_eq!(fs::read_dir(&linked).unwrap().count(), 0);
}

/// Tests that a file that somebody has put into a folder of the set is not removed when the set is continued, assembled or
/// overwritten, and that the error names it. Hidden files, which file managers leave behind, are removed.
#[test]
fn files_of_others_in_a_set_are_not_removed() {
    for name in ["data/notes.txt", "meta/episodes.jsonl", "truth/taxels/chunk-000/file-000.parquet.bak"] {
        let folder = tempfile::tempdir().unwrap();
        let (dir, file) = (folder.path().join("set"), folder.path().join("set").join(name));
        let writer = begin(&dir, false);
        for (position, recording) in recordings().iter().enumerate() {
            writer.stage(position, recording).unwrap();
        }
        for place in [&file, &dir.join("data/.directory")] {
            fs::create_dir_all(place.parent().unwrap()).unwrap();
            fs::write(place, "precious").unwrap();
        }
        let before = contents(&dir);
        let refused = |error: DiskError| match error {
            DiskError::Input(error) => assert_eq!(error.file, file),
            other => panic!("{name}: {other:?}"),
        };
        refused(writer.finish().unwrap_err());
        refused(DatasetWriter::create(&dir, plan(), true).unwrap_err());
        refused(make_room(&dir, true).unwrap_err());
        assert_eq!(contents(&dir), before, "{name}");
        fs::remove_file(&file).unwrap();
        begin(&dir, true).finish().unwrap().verify().unwrap();
        assert!(!dir.join("data/.directory").exists());
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "precious").unwrap();
        let before = contents(&dir);
        refused(make_room(&dir, true).unwrap_err());
        assert_eq!(contents(&dir), before, "{name}");
        fs::remove_file(&file).unwrap();
        make_room(&dir, true).unwrap();
        assert!(contents(&dir).is_empty(), "{name}");
        // A hidden file beside the set is in nobody's way, and stays.
        fs::write(dir.join(".gitattributes"), "*.parquet filter=lfs\n").unwrap();
        make(&dir);
        make_room(&dir, true).unwrap();
        assert_eq!(contents(&dir).len(), 1, "{name}");
    }
}

/// Tests that resuming with other options cannot mix two campaigns, and that the error names the difference.
#[test]
fn another_plan_is_refused_by_its_first_differing_field() {
    let changes: [Change<DatasetPlan>; 7] = [
        ("provenance.seed", |plan| plan.provenance.seed = 8),
        ("provenance.options.step_s", |plan| plan.provenance.options.clear()),
        ("provenance.scenes[\"trunks\"].file.blake3", |plan| {
            plan.provenance.scenes[1] = scene_text("trunks", "[trunk] # changed\n");
        }),
        // The skin follows from the arm's files, so the file is named and not its consequence.
        ("provenance.arms[\"cody\"].files[\"cody.toml\"].blake3", |plan| {
            plan.provenance.arms[0].files[0] = FileText::new("cody.toml", "soft\n");
            plan.layout.patches[0].link = "elsewhere".into();
        }),
        ("episodes[4]", |plan| plan.episodes.truncate(4)),
        ("layout.patches[\"forearm\"].grid.wraps", |plan| {
            plan.layout.patches[0].grid.as_mut().unwrap().wraps = false;
        }),
        ("rate_hz", |plan| plan.rate_hz = 50.0),
    ];
    let folder = tempfile::tempdir().unwrap();
    drop(begin(folder.path(), false));
    for (expected, change) in changes {
        let mut other = plan();
        change(&mut other);
        match DatasetWriter::create(folder.path(), other, true) {
            Err(DiskError::PlanDiffers { field, stored, given, .. }) => {
                assert_eq!(field, expected);
                assert_ne!(stored, given);
            }
            other => panic!("{expected}: {other:?}"),
        }
    }
    assert_eq!(begin(folder.path(), true).missing().unwrap().len(), 5);
}

/// Tests that a recording of another scene, seed, reach, controller or skin is not accepted into a set.
#[test]
fn only_the_planned_reach_can_be_staged() {
    let changes: [Change<Recording>; 8] = [
        ("scene", |r| r.scene = "trunks".into()),
        ("reach_index", |r| r.reach_index = 5),
        ("seed", |r| r.seed = 8),
        ("controller", |r| r.controller = "ijrr-foliage".into()),
        ("rate_hz", |r| r.rate_hz = 50.0),
        ("joint_names", |r| r.joint_names[0] = "hip".into()),
        ("layout", |r| r.layout.patches[1].link = "hand".into()),
        ("frames", |r| r.frames.clear()),
    ];
    let folder = tempfile::tempdir().unwrap();
    let writer = begin(folder.path(), false);
    for (expected, change) in changes {
        let mut other = recordings().swap_remove(0);
        change(&mut other);
        match writer.stage(0, &other) {
            Err(DiskError::Unwritable { field, .. }) => assert_eq!(field, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
    assert!(matches!(writer.stage(5, &recordings()[0]), Err(DiskError::NoSuchReach { .. })));
    let mut empty = plan();
    empty.episodes.clear();
    let refused = DatasetWriter::create(folder.path().join("none"), empty, false);
    assert!(matches!(refused, Err(DiskError::Unwritable { field, .. }) if field == "episodes"));
}
