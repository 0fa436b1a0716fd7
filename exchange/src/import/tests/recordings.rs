//! Tests of recordings from logs with labels.

use std::collections::BTreeSet;

use underbrush_recording::disk::{read_recording, write_recording};
use underbrush_recording::{Category, Pose};

use super::*;

const TAXELS: &str = "x_m,y_m,z_m,normal_x,normal_y,normal_z,area_m2\n0,0,0,0,0,2,1e-4\n0.01,0,0,0,0,1,1e-4\n";
const LOG: &str = "run,s,f0,f1,px,py,pz,qx,qy,qz,qw,label\n\
    0,5.00,0,0,1,2,3,0,0,0,1,\n\
    0,5.01,0.5,0.01,1,2,3,0,0,0,1,leaf\n\
    0,5.02,0.7,0.2,1,2,4,0,0,0.7071067811865476,0.7071067811865476,leaf\n\
    0,5.03,0,0,1,2,4,0,0,0,1,leaf\n\
    0,5.04,0.4,0,1,2,4,0,0,0,1,reed\n\
    1,0,0.3,0,1,2,3,0,0,0,1,nothing\n";
const MAPPING: &str = "[time]\nfrom = \"s\"\n[force]\nfrom = \"f{taxel}\"\ntaxels = 2\n\
    [skin]\ntaxels = \"taxels.csv\"\npose_from = [\"px\", \"py\", \"pz\", \"qx\", \"qy\", \"qz\", \"qw\"]\n\
    [trial]\npatch = \"palm\"\ncategory_from = \"label\"\nreach_from = \"run\"\n";

/// Imports a log beside a file of taxels.
fn recorded(log: &str, taxels: &str, mapping: &str) -> Result<Imported, InputError> {
    let (folder, path) = file("log.csv");
    written(&folder.path().join("taxels.csv"), taxels);
    let mapping = Mapping::load(&written(&path.with_extension("toml"), mapping))?;
    import(&written(&path, log), &mapping, true)
}

/// Tests that each reach becomes a recording that files can hold: taxels and poses of the log, times from 0, labels as objects,
/// contacts of adjacent frames, and readings below the threshold or under the label `nothing` as untouched.
#[test]
fn labelled_reaches_become_recordings() {
    let found = recorded(LOG, TAXELS, MAPPING).unwrap();
    let [first, second] = &found.recordings[..] else { panic!("{} recordings", found.recordings.len()) };
    let patch = &first.layout.patches[0];
    assert_eq!(
        (patch.name.as_str(), patch.taxels[0].normal_link.z, patch.taxels[1].position_link.x),
        ("palm", 1.0, 0.01)
    );
    assert!((first.rate_hz - 100.0).abs() < 1e-6 && (first.frames[4].time_s - 0.04).abs() < 1e-9);
    let categories: Vec<Category> = first.objects.iter().map(|object| object.category).collect();
    assert_eq!(categories, [Category::LEAF, Category::named("reed").unwrap()]);
    let told: Vec<Vec<(u16, Option<u16>)>> =
        first.frames.iter().map(|frame| frame.taxels.iter().map(|own| (own.taxel, own.object)).collect()).collect();
    assert_eq!(
        told,
        [vec![], vec![(0, Some(0)), (1, None)], vec![(0, Some(0)), (1, Some(0))], vec![], vec![(0, Some(1))]]
    );
    let contacts: Vec<_> = first.contacts.iter().map(|own| (own.object, own.first_frame, own.last_frame)).collect();
    assert_eq!(contacts, [(0, 1, 2), (1, 4, 4)]);
    let (peak_n, mean_n) = (first.contacts[0].peak_force_n, first.contacts[0].mean_force_n);
    assert!((peak_n - 0.9).abs() < 1e-12 && (mean_n - 0.7).abs() < 1e-12);
    // A quarter turn about z takes the second taxel along x to along y.
    let pose: Pose = first.frames[2].patch_pose_world[0];
    let taxel = pose.transform_point(patch.taxels[1].position_link);
    assert!((taxel - glam::DVec3::new(1.0, 2.01, 4.0)).length() < 1e-12, "{taxel}");
    assert_eq!((second.objects.len(), second.contacts.len(), second.frames[0].taxels[0].object), (0, 0, None));
    let (_folder, path) = file("reach.parquet");
    write_recording(&path, first).unwrap();
    assert_eq!(read_recording(&path).unwrap().contacts, first.contacts);
}

