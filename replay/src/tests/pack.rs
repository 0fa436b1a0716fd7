//! Tests that the packed bytes hold what was recorded.

use serde_json::Value;

use super::{KNOWN, reach, source};
use crate::Source;
use crate::pack::{pack, pack_from};

/// Packed bytes, read as the page reads them.
pub(super) struct Packed {
    pub header: Value,
    data: Vec<u8>,
}

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

impl Packed {
    pub fn read(bytes: &[u8]) -> Packed {
        assert_eq!(&bytes[..8], b"ubreplay");
        assert_eq!(u32_at(bytes, 16), bytes.len());
        assert_eq!(u32_at(bytes, 12), crc32fast::hash(&bytes[16..]) as usize);
        let start = 24 + u32_at(bytes, 20);
        Packed { header: serde_json::from_slice(&bytes[24..start]).unwrap(), data: bytes[start..].to_vec() }
    }

    /// The numbers of a section.
    pub fn section(&self, name: &str) -> Vec<f64> {
        let sections = self.header["sections"].as_array().unwrap();
        let section = sections.iter().find(|section| section["name"] == name).unwrap();
        let number = |key: &str| section[key].as_u64().unwrap() as usize;
        let kind = section["type"].as_str().unwrap();
        let size = kind[1..].parse::<usize>().unwrap() / 8;
        let (offset, count) = (number("offset"), number("count"));
        assert_eq!(offset % 8, 0, "{name}");
        let bytes = &self.data[offset..offset + size * count];
        let read = |bytes: &[u8]| match kind {
            "u8" => f64::from(bytes[0]),
            "u16" => f64::from(u16::from_le_bytes(bytes.try_into().unwrap())),
            "i16" => f64::from(i16::from_le_bytes(bytes.try_into().unwrap())),
            "u32" => f64::from(u32::from_le_bytes(bytes.try_into().unwrap())),
            "f32" => f64::from(f32::from_le_bytes(bytes.try_into().unwrap())),
            "f64" => f64::from_le_bytes(bytes.try_into().unwrap()),
            other => panic!("{other}"),
        };
        bytes.chunks(size).map(read).collect()
    }
}

/// Tests that readings, poses, times and contact trials arrive with their frames, and that the header holds what the
/// page shows as text, including the seed to its last digit.
#[test]
fn a_packed_reach_holds_what_was_recorded() {
    let recording = reach(3, 20);
    let packed = Packed::read(&pack(&recording, &KNOWN, None).unwrap());
    let header = &packed.header["reach"];
    assert_eq!(header["seed"], u64::MAX.to_string());
    assert_eq!(header["frames"], 20);
    assert_eq!(header["force_limit_n"], 3.0);
    assert_eq!(header["patches"][0]["grid"]["columns"], 2);
    assert_eq!(header["objects"][0]["category"], "trunk");
    assert_eq!(header["bodies"][0]["owner"]["link"], "forearm");
    assert_eq!(header["verdicts"], Value::Null);
    let times: Vec<f64> = recording.frames.iter().map(|frame| frame.time_s).collect();
    assert_eq!(packed.section("time_s"), times);
    // Fifteen frames with taxel 1, one of them also with taxel 2.
    let starts = packed.section("reading_start");
    assert_eq!((starts.len(), starts[5], starts[8], starts[20]), (21, 0.0, 4.0, 16.0));
    assert_eq!(packed.section("reading_taxel")[2..4], [1.0, 2.0]);
    assert_eq!(packed.section("reading_sensed_n")[2..4], [2.0, 0.5]);
    assert_eq!(packed.section("reading_true_n")[2..4], [2.0, 0.0]);
    assert_eq!(packed.section("reading_object")[2..4], [0.0, -1.0]);
    assert_eq!(packed.section("reading_shear_n")[4..6], [0.25, -0.5]);
    // The pose of frame 0 is the pose at rest and is not stored again.
    assert_eq!(packed.section("track_frame"), (1..20).map(f64::from).collect::<Vec<_>>());
    assert_eq!(packed.section("track_pose_world")[7..10], [2.0 / 1024.0, 0.0, 0.25]);
    // The trial of taxel 1 lasts 15 frames and has an object. The trial of taxel 2 lasts one frame and has none.
    assert_eq!(packed.section("trial_taxel"), [1.0, 2.0]);
    assert_eq!(packed.section("trial_first_frame"), [5.0, 7.0]);
    assert_eq!(packed.section("trial_object"), [0.0, -1.0]);
    assert_eq!(packed.section("trial_sample_start"), [0.0, 15.0, 16.0]);
    let motion = packed.section("sample_motion_m");
    assert!((motion[14] - 14.0 / 1024.0).abs() < 1e-7, "{motion:?}");
}

/// Tests that the bytes for the frames after the first eight have the rows of the other twelve, counted from the first
/// of these, the new samples of an open trial, and nothing that does not change.
#[test]
fn what_follows_holds_only_what_is_new() {
    let recording = reach(3, 20);
    let packed = Packed::read(&pack_from(&recording, &KNOWN, None, 8).unwrap());
    let header = &packed.header["reach"];
    assert_eq!((&header["from"], &header["frames"]), (&8.into(), &20.into()));
    for fixed in ["bodies", "objects", "patches", "joint_names"] {
        assert!(header.get(fixed).is_none(), "{fixed}");
    }
    assert_eq!(header["contacts"][0]["last_frame"], 19);
    assert_eq!(header["map"][0]["kind"], "fixed");
    let names: Vec<&str> =
        packed.header["sections"].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap()).collect();
    assert!(!names.iter().any(|name| name.starts_with("taxel_")), "{names:?}");
    let times: Vec<f64> = recording.frames[8..].iter().map(|frame| frame.time_s).collect();
    assert_eq!(packed.section("time_s"), times);
    assert_eq!(packed.section("reading_start"), (0..=12).map(f64::from).collect::<Vec<_>>());
    assert_eq!(packed.section("reading_taxel"), [1.0; 12]);
    assert_eq!(packed.section("track_start"), [0.0, 12.0]);
    assert_eq!(packed.section("track_frame"), (8..20).map(f64::from).collect::<Vec<_>>());
    // The trial of taxel 2 has ended before. The trial of taxel 1 began at frame 5.
    assert_eq!(packed.section("trial_taxel"), [1.0]);
    assert_eq!(packed.section("trial_first_frame"), [5.0]);
    assert_eq!(packed.section("trial_sample_start"), [0.0, 12.0]);
    let whole = Packed::read(&pack(&recording, &KNOWN, None).unwrap());
    assert_eq!(packed.section("sample_motion_m")[..], whole.section("sample_motion_m")[3..15]);
    let nothing = Packed::read(&pack_from(&recording, &KNOWN, None, 99).unwrap());
    assert_eq!((&nothing.header["reach"]["from"], nothing.section("time_s").len()), (&20.into(), 0));
}

/// Tests that the list has one line per recording, with its peak force, and that a number outside the list is refused.
#[test]
fn a_source_lists_its_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let source: Source = source(folder.path());
    let found: Vec<_> = source.reaches.iter().map(|reach| (reach.number, reach.reach_index)).collect();
    assert_eq!(found, [(0, 0), (1, 1)]);
    let first = &source.reaches[0];
    assert_eq!((first.source.as_str(), first.peak_force_n), ("reach-0.parquet", 2.0));
    assert_eq!(source.pack(1).unwrap(), pack(&reach(1, 20), &KNOWN, None).unwrap());
    let error = source.pack(2).unwrap_err();
    assert_eq!(error.to_string(), "there is no reach 2; give a number below 2");
}
