//! `underbrush reach`.

use underbrush_recording::disk::read_recording;

use crate::support::{scenes, underbrush};

#[test]
fn a_seed_decides_a_reach() {
    // Pins: the same seed gives the same recording byte for byte, another seed or index another clutter.
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "leaf.toml", scenes::FEW_LEAVES);
    let run = |name: &str, seed: &str, index: &str| {
        let path = folder.path().join(name);
        underbrush!["reach", scene, "--seed", seed, "--index", index, "--out", path].success();
        path
    };
    let [first, again] = ["first.parquet", "again.parquet"].map(|name| run(name, "7", "0"));
    assert!(std::fs::read(&first).unwrap() == std::fs::read(again).unwrap());
    let first = read_recording(first).unwrap();
    for (name, seed, index) in [("seed.parquet", "8", "0"), ("index.parquet", "7", "1")] {
        let other = read_recording(run(name, seed, index)).unwrap();
        assert_ne!(first.objects, other.objects);
        assert_ne!(first.goals[0].position_world, other.goals[0].position_world);
    }
}

#[test]
fn a_reach_is_that_of_its_campaign() {
    // Pins: reach --seed --index shows the very reach that generate records.
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let [set, file] = ["set", "reach.parquet"].map(|name| folder.path().join(name));
    underbrush!["generate", scene, "--reaches", "2", "--seed", "6", "--out", set].success();
    underbrush!["reach", scene, "--seed", "6", "--index", "1", "--out", file].success();
    let in_set = underbrush_recording::disk::Dataset::open(set)
        .unwrap()
        .read_reach(1)
        .unwrap();
    assert!(in_set == read_recording(file).unwrap());
}

#[test]
fn the_report_agrees_with_the_recording() {
    // Pins: goals reached, true contact, contacts and peak force of --json are those of the file written; the picture is an SVG.
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let [file, picture] = ["reach.parquet", "reach.svg"].map(|name| folder.path().join(name));
    let report = underbrush!["reach", scene, "--out", file, "--picture", picture, "--json"].json();
    let recording = read_recording(file).unwrap();
    assert_eq!(report["goals_reached"], recording.goal_outcomes().reached);
    assert_eq!(report["goals"].as_array().unwrap().len(), recording.goals.len());
    assert_eq!(
        report["touched_frames"]["forearm"],
        recording.touched_frames()["forearm"]
    );
    assert_eq!(report["contacts"], recording.contacts.len());
    let peak = recording
        .contacts
        .iter()
        .map(|contact| contact.peak_force_n)
        .fold(0.0, f64::max);
    assert_eq!(report["peak_contact_force_n"], peak);
    assert_eq!(report["simulated_s"], recording.frames.len() as f64 / 100.0);
    assert!(std::fs::read_to_string(picture).unwrap().starts_with("<svg"));
}

#[test]
fn the_blind_controller_pushes_on() {
    // Pins: --controller takes the place of the scene's own and is what the recording names.
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let file = folder.path().join("reach.parquet");
    let report = underbrush!["reach", scene, "--controller", "blind", "--out", file, "--json"].json();
    assert_eq!(report["controller"], "blind");
    assert_eq!(read_recording(file).unwrap().controller, "blind");
}
