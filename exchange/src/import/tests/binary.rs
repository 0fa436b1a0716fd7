//! HDF5 and MCAP files.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hdf5_pure::{Datatype, DatatypeByteOrder, File, FloatingPointLayout, make_f64_type};
use underbrush_recording::Trial;

use super::{imported, refused, samples};
use crate::example::{file, reach};
use crate::mcap::Writer;
use crate::{ExchangeError, write_hdf5, write_mcap};

/// The trials of one patch in the frames of a recording, by taxel. This is a second implementation of the cutter's
/// rule.
fn expected(
    recording: &underbrush_recording::Recording,
    patch: u16,
    threshold_n: f64,
) -> BTreeMap<u32, Vec<Vec<(f64, f64)>>> {
    let mut trials: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = BTreeMap::new();
    let mut before: BTreeMap<u32, usize> = BTreeMap::new();
    for (index, frame) in recording.frames.iter().enumerate() {
        for reading in frame.taxels.iter().filter(|reading| reading.patch == patch) {
            if reading.sensed_force_n > threshold_n {
                let taxel = u32::from(reading.taxel);
                let of_taxel = trials.entry(taxel).or_default();
                if before.insert(taxel, index) != index.checked_sub(1) || of_taxel.is_empty() {
                    of_taxel.push(Vec::new());
                }
                of_taxel
                    .last_mut()
                    .unwrap()
                    .push((frame.time_s, reading.sensed_force_n));
            }
        }
    }
    trials
}

fn by_taxel(trials: &[Trial]) -> BTreeMap<u32, Vec<Vec<(f64, f64)>>> {
    let mut found: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = BTreeMap::new();
    for trial in trials {
        found.entry(trial.taxel.unwrap()).or_default().push(samples(trial));
    }
    found
}

/// Pins that reaches written as HDF5 come back as trials with the same forces, one reach for each demonstration in the
/// order of their numbers, and with the categories of an attribute.
#[test]
fn trials_come_back_from_hdf5() {
    let (_folder, path) = file("reaches.h5");
    let reaches: Vec<_> = (0..12)
        .map(|index| reach(&format!("scene {index}"), index, 1100))
        .collect();
    write_hdf5::<ExchangeError>(&path, |writer| reaches.iter().try_for_each(|reach| writer.push(reach))).unwrap();
    let mapping =
        "[time]\nrate_hz = 100\n[force]\nfrom = \"data/*/obs/tactile_sleeve\"\n[trial]\ncategory_from = \"scene\"\n";
    let found = imported(&path, mapping).unwrap();
    assert_eq!((found.reaches, found.frames), (12, 13_200));
    for (index, recording) in reaches.iter().enumerate() {
        let of_reach: Vec<Trial> = found
            .trials
            .iter()
            .filter(|trial| trial.reach == Some(index as u64))
            .cloned()
            .collect();
        assert!(
            of_reach
                .iter()
                .all(|trial| trial.category.as_deref() == Some(recording.scene.as_str()))
        );
        assert!(of_reach.len() > 10, "{} trials", of_reach.len());
        assert_eq!(by_taxel(&of_reach), expected(recording, 0, 0.03), "reach {index}");
    }
    let one = "[time]\nrate_hz = 100\n[force]\nfrom = \"data/demo_3/obs/tactile_tip\"\n";
    assert_eq!(
        by_taxel(&imported(&path, one).unwrap().trials),
        expected(&reaches[3], 1, 0.03)
    );
}

/// Pins that a reach written as MCAP comes back as trials with the same forces, from its grid.
#[test]
fn trials_come_back_from_a_grid_in_mcap() {
    let (_folder, path) = file("reach.mcap");
    let recording = reach("foliage", 3, 300);
    write_mcap(&path, &recording).unwrap();
    let mapping = "[force]\ntopic = \"/skin/sleeve\"\nfrom = \"sensed_force_n\"\n";
    let found = imported(&path, mapping).unwrap();
    assert_eq!(found.frames, 300);
    assert_eq!(by_taxel(&found.trials), expected(&recording, 0, 0.03));
}

/// Writes one message per millisecond, starting at a Unix time in 2026.
fn mcap_of(path: &Path, schema: &str, encoding: &str, messages: &[Vec<u8>]) {
    let mut writer = Writer::new("a robot");
    let channel = writer.channel("/skin", encoding, schema, "ros2msg", b"");
    for (index, message) in messages.iter().enumerate() {
        let time_ns = 1_790_000_000_000_000_000 + 1_000_000 * index as u64;
        writer.message(channel, time_ns, message).unwrap();
    }
    std::fs::write(path, writer.finish().unwrap()).unwrap();
}

