//! MCAP files.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mcap::records::MessageHeader;

use super::{by_taxel, damage, file, imported, refused};

const GRID: &str = "[force]\ntopic = \"/skin\"\nfrom = \"n\"\n";

/// Writes one message per millisecond, starting at a Unix time in 2026.
fn mcap_of(path: &Path, schema: &str, encoding: &str, messages: &[Vec<u8>]) {
    let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Zstd));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
    let channel_id = writer.add_channel(schema, "/skin", encoding, &BTreeMap::new()).unwrap();
    for (index, message) in messages.iter().enumerate() {
        let time_ns = 1_790_000_000_000_000_000 + 1_000_000 * index as u64;
        let header = MessageHeader { channel_id, sequence: index as u32, log_time: time_ns, publish_time: time_ns };
        writer.write_to_known_channel(&header, message).unwrap();
    }
    writer.finish().unwrap();
    std::fs::write(path, writer.into_inner().into_inner()).unwrap();
}

/// A Foxglove grid of one row with double precision.
fn grid(forces_n: &[f64]) -> Vec<u8> {
    let bytes: Vec<u8> = forces_n.iter().flat_map(|force_n| force_n.to_le_bytes()).collect();
    let message = serde_json::json!({
        "column_count": forces_n.len(),
        "row_stride": bytes.len(),
        "cell_stride": 8,
        "fields": [{ "name": "n", "offset": 0, "type": 8 }],
        "data": STANDARD.encode(bytes),
    });
    message.to_string().into_bytes()
}

/// The forces of a palm of six taxels in a frame, N.
fn palm(frame: usize) -> Vec<f64> {
    // Different taxels are pressed in different frames, by forces that need all digits.
    let force_n =
        |taxel: usize| if (frame + 5 * taxel) / 20 % 3 == 1 { (1 + frame % 7 + taxel) as f64 / 3.0 } else { 0.0 };
    (0..6).map(force_n).collect()
}

/// Tests that the forces of a grid come back as trials, from a file of several chunks. This has a second implementation of
/// the cutter's rule.
#[test]
fn trials_come_back_from_a_grid_in_mcap() {
    let (_folder, path) = file("reach.mcap");
    let frames: Vec<Vec<f64>> = (0..9000).map(palm).collect();
    mcap_of(&path, "foxglove.Grid", "json", &frames.iter().map(|frame| grid(frame)).collect::<Vec<_>>());
    let summary = mcap::Summary::read(&std::fs::read(&path).unwrap()).unwrap().unwrap();
    assert!(summary.chunk_indexes.len() > 1);
    let found = imported(&path, GRID).unwrap();
    assert_eq!(found.frames, frames.len());
    let mut expected: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = BTreeMap::new();
    for taxel in 0..6 {
        for (index, frame) in frames.iter().enumerate().filter(|(_, frame)| frame[taxel] > 0.0) {
            let trials = expected.entry(taxel as u32).or_default();
            if index == 0 || frames[index - 1][taxel] == 0.0 {
                trials.push(Vec::new());
            }
            trials.last_mut().unwrap().push((1e6 * index as f64 / 1e9, frame[taxel]));
        }
    }
    assert_eq!(by_taxel(&found.trials), expected);
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

/// Tests that arrays of ROS 2 and lists in JSON are read, and that their times count from the first message.
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
    mcap_of(&path, "std_msgs/msg/Float64MultiArray", "cdr", &[multi_array(&frames[0], false), vec![0, 1, 0, 0, 9]]);
    let error = refused(&path, "[force]\ntopic = \"/skin\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "message of /skin"));
    mcap_of(&path, "sensor_msgs/msg/Image", "cdr", &[vec![0, 1, 0, 0]]);
    let error = refused(&path, "[force]\ntopic = \"/skin\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "force.topic"));
    assert!(error.found.contains("sensor_msgs/msg/Image"), "{error}");
}

/// Tests that the bytes between the rows of a Foxglove grid are not taken for cells, and that rows that are too short
/// for their cells, and incomplete rows, are refused.
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
    grid(16, 32);
    let trials = [0.5, 0.25, 0.125, 0.75].map(|force_n| vec![vec![(0.0, force_n)]]);
    let expected: BTreeMap<u32, Vec<Vec<(f64, f64)>>> = (0..).zip(trials).collect();
    assert_eq!(by_taxel(&imported(&path, GRID).unwrap().trials), expected);
    for (row_stride, bytes, found) in
        [(4, 32, "rows of 4 bytes for 2 cells of 4"), (0, 32, "0 bytes"), (16, 24, "24 bytes in rows of 16")]
    {
        grid(row_stride, bytes);
        let error = refused(&path, GRID);
        assert_eq!((error.line, error.field.as_str()), (Some(1), "message of /skin"));
        assert!(error.found.contains(found), "{error}");
    }
}

/// Tests that a message with fewer or more taxels than the first is refused: a contact of a taxel must not go on
/// through messages without that taxel.
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

/// Tests that the error about something missing in an MCAP file gives the line of the mapping, that damaged files do
/// not end the program, and that a compression that is not supported is named.
#[test]
fn what_is_missing_or_damaged_is_named() {
    let (_folder, log) = file("reach.mcap");
    mcap_of(&log, "foxglove.Grid", "json", &(0..60).map(|frame| grid(&palm(frame))).collect::<Vec<_>>());
    let error = refused(&log, "[force]\ntopic = \"/palm\"\nfrom = \"data\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "force.topic"));
    assert!(error.allowed.contains("/skin (foxglove.Grid)"), "{error}");
    let error = refused(&log, &format!("[time]\nunit = \"ms\"\n{GRID}"));
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.unit"));
    let error = refused(&log, "[force]\ntopic = \"/skin\"\nfrom = \"force\"\n");
    assert_eq!(error.found, "the fields n");
    let mut lz4 = std::fs::read(&log).unwrap();
    damage(&log, GRID);
    let place = lz4.windows(4).position(|window| window == b"zstd").unwrap();
    lz4[place..place + 4].copy_from_slice(b"lz4f");
    std::fs::write(&log, lz4).unwrap();
    let error = refused(&log, GRID);
    assert!(error.found.contains("lz4f") && error.remedy.contains("zstd"), "{error}");
}
