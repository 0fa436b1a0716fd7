use hdf5_pure::File;
use underbrush_recording::Recording;

use super::write_hdf5;
use crate::ExchangeError;
use crate::example::{file, reach};

fn write(path: &std::path::Path, reaches: &[Recording]) -> Result<(), ExchangeError> {
    write_hdf5::<ExchangeError>(path, |writer| reaches.iter().try_for_each(|reach| writer.push(reach)))
}

/// Tests that every number of a reach comes back from the file unchanged, in the shapes that robomimic reads.
#[test]
fn every_number_comes_back() {
    let (_folder, path) = file("reaches.hdf5");
    let reaches = [reach("leaves", 0, 300), reach("trunks", 5, 41)];
    write(&path, &reaches).unwrap();
    let file = File::open(&path).unwrap();
    for (number, recording) in reaches.iter().enumerate() {
        let frames = recording.frames.len();
        let table = |name: &str, width: usize| {
            let dataset = file.dataset(&format!("data/demo_{number}/{name}")).unwrap();
            let shape = if width == 0 { vec![frames as u64] } else { vec![frames as u64, width as u64] };
            assert_eq!(dataset.shape().unwrap(), shape, "{name}");
            assert!(dataset.is_chunked(), "{name}");
            dataset.read_f64().unwrap()
        };
        let flat = |row: &dyn Fn(&underbrush_recording::Frame) -> Vec<f64>| -> Vec<f64> {
            recording.frames.iter().flat_map(row).collect()
        };
        assert_eq!(table("actions", 2), flat(&|frame| frame.equilibrium_angle_rad.clone()));
        let state = |frame: &underbrush_recording::Frame| {
            [frame.joint_angle_rad.clone(), frame.joint_velocity_rad_per_s.clone()].concat()
        };
        assert_eq!(table("states", 4), flat(&state));
        assert_eq!(table("obs/joint_pos", 2), flat(&|frame| frame.joint_angle_rad.clone()));
        assert_eq!(table("obs/joint_vel", 2), flat(&|frame| frame.joint_velocity_rad_per_s.clone()));
        assert_eq!(table("obs/joint_torque", 2), flat(&|frame| frame.joint_torque_nm.clone()));
        let pose = |frame: &underbrush_recording::Frame| frame.end_effector_pose_world;
        assert_eq!(table("obs/eef_pos", 3), flat(&|frame| pose(frame).position.to_array().into()));
        assert_eq!(table("obs/eef_quat", 4), flat(&|frame| pose(frame).orientation.to_array().into()));
        assert_eq!(table("obs/goal_pos", 3), flat(&|frame| frame.goal_position_world.to_array().into()));
        for (patch, name, taxels) in [(0, "obs/tactile_sleeve", 6), (1, "obs/tactile_tip", 2)] {
            let forces = |frame: &underbrush_recording::Frame| {
                let mut forces = vec![0.0; taxels];
                let readings = frame.taxels.iter().filter(|reading| reading.patch == patch);
                readings.for_each(|reading| forces[usize::from(reading.taxel)] = reading.sensed_force_n);
                forces
            };
            let forces = flat(&forces);
            assert!(forces.iter().any(|force| *force > 0.0), "no force on {name}");
            assert_eq!(table(name, taxels), forces);
        }
        // The first goal was reached at 0.4 s; the second was not.
        let rewarded: Vec<_> = (0..frames).filter(|frame| table("rewards", 0)[*frame] != 0.0).collect();
        assert_eq!(rewarded, [40]);
        let done: Vec<_> = (0..frames).filter(|frame| table("dones", 0)[*frame] != 0.0).collect();
        assert_eq!(done, [frames - 1]);
    }
}

/// Tests that a scene called like a part does not add its demonstrations to the mask of that part.
#[test]
fn a_scene_called_train_has_a_mask_of_its_own() {
    let (_folder, path) = file("reaches.hdf5");
    let reaches: Vec<_> = (0..10).map(|index| reach("train", index, 5)).collect();
    write(&path, &reaches).unwrap();
    let file = File::open(&path).unwrap();
    let count = |name: &str| file.dataset(&format!("mask/{name}")).unwrap().read_string().unwrap().len();
    assert_eq!((count("train"), count("valid"), count("train-scene")), (9, 1, 10));
}