/// A `std_msgs/msg/Float64MultiArray` or `Float32MultiArray` in CDR with one dimension, as rclcpp writes it.
fn multi_array(numbers: &[f64], single: bool) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    // One dimension: the label "taxels", size, stride; data_offset; count.
    bytes.extend(1u32.to_le_bytes());
    bytes.extend(7u32.to_le_bytes());
    bytes.extend(b"taxels\0\0");
    bytes.extend((numbers.len() as u32).to_le_bytes());
    bytes.extend((numbers.len() as u32).to_le_bytes());
    bytes.extend(0u32.to_le_bytes());
    bytes.extend((numbers.len() as u32).to_le_bytes());
    for number in numbers {
        if single {
            bytes.extend((*number as f32).to_le_bytes());
        } else {
            bytes.resize((bytes.len() - 4).next_multiple_of(8) + 4, 0);
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes
}

/// Pins that arrays of ROS 2 and lists in JSON are read, and that their times count from the first message.
#[test]
fn arrays_of_ros_and_lists_in_json_are_read() {
    let (_folder, path) = file("log.mcap");
    let frames = [[0.5, 0.0, 2.0], [0.25, 0.0, 0.0]];
    let json = |frame: &[f64; 3]| serde_json::json!({ "skin": { "n": frame } }).to_string().into_bytes();
    let kinds: [(&str, &str, Vec<Vec<u8>>, &str); 3] = [
        (
            "std_msgs/msg/Float64MultiArray",
            "cdr",
            frames.iter().map(|frame| multi_array(frame, false)).collect(),
            "data",
        ),
        (
            "std_msgs/msg/Float32MultiArray",
            "cdr",
            frames.iter().map(|frame| multi_array(frame, true)).collect(),
            "data",
        ),
        ("mine.Skin", "json", frames.iter().map(json).collect(), "skin.n"),
    ];
    for (schema, encoding, messages, from) in kinds {
        mcap_of(&path, schema, encoding, &messages);
        let found = imported(&path, &format!("[force]\ntopic = \"/skin\"\nfrom = \"{from}\"\n")).unwrap();
        let expected = BTreeMap::from([(0, vec![vec![(0.0, 0.5), (0.001, 0.25)]]), (2, vec![vec![(0.0, 2.0)]])]);
        assert_eq!(by_taxel(&found.trials), expected, "{schema}");
    }
    mcap_of(
        &path,
        "std_msgs/msg/Float64MultiArray",
        "cdr",
        &[multi_array(&frames[0], false), vec![0, 1, 0, 0, 9]],
    );
    let error = refused(&path, "[force]\ntopic = \"/skin\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "message of /skin"));
    mcap_of(&path, "sensor_msgs/msg/Image", "cdr", &[vec![0, 1, 0, 0]]);
    let error = refused(&path, "[force]\ntopic = \"/skin\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "force.topic"));
    assert!(error.found.contains("sensor_msgs/msg/Image"), "{error}");
}

/// Pins that the bytes between the rows of a Foxglove grid are not taken for cells, and that rows that are too short for
/// their cells, and incomplete rows, are refused.
#[test]
fn rows_of_a_grid_may_be_padded() {
    let (_folder, path) = file("log.mcap");
    let grid = |row_stride: usize, bytes: usize| {
        let row = |cells: [f32; 2]| [cells[0].to_le_bytes(), cells[1].to_le_bytes(), [0; 4], [0; 4]].concat();
        let rows = [row([0.5, 0.25]), row([0.125, 0.75])].concat();
        let message = serde_json::json!({
            "column_count": 2,
            "row_stride": row_stride,
            "cell_stride": 4,
            "fields": [{ "name": "n", "offset": 0, "type": 7 }],
            "data": STANDARD.encode(&rows[..bytes]),
        });
        mcap_of(&path, "foxglove.Grid", "json", &[message.to_string().into_bytes()]);
    };
    let mapping = "[force]\ntopic = \"/skin\"\nfrom = \"n\"\n";
    grid(16, 32);
    let trials = [0.5, 0.25, 0.125, 0.75].map(|force_n| vec![vec![(0.0, force_n)]]);
    let expected: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = (0..).zip(trials).collect();
    assert_eq!(by_taxel(&imported(&path, mapping).unwrap().trials), expected);
    for (row_stride, bytes, found) in [
        (4, 32, "rows of 4 bytes for 2 cells of 4"),
        (0, 32, "0 bytes"),
        (16, 24, "24 bytes in rows of 16"),
    ] {
        grid(row_stride, bytes);
        let error = refused(&path, mapping);
        assert_eq!((error.line, error.field.as_str()), (Some(1), "message of /skin"));
        assert!(error.found.contains(found), "{error}");
    }
}

/// Pins that a message with fewer or more taxels than the first is refused: a contact of a taxel must not go on through
/// messages without that taxel.
#[test]
fn messages_have_the_same_number_of_taxels() {
    let (_folder, path) = file("log.mcap");
    for second in [&[0.5, 0.0][..], &[0.5, 0.0, 2.0, 1.0], &[]] {
        let messages = [multi_array(&[0.5, 0.0, 2.0], false), multi_array(second, false)];
        mcap_of(&path, "std_msgs/msg/Float64MultiArray", "cdr", &messages);
        let error = refused(&path, "[force]\ntopic = \"/skin\"\nfrom = \"data\"\n");
        assert_eq!((error.line, error.field.as_str()), (Some(2), "number of taxels"));
        assert_eq!(error.allowed, "3, as in the first frame of the reach");
    }
}

/// Writes 50 frames of two taxels as `forces`, and their times as `t`, each with this type and these bytes for a 1.
fn hdf5_of(path: &Path, forces: (Datatype, &[u8]), times: (Datatype, &[u8])) {
    let file = File::create(path).unwrap();
    let tables = [("forces", forces, vec![50u64, 2]), ("t", times, vec![50])];
    for (name, (datatype, one), shape) in tables {
        let count: u64 = shape.iter().product();
        let dataset = file.root().create_dataset(name, |dataset| {
            dataset
                .with_raw_data(datatype, one.repeat(count as usize), count)
                .with_shape(&shape);
        });
        dataset.unwrap();
    }
    file.commit().unwrap();
    file.close().unwrap();
}

/// Pins that forces and times of a type that the reader of HDF5 cannot convert are refused. They used to be taken for
/// no frames, and for times that follow from a rate of 1 Hz.
#[test]
fn half_precision_in_hdf5_is_refused() {
    let (_folder, path) = file("log.h5");
    let half = || {
        let layout = FloatingPointLayout {
            bit_offset: 0,
            bit_precision: 16,
            exponent_location: 10,
            exponent_size: 5,
            mantissa_location: 0,
            mantissa_size: 10,
            exponent_bias: 15,
        };
        let datatype = Datatype::FloatingPoint {
            size: 2,
            byte_order: DatatypeByteOrder::LittleEndian,
            layout,
        };
        let one: &[u8] = &[0x00, 0x3c];
        (datatype, one)
    };
    let one = 1f64.to_le_bytes();
    let double = || (make_f64_type(), &one[..]);
    let times = "[time]\nfrom = \"t\"\n[force]\nfrom = \"forces\"\n";
    let rate = "[time]\nrate_hz = 100\n[force]\nfrom = \"forces\"\n";
    hdf5_of(&path, half(), double());
    for mapping in [times, rate] {
        let error = refused(&path, mapping);
        assert_eq!((error.line, error.field.as_str()), (Some(4), "force.from"), "{error}");
        assert!(error.found.contains("unsupported type"), "{error}");
    }
    hdf5_of(&path, double(), half());
    let error = refused(&path, times);
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.from"), "{error}");
    assert!(error.allowed.contains("float64"), "{error}");
    assert_eq!(imported(&path, rate).unwrap().frames, 50);
}

/// Pins that an error about a row of an HDF5 file names the group of its reach.
#[test]
fn an_error_in_hdf5_names_the_reach() {
    let (_folder, path) = file("reaches.h5");
    let mut reaches = [reach("leaf", 0, 60), reach("leaf", 1, 60)];
    let reading = reaches[1]
        .frames
        .iter_mut()
        .flat_map(|frame| &mut frame.taxels)
        .find(|reading| reading.patch == 0 && reading.taxel == 4);
    reading.unwrap().sensed_force_n = -5.0;
    write_hdf5::<ExchangeError>(&path, |writer| reaches.iter().try_for_each(|reach| writer.push(reach))).unwrap();
    let error = refused(
        &path,
        "[time]\nrate_hz = 100\n[force]\nfrom = \"data/*/obs/tactile_sleeve\"\n",
    );
    assert_eq!(
        (error.line, error.field.as_str()),
        (Some(1), "data/demo_1, force of taxel 4")
    );
}

/// Pins that the error about something missing in an HDF5 or MCAP file gives the line of the mapping, and that damaged
/// files do not end the program.
#[test]
fn what_is_missing_or_damaged_in_binary_files_is_named() {
    let (_folder, path) = file("reaches.h5");
    write_hdf5::<ExchangeError>(&path, |writer| writer.push(&reach("leaf", 0, 60))).unwrap();
    let mapping = |from: &str| format!("[time]\nrate_hz = 100\n[force]\nfrom = \"{from}\"\n");
    for (from, found) in [
        ("data/*/obs/skin", "\"data/demo_0/obs/skin\", which is no dataset"),
        ("reaches/*/skin", "no group \"reaches\""),
        ("data/demo_0/obs", "no dataset"),
    ] {
        let error = refused(&path, &mapping(from));
        assert_eq!((error.line, error.field.as_str()), (Some(4), "force.from"), "{error}");
        assert!(error.found.contains(found), "{error}");
    }
    let error = refused(
        &path,
        "[time]\nfrom = \"data/*/obs/eef_pos\"\n[force]\nfrom = \"data/*/obs/tactile_tip\"\n",
    );
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.from"));
    let category = format!(
        "{}[trial]\ncategory_from = \"label\"\n",
        mapping("data/*/obs/tactile_tip")
    );
    let error = refused(&path, &category);
    assert_eq!((error.line, error.field.as_str()), (Some(6), "trial.category_from"));
    assert!(error.allowed.contains("outcome"), "{error}");

    let (_other, log) = file("reach.mcap");
    write_mcap(&log, &reach("leaf", 0, 60)).unwrap();
    let error = refused(&log, "[force]\ntopic = \"/palm\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "force.topic"));
    assert!(error.allowed.contains("/skin/sleeve (foxglove.Grid)"), "{error}");
    let error = refused(
        &log,
        "[time]\nunit = \"ms\"\n[force]\ntopic = \"/skin/sleeve\"\nfrom = \"sensed_force_n\"\n",
    );
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.unit"));
    let error = refused(&log, "[force]\ntopic = \"/skin/sleeve\"\nfrom = \"force\"\n");
    assert_eq!(error.found, "the fields sensed_force_n");

    let good = [
        (path, mapping("data/*/obs/tactile_tip")),
        (
            log,
            "[force]\ntopic = \"/skin/sleeve\"\nfrom = \"sensed_force_n\"\n".to_string(),
        ),
    ];
    for (path, mapping) in good {
        let bytes = std::fs::read(&path).unwrap();
        let trials = imported(&path, &mapping).unwrap().trials;
        let mut outcomes = [0, 0];
        for place in (0..bytes.len()).step_by(bytes.len() / 97) {
            std::fs::write(&path, &bytes[..place]).unwrap();
            assert!(imported(&path, &mapping).is_err(), "cut at {place}");
            let mut flipped = bytes.clone();
            flipped[place] ^= 0xff;
            std::fs::write(&path, flipped).unwrap();
            match imported(&path, &mapping) {
                // Not every byte matters to the forces.
                Ok(found) => outcomes[usize::from(found.trials != trials)] += 1,
                Err(ExchangeError::Input(_)) => {}
                Err(other) => panic!("{other:?}"),
            }
        }
        assert!(outcomes[1] <= 1, "{outcomes:?}: changed forces are not noticed");
    }
}

/// Tests that an HDF5 file of 1.4 kB that declares 2^40 frames is refused, with the limit, before any is read.
#[test]
fn declared_frames_that_the_file_cannot_hold_are_refused() {
    let (_folder, path) = file("log.h5");
    std::fs::write(&path, include_bytes!("declared-frames.h5")).unwrap();
    let error = refused(&path, "[time]\nrate_hz = 100\n[force]\nfrom = \"force\"\n");
    assert_eq!(error.field, "force");
    assert!(
        error
            .allowed
            .starts_with("at most 1100 bytes for each byte of the file"),
        "{error}"
    );
}
