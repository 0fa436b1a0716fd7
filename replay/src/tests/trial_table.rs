use std::path::Path;

use underbrush_recording::disk::write_trials;
use underbrush_recording::{FRAME_PERIOD_S, InputError, Recording, Sample, Trial};

use super::{KNOWN, written};
use crate::Source;
use crate::trial_table::reaches;

/// A contact of a taxel of a palm from sample `first` to `last`, 10 ms apart, that begins at a time of day.
fn trial(number: u64, reach: u64, taxel: u32, category: &str, first: u32, last: u32) -> Trial {
    let sample = |index: u32| Sample {
        time_s: 36_000.0 + f64::from(index) * FRAME_PERIOD_S,
        force_n: 1.0 + f64::from(index),
        ..Sample::default()
    };
    Trial {
        trial: number,
        category: Some(category.into()).filter(|name: &String| !name.is_empty()),
        reach: Some(reach),
        patch: Some("palm".into()),
        taxel: Some(taxel),
        samples: (first..=last).map(sample).collect(),
    }
}

/// What each frame of a reach senses: its time in periods, and taxels with forces.
fn felt(reach: &Recording) -> Vec<(f64, Vec<(u16, f64)>)> {
    let forces = |frame: &underbrush_recording::Frame| {
        let readings = frame.taxels.iter();
        readings.map(|reading| (reading.taxel, reading.sensed_force_n)).collect()
    };
    let periods = |time_s: f64| (time_s / FRAME_PERIOD_S * 10.0).round() / 10.0;
    let frames = reach.frames.iter();
    frames.map(|frame| (periods(frame.time_s), forces(frame))).collect()
}

/// Tests what is shown of a table: the forces at their times from the start of each reach; silent frames between
/// contacts, even if the next contact of the same taxel follows at once; and the category as the object.
#[test]
fn a_table_of_trials_becomes_frames() {
    let trials = [
        trial(0, 4, 2, "towel", 0, 2),
        trial(1, 4, 0, "towel", 1, 3),
        trial(2, 4, 0, "leaf", 4, 4),
        trial(3, 4, 1, "leaf", 8, 8),
        trial(4, 7, 1, "", 9, 9),
    ];
    let [first, second] = &reaches(Path::new("log.csv"), &trials).unwrap()[..] else {
        panic!("not two reaches");
    };
    assert_eq!((first.reach_index, second.reach_index), (4, 7));
    assert_eq!((first.scene.as_str(), first.layout.patches[0].taxels.len()), ("log", 4));
    assert!((first.rate_hz - 100.0).abs() < 1e-6);
    let expected = [
        (0.0, vec![(2, 1.0)]),
        (1.0, vec![(0, 2.0), (2, 2.0)]),
        // The contact of taxel 2 ends, but the contact of taxel 0 lasts, so the next frame is not silent.
        (2.0, vec![(0, 3.0), (2, 3.0)]),
        (3.0, vec![(0, 4.0)]),
        (3.5, vec![]),
        (4.0, vec![(0, 5.0)]),
        (5.0, vec![]),
        (6.0, vec![]),
        (7.0, vec![]),
        (8.0, vec![(1, 9.0)]),
        (9.0, vec![]),
    ];
    assert_eq!(felt(first), expected);
    assert_eq!(felt(second), [(0.0, vec![(1, 10.0)]), (1.0, vec![])]);
    let category = |reading: &underbrush_recording::TaxelReading| {
        let object = &first.objects[usize::from(reading.object.unwrap())];
        object.category.name()
    };
    assert_eq!(category(&first.frames[0].taxels[0]), "towel");
    assert_eq!(category(&first.frames[5].taxels[0]), "leaf");
    assert_eq!(second.frames[0].taxels[0].object, None);
}

/// Tests that the contacts that the page gets from these frames are the trials of the table.
#[test]
fn the_trials_of_the_page_are_those_of_the_table() {
    let trials = [trial(0, 0, 5, "leaf", 0, 2), trial(1, 0, 5, "leaf", 3, 4), trial(2, 0, 1, "towel", 10, 30)];
    let [reach] = &reaches(Path::new("log.csv"), &trials).unwrap()[..] else {
        panic!("not one reach");
    };
    let found = underbrush_classifier::trial::taxel_trials(reach, &Default::default()).unwrap();
    let seen = |trial: &Trial| -> (Option<u32>, Vec<f64>) {
        (trial.taxel, trial.samples.iter().map(|sample| sample.force_n).collect())
    };
    let found: Vec<_> = found.iter().map(|contact| seen(&contact.trial)).collect();
    assert_eq!(found, trials.iter().map(seen).collect::<Vec<_>>());
}

