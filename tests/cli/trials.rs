//! `underbrush trials`.

use std::collections::BTreeMap;

use underbrush_classifier::trial::TrialOptions;
use underbrush_recording::disk::{Dataset, read_recording, read_trials};
use underbrush_recording::{Frame, Recording, TaxelReading};

use crate::support::fixture::{fixture, recording_with_trials};
use crate::support::{table, underbrush};

/// Whether a taxel senses more than the program's default threshold.
fn is_in_contact(reading: &TaxelReading) -> bool {
    reading.sensed_force_n > TrialOptions::default().threshold_n
}

/// Tests that both tables hold the same trials to the last bit, and that the CSV has the documented columns.
#[test]
fn csv_and_parquet_hold_the_same_rows() {
    let fixture = fixture();
    let text = std::fs::read_to_string(fixture.table_csv()).unwrap();
    assert_eq!(
        text.lines().next(),
        Some(concat!(
            "trial,category,reach,patch,taxel,time_s,force_n,motion_m,",
            "region_taxels,region_largest_force_n,region_force_sum_n,touched"
        ))
    );
    let (csv, parquet) = (read_trials(fixture.table_csv()).unwrap(), read_trials(fixture.table_parquet()).unwrap());
    assert_eq!(csv, parquet);
    let samples: usize = csv.iter().map(|trial| trial.samples.len()).sum();
    assert_eq!(text.lines().count(), 1 + samples);
}

/// Tests that a reading that nothing presses has no true force, not even −0, which would give it a row of truth.
#[test]
fn readings_of_nothing_have_no_true_force() {
    let dataset = Dataset::open(fixture().dataset()).unwrap();
    let mut readings = 0;
    for episode in 0..dataset.episodes().len() {
        for reading in dataset.read_reach(episode).unwrap().frames.iter().flat_map(|frame| &frame.taxels) {
            let [tangent, binormal] = reading.true_shear_force_n;
            let forces = [reading.true_normal_force_n, tangent, binormal];
            if reading.object.is_none() && forces == [0.0; 3] {
                assert_eq!(forces.map(f64::to_bits), [0; 3], "{reading:?}");
                readings += 1;
            }
        }
    }
    assert!(readings > 0);
}

/// Tests that the force of each row is the sensed force of its taxel at that time, that each sensed force of the patch
/// is in exactly one row, and that the category is the category of an object of the reach.
#[test]
fn rows_are_what_the_taxels_sensed() {
    let fixture = fixture();
    let dataset = Dataset::open(fixture.dataset()).unwrap();
    let rows = table::rows(&std::fs::read_to_string(fixture.table_csv()).unwrap());
    let mut by_reach: BTreeMap<usize, Vec<_>> = BTreeMap::new();
    for row in rows {
        assert_eq!(row["patch"], "forearm");
        by_reach.entry(row["reach"].parse().unwrap()).or_default().push(row);
    }
    for episode in 0..dataset.episodes().len() {
        let recording = dataset.read_reach(episode).unwrap();
        let mut sensed = BTreeMap::new();
        for frame in &recording.frames {
            for reading in frame.taxels.iter().filter(|reading| reading.patch == 0 && is_in_contact(reading)) {
                sensed.insert((frame.time_s.to_bits(), u32::from(reading.taxel)), reading.sensed_force_n);
            }
        }
        for row in by_reach.remove(&episode).unwrap_or_default() {
            let key = (row["time_s"].parse::<f64>().unwrap().to_bits(), row["taxel"].parse().unwrap());
            assert_eq!(sensed.remove(&key), Some(row["force_n"].parse().unwrap()), "{row:?}");
            let categories: Vec<&str> = recording.objects.iter().map(|object| object.category.name()).collect();
            assert!(row["category"].is_empty() || categories.contains(&row["category"].as_str()), "{row:?}");
        }
        assert!(sensed.is_empty(), "{} sensed forces of reach {episode} are in no trial", sensed.len());
    }
    assert!(by_reach.is_empty(), "reaches that are not in the data set: {:?}", by_reach.keys());
}

fn recordings(dataset: &Dataset) -> Vec<Recording> {
    let reaches = 0..dataset.episodes().len();
    reaches.map(|reach| dataset.read_reach(reach).unwrap()).collect()
}

fn frame_at(recording: &Recording, time_s: f64) -> &Frame {
    let place = recording.frames.partition_point(|frame| frame.time_s < time_s);
    assert_eq!(recording.frames[place].time_s, time_s);
    &recording.frames[place]
}