/// Tests that fewer than ten demonstrations are split, too: the last is in valid, unless it is the only one.
#[test]
fn few_demonstrations_are_split() {
    for count in [1, 2, 9] {
        let (_folder, path) = file("reaches.hdf5");
        let reaches: Vec<_> = (0..count).map(|index| reach("leaves", index, 5)).collect();
        write(&path, &reaches).unwrap();
        let file = File::open(&path).unwrap();
        let mask = |name: &str| file.dataset(&format!("mask/{name}")).unwrap().read_string().unwrap();
        let names = |numbers: std::ops::Range<u64>| numbers.map(|number| format!("demo_{number}")).collect::<Vec<_>>();
        if count == 1 {
            assert!(file.dataset("mask/valid").is_err());
            assert_eq!(mask("train"), names(0..1));
        } else {
            assert_eq!(mask("train"), names(0..count - 1));
            assert_eq!(mask("valid"), names(count - 1..count));
        }
        assert_eq!(mask("leaves"), names(0..count));
    }
}

/// Tests attributes and masks: each demonstration is in either train or valid, and in the mask of its scene.
#[test]
fn attributes_and_masks_are_as_robomimic_reads_them() {
    let (_folder, path) = file("reaches.hdf5");
    let scene = |index: u64| if index < 7 { "leaves" } else { "trunks" };
    let reaches: Vec<_> = (0..12).map(|index| reach(scene(index), index, 5 + index as usize)).collect();
    write(&path, &reaches).unwrap();
    let file = File::open(&path).unwrap();
    let data = file.group("data").unwrap().attrs().unwrap();
    let frames: usize = reaches.iter().map(|reach| reach.frames.len()).sum();
    assert_eq!(data["total"].as_i64(), Some(frames as i64));
    let environment: serde_json::Value = serde_json::from_str(data["env_args"].as_str().unwrap()).unwrap();
    assert_eq!((&environment["env_name"], &environment["type"]), (&"underbrush".into(), &2.into()));
    for (number, reach) in reaches.iter().enumerate() {
        let attributes = file.group(&format!("data/demo_{number}")).unwrap().attrs().unwrap();
        assert_eq!(attributes["num_samples"].as_i64(), Some(reach.frames.len() as i64));
        assert_eq!(attributes["scene"].as_str(), Some(reach.scene.as_str()));
        assert_eq!(attributes["reach_index"].as_u64(), Some(reach.reach_index));
        assert_eq!(attributes["seed"].as_u64(), Some(u64::MAX));
    }
    let mask = |name: &str| file.dataset(&format!("mask/{name}")).unwrap().read_string().unwrap();
    let names = |numbers: std::ops::Range<usize>| numbers.map(|number| format!("demo_{number}")).collect::<Vec<_>>();
    assert_eq!(mask("valid"), ["demo_9"]);
    assert_eq!(mask("train"), [names(0..9), names(10..12)].concat());
    assert_eq!(mask("leaves"), names(0..7));
    assert_eq!(mask("trunks"), names(7..12));
}

/// Tests that an export that fails leaves no file, and that the same reaches give the same bytes.
#[test]
fn a_failed_export_leaves_nothing() {
    let (folder, path) = file("reaches.hdf5");
    let failed = write_hdf5::<ExchangeError>(&path, |writer| {
        writer.push(&reach("leaves", 0, 20))?;
        let error = underbrush_recording::InputError::new("x", "x", "x", "x", "x");
        Err(error.into())
    });
    assert!(matches!(failed, Err(ExchangeError::Input(_))));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    write(&path, &[reach("leaves", 0, 20)]).unwrap();
    let once = std::fs::read(&path).unwrap();
    write(&path, &[reach("leaves", 0, 20)]).unwrap();
    assert_eq!(once, std::fs::read(&path).unwrap());
}
