use std::fs;

use proptest::prelude::*;

use super::generated::any_recording;
use super::{Change, reach};
use crate::disk::{read_recording, write_recording};
use crate::{DiskError, InputError, Recording};

fn misread(result: Result<Recording, DiskError>) -> InputError {
    match result {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Tests that reading gives back what was written, down to the sign of a zero, for any layout.
    #[test]
    fn any_recording_comes_back_bit_for_bit(recording in any_recording()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("reach.parquet");
        write_recording(&path, &recording).unwrap();
        let back = read_recording(&path).unwrap();
        // Compared as text, because −0 == 0.
        prop_assert_eq!(format!("{back:?}"), format!("{recording:?}"));
    }
}

/// Tests that more frames than fit in one batch survive a round trip, and that writing is deterministic.
#[test]
fn a_long_reach_comes_back_and_gives_the_same_bytes_twice() {
    let folder = tempfile::tempdir().unwrap();
    let recording = reach(3, 2500);
    let paths = ["a.parquet", "b.parquet"].map(|name| folder.path().join(name));
    for path in &paths {
        write_recording(path, &recording).unwrap();
    }
    assert_eq!(read_recording(&paths[0]).unwrap(), recording);
    assert_eq!(fs::read(&paths[0]).unwrap(), fs::read(&paths[1]).unwrap());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no temporary file is left");
}

/// Tests that every rule is checked before a byte is written, and that the error names the field.
#[test]
fn a_recording_that_breaks_a_rule_is_not_written() {
    let spoiled: [Change<Recording>; 21] = [
        ("rate_hz", |r| r.rate_hz = 0.0),
        ("joint_names", |r| r.joint_names.clear()),
        ("layout.patches[1].name", |r| r.layout.patches[1].name = "forearm".into()),
        ("layout.patches[0].name", |r| r.layout.patches[0].name = "fore/arm".into()),
        ("layout.patches[0].grid", |r| r.layout.patches[0].taxels.truncate(11)),
        ("layout.patches[1].taxels", |r| r.layout.patches[1].taxels.clear()),
        ("frames[4].joint_torque_nm", |r| r.frames[4].joint_torque_nm = vec![f64::NAN, 0.0]),
        ("frames[4].joint_angle_rad", |r| r.frames[4].joint_angle_rad.push(0.0)),
        ("frames[9].taxels", |r| r.frames[9].taxels.swap(0, 1)),
        ("frames[9].taxels[2]", |r| r.frames[9].taxels[2].taxel = 1),
        ("frames[9].taxels[0]", |r| r.frames[9].taxels[0].object = Some(2)),
        ("contacts[0].last_frame", |r| r.contacts[0].last_frame = 20),
        ("contacts[0].peak_force_n", |r| r.contacts[0].peak_force_n = -1.0),
        ("goals[0].end_time_s", |r| r.goals[0].start_time_s = 1e3),
        // The same time twice, a step back, and a missing frame.
        ("frames[5].time_s", |r| r.frames[5].time_s = r.frames[4].time_s),
        ("frames[5].time_s", |r| r.frames[5].time_s = 0.001),
        ("frames[10].time_s", |r| {
            r.contacts.clear();
            r.frames.remove(10);
        }),
        ("frames[4].end_effector_pose_world", |r| {
            r.frames[4].end_effector_pose_world.orientation = glam::DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
        }),
        ("frames[4].patch_pose_world", |r| {
            r.frames[4].patch_pose_world[1].orientation.w += 1e-3;
        }),
        ("frames[9].taxels[1].sensed_force_n", |r| {
            r.frames[9].taxels[1].sensed_force_n = -0.01;
        }),
        ("frames[9].taxels[0].true_normal_force_n", |r| {
            r.frames[9].taxels[0].true_normal_force_n = -0.01;
        }),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reach.parquet");
    for (expected, spoil) in spoiled {
        let mut recording = reach(0, 20);
        spoil(&mut recording);
        match write_recording(&path, &recording) {
            Err(DiskError::Unwritable { field, .. }) => assert_eq!(field, expected),
            other => panic!("{expected}: {other:?}"),
        }
        assert!(!path.exists());
    }
}

/// Tests that a reading of zeros without an object is refused, because dense columns could not give it back.
#[test]
fn a_silent_taxel_is_not_written() {
    let mut recording = reach(0, 20);
    let reading = &mut recording.frames[9].taxels[1];
    (reading.true_normal_force_n, reading.true_shear_force_n, reading.sensed_force_n) = (0.0, [0.0, -0.0], 0.0);
    let folder = tempfile::tempdir().unwrap();
    write_recording(&folder.path().join("kept.parquet"), &recording).unwrap();
    recording.frames[9].taxels[1].object = None;
    let refused = write_recording(&folder.path().join("refused.parquet"), &recording);
    assert!(matches!(refused, Err(DiskError::Unwritable { field, .. }) if field == "frames[9].taxels[1]"));
}

/// Tests that a recording truncated at any length gives an error that names the file, never a panic or a shorter
/// recording.
#[test]
fn a_torn_file_is_named_whatever_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reach.parquet");
    write_recording(&path, &reach(0, 20)).unwrap();
    let bytes = fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(97) {
        fs::write(&path, &bytes[..length]).unwrap();
        assert_eq!(misread(read_recording(&path)).file, path);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Tests that no damaged byte in data, metadata or footer makes the reader panic, even if the hash in the file was
    /// computed again, so that the decoder sees the damage.
    #[test]
    fn a_damaged_file_never_panics(place in any::<prop::sample::Index>(), mask in 1..=255u8) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("reach.parquet");
        write_recording(&path, &reach(0, 5)).unwrap();
        let mut bytes = fs::read(&path).unwrap();
        let place = place.index(bytes.len());
        bytes[place] ^= mask;
        fs::write(&path, &bytes).unwrap();
        prop_assert!(read_recording(&path).is_err());
        let mut file = fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
        let _no_place_for_it = crate::disk::footer::seal(&mut file);
        let _either = read_recording(&path);
    }
}

/// Tests that a Parquet file of another program is distinguished from a truncated one.
#[test]
fn a_foreign_parquet_file_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.parquet");
    crate::disk::write_trials(&path, &[]).unwrap();
    let error = misread(read_recording(&path));
    assert_eq!(error.field, "underbrush.format");
    assert!(error.remedy.contains("underbrush"));
    let absent = misread(read_recording(&folder.path().join("absent.parquet")));
    assert_eq!(absent.found, "no such file");
}