/// Tests that contact motion is the length of the taxel's path in the world frame since the contact began, computed
/// here from the poses of its patch.
#[test]
fn motion_is_the_length_of_the_path() {
    let fixture = fixture();
    let dataset = Dataset::open(fixture.dataset()).unwrap();
    let recordings = recordings(&dataset);
    let mut compared = 0;
    for trial in read_trials(fixture.table_csv()).unwrap() {
        let recording = &recordings[trial.reach.unwrap() as usize];
        let position_link = recording.layout.patches[0].taxels[trial.taxel.unwrap() as usize].position_link;
        let (mut length_m, mut last) = (0.0, None);
        for sample in &trial.samples {
            let frame = frame_at(recording, sample.time_s);
            let position_world = frame.patch_pose_world[0].transform_point(position_link);
            length_m += position_world.distance(last.unwrap_or(position_world));
            last = Some(position_world);
            // The sums have the same terms in the same order.
            assert_eq!(sample.motion_m, Some(length_m), "trial {}", trial.trial);
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared} samples");
}

/// Tests that the table holds for each sample whether an object truly pressed its taxel, and that the program reports
/// how many trials were never touched.
#[test]
fn untouched_trials_are_counted() {
    let fixture = fixture();
    let dataset = Dataset::open(fixture.dataset()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.csv");
    let text = underbrush!["trials", fixture.dataset(), "--out", file, "--labels", "environment"].success();
    let trials = read_trials(&file).unwrap();
    let recordings = recordings(&dataset);
    let mut untouched = 0;
    for trial in &trials {
        let recording = &recordings[trial.reach.unwrap() as usize];
        let mut pressed = false;
        for sample in &trial.samples {
            let frame = frame_at(recording, sample.time_s);
            let truly = frame.taxels.iter().any(|reading| {
                reading.patch == 0 && Some(u32::from(reading.taxel)) == trial.taxel && reading.true_normal_force_n > 0.0
            });
            assert_eq!(sample.touched, Some(truly), "trial {}", trial.trial);
            pressed |= truly;
        }
        untouched += usize::from(!pressed);
    }
    assert!(untouched > 0 && untouched < trials.len(), "{untouched} of {}", trials.len());
    assert!(text.contains(&format!("{untouched} of the trials w")) && text.contains("never touched"), "{text}");
}

/// Tests that components join taxels, that --min-samples and --threshold-n drop trials, and that components are
/// refused on the flipper, whose taxels form no grid.
#[test]
fn components_are_fewer_and_options_hold() {
    let fixture = fixture();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trials.csv");
    let taxels = read_trials(fixture.table_csv()).unwrap();
    underbrush!["trials", fixture.dataset(), "--out", file, "--by", "component"].success();
    let components = read_trials(&file).unwrap();
    assert!((1..taxels.len()).contains(&components.len()), "{} components", components.len());
    underbrush!["trials", fixture.dataset(), "--out", file, "--force", "--min-samples", "5"].success();
    let long = taxels.iter().filter(|trial| trial.samples.len() >= 5).count();
    assert_eq!(read_trials(&file).unwrap().len(), long);
    underbrush!["trials", fixture.dataset(), "--out", file, "--force", "--threshold-n", "0.2"].success();
    let strong = read_trials(&file).unwrap();
    assert!(strong.iter().flat_map(|trial| &trial.samples).all(|sample| sample.force_n > 0.2));
    underbrush!["trials", fixture.dataset(), "--out", file, "--force", "--by", "component", "--patch", "flipper"]
        .refused(&["flipper", "grid", "use trials by taxel"]);
}

/// Tests that trials by taxel, also those of a table, and frames are warned of if the model was fitted to trials by component, and
/// that trials by component are not.
#[test]
fn models_of_components_are_for_components() {
    let (set, folder) = (fixture().dataset(), tempfile::tempdir().unwrap());
    let model = folder.path().join("model.json");
    underbrush!["train", set, "--by", "component", "--classifier", "naive-bayes", "--out", model].success();
    let warning = "trials by taxel, but the model was fitted to trials by component";
    let [taxels, components] = ["taxel", "component"].map(|by| {
        let table = folder.path().join(format!("{by}.csv"));
        underbrush!["trials", set, "--by", by, "--out", table].success();
        table
    });
    let page = folder.path().join("page.html");
    for command in [
        underbrush!["classify", model, set],
        underbrush!["evaluate", set, "--model", model],
        underbrush!["score", model, taxels],
        underbrush!["classify", model, set, "--online"],
        underbrush!["replay", set, "--model", model, "--out", page],
    ] {
        assert!(command.stderr.contains(warning), "{}", command.stderr);
    }
    for sound in [underbrush!["classify", model, set, "--by", "component"], underbrush!["score", model, components]] {
        assert!(sound.status == 0 && !sound.stderr.contains("was fitted to"), "{}", sound.stderr);
    }
}

/// Tests that trials can be extracted from a single recording, numbered from 0.
#[test]
fn a_recording_gives_the_trials_of_its_reach() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("reach.parquet");
    let trials = recording_with_trials(&fixture().trunk_scene(), &file);
    assert!(trials.iter().map(|trial| trial.trial).eq(0..trials.len() as u64));
    let frames = read_recording(&file).unwrap().frames;
    let sensed = |frame: &underbrush_recording::Frame| {
        frame.taxels.iter().filter(|reading| reading.patch == 0 && is_in_contact(reading)).count()
    };
    let samples: usize = trials.iter().map(|trial| trial.samples.len()).sum();
    assert_eq!(samples, frames.iter().map(sensed).sum::<usize>());
}

/// Tests that a table is written again unchanged, even if its first trial lacks a channel that a later one has.
#[test]
fn a_table_whose_channels_have_gaps_is_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["in.csv", "out.csv"].map(|name| folder.path().join(name));
    let rows = "0,leaf,0,0.2,\n0,leaf,0.01,0.3,\n1,leaf,1,0.2,0.5\n1,leaf,1.01,0.2,\n";
    std::fs::write(&from, format!("trial,category,time_s,force_n,shear_n\n{rows}")).unwrap();
    underbrush!["trials", from, "--out", to, "--min-samples", "1"].success();
    assert_eq!(read_trials(to).unwrap(), read_trials(from).unwrap());
}