/// Tests that a frame with forces and no label, a category that objects cannot have, and taxels that do not fit are refused with
/// what is allowed, and so is a mapping without the places of the taxels.
#[test]
fn what_is_no_recording_is_refused() {
    for (log, taxels, parts) in [
        (LOG.replace("0,leaf", "0,").replacen("1,leaf", "1,", 1), TAXELS.into(), ["category", "or `nothing`"]),
        (LOG.replace("reed", "Reed grass"), TAXELS.into(), ["\"Reed grass\"", "lower-case letters"]),
        (LOG.replace("reed", "unknown"), TAXELS.into(), ["\"unknown\"", "not none, uncertain or unknown"]),
        (LOG.replace("0,0,0,1,reed", "0,0,0,0.9,reed"), TAXELS.into(), ["qw", "length 1, to 1 %; this one has 0.9"]),
        (LOG.into(), TAXELS.replace("0.01,0,0,0,0,1,1e-4\n", ""), ["skin.taxels: found 1 rows", "each of 2 taxels"]),
        (LOG.into(), TAXELS.replace("0,0,2,1e-4", "0,0,0,1e-4"), ["normal, area_m2", "a normal that is not zero"]),
        (LOG.into(), TAXELS.replace("area_m2", "area"), ["columns: found x_m", "normal_z, area_m2"]),
        (LOG.into(), TAXELS.replace("0.01", "far"), ["x_m: found \"far\"", "a number up to 5"]),
        (LOG.into(), TAXELS.replace("0.01", "10"), ["x_m: found \"10\"", "a number up to 5"]),
        (LOG.into(), TAXELS.replace("\n0.01", "\n\nfar"), ["taxels.csv:4: x_m", "found \"far\""]),
        (LOG.into(), format!("{TAXELS}\n0,0\n"), ["taxels.csv:5: CSV: found 2 cells", "7 cells, as in the header"]),
        (
            LOG.replace("0,5.03", "0,9").replace("0,5.04", "0,9.01"),
            TAXELS.into(),
            ["log.csv:5: time", "from 5.02 to 9 s"],
        ),
        (LOG.lines().take(1).collect(), TAXELS.into(), ["CSV: found a header without rows", "a row for each frame"]),
    ] {
        let log: String = log;
        let error = recorded(&log, &taxels, MAPPING).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    let flat = MAPPING.replace("[skin]\ntaxels = \"taxels.csv\"\n", "").replace("pose_from", "# pose_from");
    let error = recorded(LOG, TAXELS, &flat).unwrap_err().to_string();
    assert!(error.contains("skin.taxels") && error.contains("for recordings in a folder"), "{error}");
}

/// Tests that trials are cut from a log without labels although the mapping says where the taxels are, and that a reach in which
/// nothing is felt is a recording, but no trial.
#[test]
fn trials_need_no_labels_and_recordings_no_trials() {
    let (folder, path) = file("log.csv");
    written(&folder.path().join("taxels.csv"), TAXELS);
    let log = LOG.replace("leaf", "").replace("reed", "").replace("nothing", "");
    assert_eq!(imported(&written(&path, &log), MAPPING).unwrap().trials.len(), 4);
    let silent =
        recorded("run,s,f0,f1,px,py,pz,qx,qy,qz,qw,label\n0,0,0,0,1,2,3,0,0,0,1,nothing\n", TAXELS, MAPPING).unwrap();
    assert_eq!((silent.trials.len(), silent.recordings[0].frames.len()), (0, 1));
}

/// Tests that two names with the same usual code have codes of their own, and that a frame that is missing is filled in.
#[test]
fn names_with_one_code_can_meet() {
    let [brick, wood] = ["brick", "wood"].map(|name| Category::named(name).unwrap());
    assert_eq!(brick.code(), wood.code());
    let found = recorded(&LOG.replace("leaf", "brick").replace("reed", "wood"), TAXELS, MAPPING).unwrap();
    let categories: BTreeSet<_> = found
        .recordings
        .iter()
        .flat_map(|own| &own.objects)
        .map(|own| (own.category.name(), own.category.code()))
        .collect();
    assert_eq!(categories.len(), 2);
    let codes: BTreeSet<i8> = categories.iter().map(|(_, code)| *code).collect();
    assert_eq!(codes.len(), 2, "{categories:?}");
}

/// Tests that short reaches whose times jitter are put at their places if the rate is given, also one that is off by half a percent,
/// and those of 80 frames also if it is not; and that a reach which seems to have another rate is warned of.
#[test]
fn short_reaches_that_jitter_are_placed() {
    let log = |frames: u32, step_s: f64| {
        // Jitter of up to 0.39 frames, all sizes as often, from a sequence without a pattern.
        let jitter =
            |frame: u32| 0.39 * (2.0 * (43758.5453 * (12.9898 * f64::from(frame)).sin()).rem_euclid(1.0) - 1.0);
        let row = |reach: u32, frame: u32| {
            format!("{reach},{},1,0,leaf\n", (f64::from(frame) + jitter(frame + 40 * reach)) * step_s)
        };
        let rows = (0..12).flat_map(|reach| (0..frames).map(move |frame| row(reach, frame)));
        format!("run,s,f0,f1,label\n{}", rows.collect::<String>())
    };
    let still = MAPPING.lines().filter(|line| !line.starts_with("pose_from")).collect::<Vec<_>>().join("\n");
    let given = still.replace("[time]", "[time]\nrate_hz = 100");
    for (frames, step_s, mapping) in
        [(10, 0.01, &given), (30, 0.01, &given), (200, 0.01005, &given), (2000, 0.01005, &given), (80, 0.01, &still)]
    {
        let found = recorded(&log(frames, step_s), TAXELS, mapping).unwrap();
        let counts: Vec<usize> = found.recordings.iter().map(|own| own.frames.len()).collect();
        assert_eq!(counts, [frames as usize; 12], "{frames} frames");
        assert!(found.recordings.iter().all(|own| (own.rate_hz * step_s - 1.0).abs() < 0.006), "{frames} frames");
        assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    }
    // The first reach has half the rate of the others.
    let slow =
        log(200, 0.01).lines().filter(|row| !row.starts_with("0,")).map(|row| format!("{row}\n")).collect::<String>();
    let first = (0..200).map(|frame| format!("0,{},1,0,leaf\n", 0.02 * f64::from(frame))).collect::<String>();
    let (header, others) = slow.split_once('\n').unwrap();
    let found = recorded(&format!("{header}\n{first}{others}"), TAXELS, &still).unwrap();
    assert!(found.warnings[0].starts_with("reach 0 seems to have frames at 50 Hz"), "{:?}", found.warnings);
}

/// Tests the warning about labelled objects of which no force is felt, as in a wrong unit, and that there is none if the label is
/// `nothing`.
#[test]
fn objects_that_are_not_felt_are_warned_of() {
    let warnings = |log: &str, unit: &str| {
        let mapping = MAPPING.replace("taxels = 2\n", &format!("taxels = 2\nunit = \"{unit}\"\n"));
        recorded(log, TAXELS, &mapping).unwrap().warnings
    };
    let is_unfelt = |warning: &String| warning.starts_with("labels name objects, but no force is above 0.03 N");
    assert!(warnings(LOG, "mN").iter().any(is_unfelt));
    assert!(!warnings(LOG, "N").iter().any(is_unfelt));
    let silent = LOG.replace("leaf", "nothing").replace("reed", "nothing");
    assert!(!warnings(&silent, "mN").iter().any(is_unfelt));
}

/// Tests the warnings about a rate at which half of the frames are missing, and about times in another unit.
#[test]
fn doubtful_times_are_warned_of() {
    let warnings = |step_s: f64, time: &str| {
        let row = |frame: u32| format!("0,{},0.5,0,1,2,3,0,0,0,1,leaf\n", step_s * f64::from(frame));
        let log = format!("{}\n{}", LOG.lines().next().unwrap(), (0..20).map(row).collect::<String>());
        recorded(&log, TAXELS, &MAPPING.replace("[time]", time)).unwrap().warnings
    };
    assert!(warnings(0.02, "[time]").is_empty());
    assert!(warnings(0.02, "[time]\nrate_hz = 100")[0].starts_with("19 of 39 frames"));
    assert!(warnings(20.0, "[time]")[0].contains("has 0.05 frames per second"));
    assert!(warnings(0.02, "[time]\nunit = \"ms\"")[0].contains("has 50000 frames per second"));
}

/// Tests the warnings about poses in millimetres, which the speed of the skin gives away, and about channels, which recordings
/// do not hold.
#[test]
fn poses_in_millimetres_and_channels_are_warned_of() {
    let row = |frame: u32, scale: f64| {
        format!("0,{},0.5,0,{},0,0,0,0,0,1,leaf\n", 0.01 * f64::from(frame), scale * 0.002 * f64::from(frame))
    };
    let warnings = |scale: f64, more: &str| {
        let header = LOG.lines().next().unwrap();
        let log = format!("{header}\n{}", (0..20).map(|frame| row(frame, scale)).collect::<String>());
        recorded(&log, TAXELS, &format!("{MAPPING}{more}")).unwrap().warnings
    };
    assert!(warnings(1.0, "").is_empty());
    assert!(warnings(1000.0, "")[0].contains("moves at 200 m/s"), "{:?}", warnings(1000.0, ""));
    let channel = "[[channel]]\nname = \"heat\"\nfrom = \"f0\"\n";
    assert!(warnings(1.0, channel)[0].contains("recordings hold no channels"));
}
