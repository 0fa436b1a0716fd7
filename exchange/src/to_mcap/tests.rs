use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use underbrush_recording::{BodyOwner, Pose};

use super::{FRAMES_BETWEEN_ALL, encode, write_mcap};
use crate::example::{file, reach};
use crate::mcap::{Fault, read};
use mcap::records::Record;

/// All messages of a topic with their times, ns.
fn messages(bytes: &[u8], topic: &str) -> Vec<(u64, Vec<u8>)> {
    let (mut channel_id, mut messages) = (None, Vec::new());
    let read = read(bytes, |record| {
        match record {
            Record::Channel(channel) if channel.topic == topic => channel_id = Some(channel.id),
            Record::Message { header, data } if channel_id == Some(header.channel_id) => {
                messages.push((header.log_time, data.into_owned()));
            }
            _ => {}
        }
        Ok::<(), Fault>(())
    });
    read.unwrap();
    messages
}

fn json(bytes: &[u8], topic: &str) -> Vec<Value> {
    let parse = |(_, data): (u64, Vec<u8>)| serde_json::from_slice(&data).unwrap();
    messages(bytes, topic).into_iter().map(parse).collect()
}

/// The doubles of packed data.
fn doubles(message: &Value) -> Vec<f64> {
    let bytes = STANDARD.decode(message["data"].as_str().unwrap()).unwrap();
    bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// Reads a JointState by the rules of CDR: its time in ns, the names and the three lists.
fn joint_state(bytes: &[u8]) -> (u64, Vec<String>, Vec<Vec<f64>>) {
    assert_eq!(bytes[..4], [0, 1, 0, 0]);
    let bytes = &bytes[4..];
    let mut place = 0;
    let u32_at = |place: &mut usize| {
        *place = place.next_multiple_of(4) + 4;
        u32::from_le_bytes(bytes[*place - 4..*place].try_into().unwrap()) as usize
    };
    let nanoseconds = u32_at(&mut place) as u64 * 1_000_000_000 + u32_at(&mut place) as u64;
    let text = |place: &mut usize| {
        let length = u32_at(place);
        *place += length;
        assert_eq!(bytes[*place - 1], 0, "a text ends with a zero");
        String::from_utf8(bytes[*place - length..*place - 1].to_vec()).unwrap()
    };
    assert_eq!(text(&mut place), "", "frame_id");
    place = place.next_multiple_of(4) + 4;
    let count = u32::from_le_bytes(bytes[place - 4..place].try_into().unwrap());
    let names = (0..count).map(|_| text(&mut place)).collect();
    let mut lists = Vec::new();
    for _ in 0..3 {
        place = place.next_multiple_of(4) + 4;
        let count = u32::from_le_bytes(bytes[place - 4..place].try_into().unwrap()) as usize;
        let mut list = Vec::new();
        for _ in 0..count {
            place = place.next_multiple_of(8) + 8;
            list.push(f64::from_le_bytes(bytes[place - 8..place].try_into().unwrap()));
        }
        lists.push(list);
    }
    assert_eq!(place, bytes.len(), "bytes after the message");
    (nanoseconds, names, lists)
}

/// Tests that joint states and forces come back from the file in full precision, at their times.
#[test]
fn joints_and_forces_come_back_exactly() {
    let recording = reach("foliage", 2, 90);
    let bytes = encode(&recording).unwrap();
    let (states, equilibrium) = (messages(&bytes, "/joint_states"), messages(&bytes, "/equilibrium"));
    assert_eq!((states.len(), equilibrium.len()), (90, 90));
    for (index, frame) in recording.frames.iter().enumerate() {
        let (time, names, lists) = joint_state(&states[index].1);
        assert_eq!(time, index as u64 * 10_000_000);
        assert_eq!(states[index].0, time);
        assert_eq!(names, recording.joint_names);
        let numbers = [&frame.joint_angle_rad, &frame.joint_velocity_rad_per_s, &frame.joint_torque_nm];
        assert_eq!(lists, numbers.map(Clone::clone));
        let (_, _, lists) = joint_state(&equilibrium[index].1);
        assert_eq!(lists, [frame.equilibrium_angle_rad.clone(), vec![], vec![]]);
    }
    let (grids, tips) = (json(&bytes, "/skin/sleeve"), json(&bytes, "/skin/tip/pressed"));
    assert_eq!((grids.len(), tips.len()), (90, 90));
    let mut pressed = 0;
    for (index, frame) in recording.frames.iter().enumerate() {
        let mut cells = vec![0.0; 6];
        let of_sleeve = frame.taxels.iter().filter(|reading| reading.patch == 0);
        of_sleeve.for_each(|reading| cells[usize::from(reading.taxel)] = reading.sensed_force_n);
        assert_eq!(doubles(&grids[index]), cells);
        assert_eq!((&grids[index]["column_count"], &grids[index]["row_stride"]), (&3.into(), &24.into()));
        let tip = frame.taxels.iter().find(|reading| reading.patch == 1);
        let point = tip.map(|reading| vec![0.01, 0.05, 0.0, reading.sensed_force_n]);
        assert_eq!(doubles(&tips[index]), point.unwrap_or_default());
        pressed += usize::from(tip.is_some());
    }
    assert!((10..80).contains(&pressed), "{pressed} frames with force");
}

/// Tests that the poses of all bodies can be followed from the transforms, that all poses are sent again at regular
/// intervals, and that shapes and goals are in the scene.
#[test]
fn poses_shapes_and_goals_come_back() {
    let recording = reach("foliage", 0, FRAMES_BETWEEN_ALL + 30);
    let bytes = encode(&recording).unwrap();
    let mut poses: BTreeMap<String, Pose> = BTreeMap::new();
    for (index, message) in json(&bytes, "/tf").iter().enumerate() {
        let transforms = message["transforms"].as_array().unwrap();
        // Three bodies and the grid of the sleeve.
        assert!(!index.is_multiple_of(FRAMES_BETWEEN_ALL) || transforms.len() == 4);
        for transform in transforms {
            assert_eq!(transform["parent_frame_id"], "world");
            let number = |part: &str, axis: &str| transform[part][axis].as_f64().unwrap();
            let position = ["x", "y", "z"].map(|axis| number("translation", axis));
            let rotation = ["x", "y", "z", "w"].map(|axis| number("rotation", axis));
            let pose = Pose::new(position.into(), glam::DQuat::from_array(rotation));
            poses.insert(transform["child_frame_id"].as_str().unwrap().into(), pose);
        }
        for (body, name) in recording.bodies.iter().zip(["sleeve_link", "leaf_0/0", "leaf_0/1"]) {
            let expected = body.pose_world(index as u32);
            assert_eq!(poses[name], expected, "{name} in frame {index}");
        }
    }
    let scene = json(&bytes, "/scene");
    assert_eq!(scene.len(), 1);
    let entities = scene[0]["entities"].as_array().unwrap();
    let ids: Vec<_> = entities.iter().map(|entity| entity["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["sleeve_link", "leaf_0/0", "leaf_0/1"]);
    assert_eq!(entities[0]["spheres"].as_array().unwrap().len(), 2);
    assert_eq!(entities[1]["metadata"][0]["value"], "leaf");
    // Each face of a cube appears as the four triangles of its corners.
    assert_eq!(entities[1]["triangles"][0]["points"].as_array().unwrap().len(), 6 * 4 * 3);
    assert_eq!(entities[2]["cubes"][0]["size"]["x"], 1.0);
    let goals = json(&bytes, "/goal");
    let place = |goal: &Value| goal["entities"][0]["spheres"][0]["pose"]["position"]["y"].as_f64().unwrap();
    assert_eq!(goals.iter().map(place).collect::<Vec<_>>(), [0.0, 0.1, 0.2, 0.1 * 3.0]);
}

/// Tests that a link that is called like the root frame does not make this frame its own parent.
#[test]
fn a_link_called_world_is_no_transform() {
    let mut recording = reach("foliage", 0, 30);
    recording.bodies[0].owner = BodyOwner::Link("world".into());
    let bytes = encode(&recording).unwrap();
    let transforms = json(&bytes, "/tf");
    assert_eq!(transforms.len(), 30);
    for message in transforms {
        let children = message["transforms"].as_array().unwrap();
        assert!(children.iter().all(|child| child["child_frame_id"] != "world"));
    }
    assert_eq!(json(&bytes, "/scene")[0]["entities"][0]["frame_id"], "world");
}

/// Tests that the file names its schemas as Foxglove and ROS 2 do, without references in them, and has the same bytes
/// each time.
#[test]
fn the_file_has_known_schemas() {
    let recording = reach("foliage", 1, 30);
    let (_folder, path) = file("reach.mcap");
    write_mcap(&path, &recording).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes, encode(&recording).unwrap());
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let found: BTreeMap<&str, (&str, &str, &str)> = summary
        .channels
        .values()
        .map(|channel| {
            let schema = channel.schema.as_ref().unwrap();
            let parts = (schema.name.as_str(), schema.encoding.as_str(), channel.message_encoding.as_str());
            (channel.topic.as_str(), parts)
        })
        .collect();
    let ros = ("sensor_msgs/msg/JointState", "ros2msg", "cdr");
    let foxglove = |name| (name, "jsonschema", "json");
    let expected = BTreeMap::from([
        ("/joint_states", ros),
        ("/equilibrium", ros),
        ("/tf", foxglove("foxglove.FrameTransforms")),
        ("/scene", foxglove("foxglove.SceneUpdate")),
        ("/goal", foxglove("foxglove.SceneUpdate")),
        ("/skin/sleeve", foxglove("foxglove.Grid")),
        ("/skin/sleeve/pressed", foxglove("foxglove.PointCloud")),
        ("/skin/tip/pressed", foxglove("foxglove.PointCloud")),
    ]);
    assert_eq!(found, expected);
    for schema in summary.schemas.values().filter(|schema| schema.encoding == "jsonschema") {
        let text = std::str::from_utf8(&schema.data).unwrap();
        assert!(!text.contains("$ref"), "{text}");
        let parsed: Value = serde_json::from_str(text).unwrap();
        assert_eq!((&parsed["title"], &parsed["type"]), (&schema.name.as_str().into(), &"object".into()));
    }
}
