//! Pictures of moments made by hand.

use glam::DQuat;
use underbrush_recording::{Frame, Patch, Pose, Taxel, TaxelReading};
use underbrush_sim::geometry::Capsule;
use underbrush_sim::snapshot::{Blade, BladePiece, ObjectShapes};

use super::*;

fn capsule(start: [f64; 3], end: [f64; 3]) -> Capsule {
    Capsule { start: start.into(), end: end.into(), radius_m: 0.04 }
}

/// A leaf of two pieces of 0.3 m each. The upper one leans towards x by this angle, rad.
fn blade(foot: DVec3, angle_rad: f64) -> Blade {
    let upper = DQuat::from_scaled_axis(DVec3::Y * angle_rad);
    let piece = |position, orientation| BladePiece { pose_world: Pose { position, orientation }, length_m: 0.3 };
    Blade { width_m: 0.05, pieces: vec![piece(foot, DQuat::IDENTITY), piece(foot + DVec3::Z * 0.3, upper)] }
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
    let pose = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let frame = Frame {
        time_s: 1.0,
        end_effector_pose_world: pose,
        goal_position_world: goal.into(),
        patch_pose_world: vec![pose],
        taxels: vec![reading(0, Some(0)), reading(1, None)],
        ..Frame::blank(1)
    };
    let taxel =
        Taxel { position_link: DVec3::from(hand) / 2.0, normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1e-4 };
    let layout = SkinLayout {
        patches: vec![Patch { name: "sleeve".into(), link: "arm".into(), grid: None, taxels: vec![taxel; 2] }],
    };
    let snapshot = Snapshot {
        arm: vec![capsule([0.0; 3], hand)],
        objects: vec![
            ObjectShapes {
                category: Category::TRUNK,
                capsules: vec![capsule([0.5, 0.1, -0.58], [0.5, 0.1, 0.0])],
                blades: Vec::new(),
            },
            ObjectShapes {
                category: Category::LEAF,
                capsules: Vec::new(),
                blades: vec![blade([0.4, -0.2, -0.5].into(), 0.3)],
            },
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
    let parsed = roxmltree::Document::parse(svg).unwrap();
    parsed
        .descendants()
        .filter(|node| node.is_text())
        .filter_map(|node| node.text())
        .map(|text| format!("{text}\n"))
        .collect()
}

/// Tests that every panel shows all of an arm of any size, the objects, the goal and the workspace.
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
            let ends = extent(&snapshot).into_iter().map(|(point, _)| point);
            for point in ends.chain(corners).chain([DVec3::from(goal)]) {
                let at = panel.to_pixels(view, point);
                assert!(at.cmpge(DVec2::ZERO).all() && at.cmple(size).all(), "{point} at {at} of {view:?}");
            }
        }
        assert_eq!((views[0].corner.x, views[0].scale), (views[1].corner.x, views[1].scale));
    }
}

/// Tests that text from a scene cannot break the SVG and is read back as it was written.
#[test]
fn captions_are_escaped() {
    let caption = "leaves & <trunks> \"5 > 3\" ]]> 'x'";
    let text = words(&drawn([0.8, 0.0, 0.2], [0.7, -0.2, -0.3], caption));
    assert!(text.contains(caption), "{text}");
}

/// Tests that the legend explains every kind of mark that is drawn, and no category that is not in the picture.
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

/// All numbers of a path's `d`.
fn numbers(path: &str) -> Vec<f64> {
    let split = |character: char| !(character.is_ascii_digit() || ".-".contains(character));
    path.split(split).filter_map(|word| word.parse().ok()).collect()
}

/// Tests that the outline of a leaf passes through every hinge and is smooth there, and that it is as wide as the leaf.
#[test]
fn a_leaf_is_a_smooth_curve_through_its_hinges() {
    let (panel, foot) = (&PANELS[0], DVec3::new(0.4, 0.0, 0.0));
    let view = View { corner: DVec2::ZERO, size_m: DVec2::ONE, scale: 1000.0 };
    let path = blade::path(&blade(foot, 0.5), |point| panel.to_pixels(&view, point));
    // From the right the blade is seen from its edge: up and down along the same curve.
    let points: Vec<DVec2> = numbers(&path).chunks(2).map(|pair| DVec2::new(pair[0], pair[1])).collect();
    // The start, then per piece two control points and an end.
    let hinge = panel.to_pixels(&view, foot + DVec3::Z * 0.3);
    assert!(points[0].distance(panel.to_pixels(&view, foot)) < 0.1, "{path}");
    assert!(points[3].distance(hinge) < 0.1, "{path}");
    let (before, after) = ((points[3] - points[2]).normalize(), (points[4] - points[3]).normalize());
    assert!(before.distance(after) < 0.01, "a corner at the hinge: {path}");
    let expected = DVec2::new((0.25_f64).sin(), -(0.25_f64).cos());
    assert!(before.distance(expected) < 0.01, "{before} is not the mean direction {expected}");
    let tip = foot + DVec3::Z * 0.3 + DQuat::from_scaled_axis(DVec3::Y * 0.5) * (DVec3::Z * 0.3);
    assert!(points[6].distance(panel.to_pixels(&view, tip)) < 0.1, "{path}");
    let above = numbers(&blade::path(&blade(foot, 0.5), |point| PANELS[1].to_pixels(&view, point)));
    let y: Vec<f64> = above.chunks(2).map(|pair| pair[1]).collect();
    let width = y.iter().copied().fold(f64::MIN, f64::max) - y.iter().copied().fold(f64::MAX, f64::min);
    assert!((width - 50.0).abs() < 0.2, "{width} px");
}
