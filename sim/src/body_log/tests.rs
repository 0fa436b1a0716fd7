#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::Path;

use underbrush_recording::body::{ORIENTATION_TOLERANCE_RAD, POSITION_TOLERANCE_M};
use underbrush_recording::{Body, BodyOwner, BodyShape, Category, Pose, Recording};

use crate::{Observed, ReachPlan, Scene};

/// The simulation's poses of the bodies of every object in one frame.
type ObjectPoses = Vec<Vec<Pose>>;

/// A reach for one goal in a shipped scene, with the poses of the bodies that have shapes, frame by frame.
fn watched(scene: &str) -> (ReachPlan, Recording, Vec<ObjectPoses>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(scene);
    let mut scene = Scene::load(path).unwrap();
    scene.file.goals.count = 1;
    let plan = ReachPlan::new(scene, None, 3).unwrap();
    let mut frames = Vec::new();
    let recording = plan.run(0, &mut |Observed { simulation, .. }| {
        let objects = simulation.report().objects.iter().enumerate();
        let poses = objects.map(|(object, state)| {
            let bodies = simulation.structure(object).bodies.iter().zip(&state.body_pose_world);
            let with_shapes = bodies.filter(|(body, _)| !body.parts.is_empty());
            with_shapes.map(|(_, pose)| *pose).collect()
        });
        frames.push(poses.collect());
    });
    (plan, recording.unwrap(), frames)
}

/// How far a stored pose is from the true one: m and rad.
fn difference(stored: &Pose, truth: &Pose) -> (f64, f64) {
    let cosine = stored.orientation.dot(truth.orientation).abs().min(1.0);
    // The sine of half the angle is accurate for small angles.
    let sine = (stored.orientation * truth.orientation.inverse()).xyz().length();
    let angle = if cosine > 0.9 { 2.0 * sine.asin() } else { 2.0 * cosine.acos() };
    (stored.position.distance(truth.position), angle)
}

#[track_caller]
fn assert_same(stored: &Pose, truth: &Pose, what: impl std::fmt::Debug) {
    let (distance_m, angle_rad) = difference(stored, truth);
    assert!(distance_m <= POSITION_TOLERANCE_M, "{what:?}: {distance_m} m");
    assert!(angle_rad <= ORIENTATION_TOLERANCE_RAD, "{what:?}: {angle_rad} rad");
}

fn bodies_of(recording: &Recording, object: usize) -> Vec<&Body> {
    let own = |body: &&Body| body.owner == BodyOwner::Object(object as u16);
    recording.bodies.iter().filter(own).collect()
}

/// Tests that the stored pose of every body equals the engine's in every frame, within the tolerances, in the scenes
/// with leaves, foam and a foam roll; and that objects that are left out of the engine stay as they were built.
#[test]
fn stored_poses_are_the_engines() {
    for scene in ["leaf.toml", "outlier.toml"] {
        let (_, recording, frames) = watched(scene);
        let mut moved = 0;
        for object in 0..recording.objects.len() {
            for (number, body) in bodies_of(&recording, object).into_iter().enumerate() {
                moved += usize::from(!body.track.is_empty());
                for (frame, poses) in frames.iter().enumerate() {
                    let truth = &poses[object][number];
                    let stored = body.pose_world(frame as u32);
                    assert_same(&stored, truth, (scene, object, number, frame));
                }
            }
        }
        assert!(moved > 4, "{scene}: only {moved} bodies of objects moved");
    }
}

/// Tests that the stored poses of the links equal the forward kinematics of the stored joint angles.
#[test]
fn stored_link_poses_follow_from_the_joint_angles() {
    let (plan, recording, _) = watched("trunk.toml");
    for (frame, sample) in recording.frames.iter().enumerate() {
        let expected = plan.arm.forward_kinematics(&sample.joint_angle_rad);
        for (index, (link, pose)) in plan.arm.links.iter().zip(expected).enumerate() {
            let body = &recording.bodies[index];
            assert_eq!(body.owner, BodyOwner::Link(link.name.clone()));
            assert_same(&body.pose_world(frame as u32), &pose, (&link.name, frame));
        }
    }
    assert!(recording.bodies[1].track.len() > 10, "the arm moves");
}

/// Tests the bodies of each object: a leaf has all of its pieces, a trunk is one fixed capsule of its height and
/// diameter, and a block is one box of its size.
#[test]
fn bodies_have_the_shapes_of_their_objects() {
    let (_, recording, _) = watched("mixed.toml");
    let mut seen = std::collections::BTreeSet::new();
    for (index, object) in recording.objects.iter().enumerate() {
        let bodies = bodies_of(&recording, index);
        let parameter = |name: &str| object.parameters[name];
        seen.insert(object.category);
        match object.category {
            Category::LEAF => {
                // The root's piece and one above each bending hinge, together as high as the leaf.
                assert_eq!(bodies.len() as f64, parameter("segments") + 1.0);
                let heights = bodies.iter().map(|body| match &body.parts[0].shape {
                    BodyShape::Box { size_m } => size_m.z,
                    other => panic!("{other:?}"),
                });
                assert!((heights.sum::<f64>() - parameter("height_m")).abs() < 1e-9);
            }
            Category::TRUNK => {
                let [body] = bodies[..] else { panic!("{bodies:?}") };
                let BodyShape::Capsule { radius_m, length_m } = body.parts[0].shape else { panic!("{body:?}") };
                assert!((2.0 * radius_m - parameter("diameter_m")).abs() < 1e-12);
                // The lower round end is beneath the table.
                assert!((length_m + radius_m - parameter("height_m")).abs() < 1e-12);
                let top = body.parts[0].pose_body.transform_point(glam::DVec3::Z * (length_m / 2.0));
                assert!((top.z + radius_m - parameter("height_m")).abs() < 1e-12);
                assert!(body.track.is_empty());
            }
            Category::BLOCK => {
                let [body] = bodies[..] else { panic!("{bodies:?}") };
                let BodyShape::Box { size_m } = body.parts[0].shape else { panic!("{body:?}") };
                let expected = ["length_m", "width_m", "height_m"].map(parameter);
                assert!((size_m - glam::DVec3::from_array(expected)).length() < 1e-12);
            }
            other => panic!("no {other:?} stands in this scene"),
        }
    }
    assert!(seen.contains(&Category::LEAF) && seen.contains(&Category::TRUNK), "{seen:?}");
}
