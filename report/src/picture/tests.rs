//! Pictures of moments made by hand.

use glam::DQuat;
use underbrush_recording::{Frame, Patch, Pose, Taxel, TaxelReading};
use underbrush_sim::geometry::Capsule;
use xml::reader::{EventReader, XmlEvent};

use super::*;

fn capsule(start: [f64; 3], end: [f64; 3]) -> Capsule {
    Capsule {
        start: start.into(),
        end: end.into(),
        radius_m: 0.04,
    }
}

/// An arm from the origin to `hand`, a trunk, a leaf, and two taxels that report a force, one of them spurious.
fn moment(hand: [f64; 3], goal: [f64; 3]) -> (Snapshot, SkinLayout) {
    let reading = |taxel, object| TaxelReading {
        patch: 0,
        taxel,
        true_normal_force_n: 0.0,
        true_shear_force_n: [0.0; 2],
        sensed_force_n: 1.0,
        object,
    };
    let pose = Pose {
        position: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
    };
    let frame = Frame {
        time_s: 1.0,
        joint_angle_rad: Vec::new(),
        joint_velocity_rad_per_s: Vec::new(),
        equilibrium_angle_rad: Vec::new(),
        joint_torque_nm: Vec::new(),
        end_effector_pose_world: pose,
        goal_position_world: goal.into(),
        goal_index: 0,
        patch_pose_world: vec![pose],
        contact_force_world: vec![DVec3::ZERO],
        taxels: vec![reading(0, Some(0)), reading(1, None)],
    };
    let taxel = Taxel {
        position_link: DVec3::from(hand) / 2.0,
        normal_link: DVec3::Z,
        tangent_link: DVec3::X,
        area_m2: 1e-4,
    };
    let layout = SkinLayout {
        patches: vec![Patch {
            name: "sleeve".into(),
            link: "arm".into(),
            grid: None,
            taxels: vec![taxel; 2],
        }],
    };
    let snapshot = Snapshot {
        arm: vec![capsule([0.0; 3], hand)],
        objects: vec![
            (Category::TRUNK, vec![capsule([0.5, 0.1, -0.58], [0.5, 0.1, 0.0])]),
            (Category::LEAF, vec![capsule([0.4, -0.2, -0.5], [0.4, -0.2, 0.1])]),
        ],
        frame,
    };
    (snapshot, layout)
}

fn drawn(hand: [f64; 3], goal: [f64; 3], caption: &str) -> String {
    let (snapshot, layout) = moment(hand, goal);
    draw(&snapshot, &layout, &[Category::TRUNK], &Workspace::default(), caption)
}

/// All text of an SVG; panics if it is not well-formed XML.
fn words(svg: &str) -> String {
    let mut words = String::new();
    for event in EventReader::from_str(svg) {
        if let XmlEvent::Characters(text) = event.unwrap() {
            words += &(text + "\n");
        }
    }
    words
}

/// Pins that every panel shows all of an arm of any size, the objects, the goal and the workspace.
#[test]
fn the_frame_holds_arm_and_scene() {
    for (hand, goal) in [
        ([0.8, 0.0, 0.2], [0.7, -0.2, -0.3]),
        ([0.1, 0.1, 0.1], [0.3, 0.0, 0.0]),
        ([3.0, -2.0, 1.5], [2.5, 1.0, 2.0]),
        ([-0.2, 0.3, 4.0], [0.0, 0.0, 4.5]),
    ] {
        let (snapshot, _) = moment(hand, goal);
        let workspace = Workspace::default();
        let views = views(&snapshot, &workspace, 500.0);
        for (panel, view) in PANELS.iter().zip(&views) {
            let size = view.size_px();
            assert!(size.x <= 500.01 && size.y <= MAX_HEIGHT + 0.01, "{view:?}");
            let corners =
                [(0, 0), (1, 1)].map(|(x, y)| DVec3::new(workspace.x_m[x], workspace.y_m[y], workspace.table_height_m));
            let ends = snapshot
                .arm
                .iter()
                .chain(snapshot.objects.iter().flat_map(|object| &object.1));
            let ends = ends.flat_map(|capsule| [capsule.start, capsule.end]);
            for point in ends.chain(corners).chain([DVec3::from(goal)]) {
                let at = panel.to_pixels(view, point);
                assert!(
                    at.cmpge(DVec2::ZERO).all() && at.cmple(size).all(),
                    "{point} at {at} of {view:?}"
                );
            }
        }
        assert_eq!((views[0].corner.x, views[0].scale), (views[1].corner.x, views[1].scale));
    }
}

/// Pins that text from a scene cannot break the SVG and reads as it was written.
#[test]
fn captions_are_escaped() {
    let caption = "leaves & <trunks> \"5 > 3\" ]]> 'x'";
    let text = words(&drawn([0.8, 0.0, 0.2], [0.7, -0.2, -0.3], caption));
    assert!(text.contains(caption), "{text}");
}

/// Pins that the legend explains every kind of mark that is drawn, and no category that is not there.
#[test]
fn every_mark_is_explained() {
    let text = words(&drawn([0.8, 0.0, 0.2], [0.7, -0.2, -0.3], "caption"));
    for mark in [
        "leaf",
        "trunk",
        "arm",
        "goal of the moment",
        "table",
        "area for the feet of objects",
        "filled as what it touches",
        "touches nothing",
        "1 N",
    ] {
        assert!(text.contains(mark), "no {mark:?} in {text}");
    }
    assert!(!text.contains("foam"), "{text}");
}