/// Tests that a table is listed, as what it is, and packed like other reaches, in whatever case its extension is
/// written.
#[test]
fn a_table_is_a_source() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["log.csv", "log.parquet", "log.CSV", "log.PARQUET"] {
        let path = folder.path().join(name);
        write_trials(&path, &[trial(0, 3, 0, "towel", 0, 9)]).unwrap();
        let source = Source::open(&[path], KNOWN, None).unwrap();
        let [line] = &source.reaches[..] else {
            panic!("{:?}", source.reaches);
        };
        assert_eq!((line.source.as_str(), line.reach_index, line.table), (name, 3, true));
        assert!(source.pack(0).unwrap().starts_with(b"ubreplay"));
    }
    let recording = folder.path().join("reach.PARQUET");
    std::fs::rename(written(folder.path(), 5), &recording).unwrap();
    let source = Source::open(&[recording], KNOWN, None).unwrap();
    assert_eq!(source.reaches[0].reach_index, 5);
}

/// Tests that trials that frames would change are refused: trials that overlap on a taxel, trials of taxels that are
/// sampled at different times, and a trial that follows another of its taxel without a frame between them. They used to
/// be merged or to get further releases.
#[test]
fn trials_that_frames_would_change_are_refused() {
    let refused = |trials: &[Trial]| -> InputError { reaches(Path::new("log.csv"), trials).unwrap_err() };
    for first in [0, 9] {
        let error = refused(&[trial(0, 0, 3, "leaf", 0, 9), trial(1, 0, 3, "towel", first, 19)]);
        assert_eq!(error.field, "reach");
        assert!(error.found.starts_with("trial 1 in reach 0 before trial 0"), "{error}");
    }
    let mut late = trial(1, 0, 1, "leaf", 0, 9);
    late.samples.iter_mut().for_each(|sample| sample.time_s += 0.005);
    let error = refused(&[trial(0, 0, 0, "leaf", 0, 9), late.clone()]);
    assert_eq!((error.field.as_str(), error.allowed.as_str()), ("time_s", "all taxels sampled at the same times"));
    assert!(error.found.starts_with("36000.005 s in reach 0"), "{error}");
    late.reach = Some(1);
    assert_eq!(reaches(Path::new("log.csv"), &[trial(0, 0, 0, "leaf", 0, 9), late]).unwrap().len(), 2);
    let (one, next) = (trial(0, 0, 0, "leaf", 0, 4), trial(1, 0, 0, "towel", 5, 9));
    let error = refused(&[one, next, trial(2, 0, 1, "leaf", 0, 9)]);
    assert!(error.found.contains("right after trial 0"), "{error}");
}

/// Tests that trials that cannot be shown are refused with the field: trials of contact regions, trials of categories
/// that recordings cannot hold, and trials of a reach with so long a gap that silent frames would fill the memory.
#[test]
fn what_cannot_be_shown_is_refused() {
    let refused = |trial: Trial| -> InputError { reaches(Path::new("log.csv"), &[trial]).unwrap_err() };
    let region = Trial { taxel: None, ..trial(8, 0, 0, "leaf", 0, 1) };
    let error = refused(region);
    assert_eq!((error.field.as_str(), error.found.as_str()), ("taxel", "nothing"));
    assert!(error.remedy.contains("trial 8"), "{error}");
    let far = [trial(0, 0, 0, "leaf", 0, 9), trial(1, 0, 0, "leaf", 900_000, 900_009)];
    assert_eq!(reaches(Path::new("log.csv"), &far).unwrap_err().field, "time_s");
    let error = refused(trial(0, 0, 0, "Wet towel", 0, 1));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("category", "Wet towel"));
    assert!(refused(trial(0, 0, 0, "unknown", 0, 1)).allowed.ends_with("not none, uncertain or unknown"));
}

/// Tests that a table with more taxels than a skin can have is refused, also if no patch has too many.
#[test]
fn more_taxels_than_a_skin_has_are_refused() {
    let on = |patch: &str| Trial { patch: Some(patch.into()), ..trial(0, 0, 40_000, "leaf", 0, 1) };
    let error = reaches(Path::new("log.csv"), &[on("palm"), on("thumb")]).unwrap_err();
    assert_eq!((error.field.as_str(), error.found.as_str()), ("patch", "2 patches with 80002 taxels"));
}

/// Tests that the label `nothing` is that of readings without an object.
#[test]
fn nothing_is_no_object() {
    let trials = [trial(0, 0, 0, "nothing", 0, 1), trial(1, 0, 0, "leaf", 5, 6)];
    let [reach] = &reaches(Path::new("log.csv"), &trials).unwrap()[..] else {
        panic!("not one reach");
    };
    assert_eq!(reach.objects.len(), 1);
    let objects: Vec<_> = reach.frames.iter().flat_map(|frame| &frame.taxels).map(|reading| reading.object).collect();
    assert_eq!(objects, [None, None, Some(0), Some(0)]);
}
