use super::*;
use crate::touch::{REGION_FEATURES, SkinTracker};
use crate::trial::tests::recording;

fn tracker(recording: &Recording) -> SkinTracker {
    SkinTracker::new(&recording.layout, None, 0.03).unwrap()
}

/// The value of a feature of the only region.
fn feature(tracker: &SkinTracker, name: &str) -> f64 {
    let place = REGION_FEATURES.iter().position(|own| *own == name).unwrap();
    tracker.regions()[0].course.features()[place]
}

/// Tests that a contact keeps its number and its course while it slides to a neighbour, that a contact elsewhere is a
/// new one, and that a contact that breaks is over.
#[test]
fn a_contact_is_followed_over_the_skin() {
    let recording = recording(&[
        (0.0, &[(7, 0.5, Some(0))]),
        (0.0, &[(7, 0.2, Some(0)), (8, 0.3, Some(0))]),
        (0.0, &[(9, 0.5, Some(0))]),
        (0.0, &[(9, 0.5, Some(0)), (0, 0.2, None)]),
        (0.0, &[]),
        (0.0, &[(9, 0.5, Some(0))]),
    ]);
    let mut tracker = tracker(&recording);
    let mut found = Vec::new();
    for frame in &recording.frames {
        tracker.update(frame).unwrap();
        let regions = tracker.regions().iter();
        found.push(regions.map(|region| (region.contact, region.course.samples())).collect::<Vec<_>>());
    }
    assert_eq!(found, [vec![(1, 1)], vec![(1, 2)], vec![(1, 3)], vec![(2, 1), (1, 4)], vec![], vec![(3, 1)],]);
}

/// Tests that both parts of a region that splits keep its course and the larger part keeps its number, and that the
/// course of the larger part continues when they merge.
#[test]
fn parts_of_a_region_keep_its_course() {
    let recording = recording(&[
        (0.0, &[(7, 0.5, Some(0)), (8, 0.1, Some(0)), (9, 0.3, Some(0))]),
        (0.0, &[(7, 0.5, Some(0)), (9, 0.3, Some(0))]),
        (0.0, &[(7, 0.5, Some(0)), (8, 0.1, Some(0)), (9, 0.3, Some(0))]),
    ]);
    let mut tracker = tracker(&recording);
    let mut found = Vec::new();
    for frame in &recording.frames {
        tracker.update(frame).unwrap();
        let regions = tracker.regions().iter();
        found.push(regions.map(|region| (region.contact, region.course.samples())).collect::<Vec<_>>());
    }
    assert_eq!(found, [vec![(1, 1)], vec![(1, 2), (2, 2)], vec![(1, 3)]]);
}

/// Tests, for a spring, that the slope of force over press is its stiffness and that the press is how far the skin moved
/// outwards, both compressed as the documentation says, ln(1 + x / knee).
#[test]
fn the_slope_of_force_over_press_is_the_stiffness() {
    let recording = presses(0, 400.0, 0.05, 0.0);
    let mut tracker = tracker(&recording);
    // The first frame with contact is number 1; up to a quarter of a period the skin moves outwards.
    for frame in &recording.frames[..11] {
        tracker.update(frame).unwrap();
    }
    let expand = |value: f64, knee: f64| value.exp_m1() * knee;
    let stiffness = expand(feature(&tracker, "slope of force over press"), 10.0);
    // The knee of the press counts as noise. It lowers the slope by the square of the ratio of 0.5 mm to the standard
    // deviation of the press, which is more than 12 mm.
    assert!((stiffness / 400.0 - 1.0).abs() < 2e-3, "{stiffness}");
    let press_m = expand(feature(&tracker, "press"), 5e-4);
    let depth = |index: f64| 0.05 * (2.0 * std::f64::consts::PI * index / 40.0).sin();
    // The logarithm is right within 1e-9, and an error of 1e-9 changes 43 mm by 43e-12 m.
    assert!((press_m - (depth(10.0) - depth(1.0))).abs() < 1e-10, "{press_m}");
    let share = feature(&tracker, "share of the strongest taxel");
    assert!((share - 0.75).abs() < 1e-12, "{share}");
}

/// Tests that a region's features do not depend on where the skin is and how it is turned.
#[test]
fn features_do_not_depend_on_the_world_frame() {
    let plain = presses(1, 300.0, 0.02, 0.05);
    let mut turned = plain.clone();
    let other = underbrush_recording::Pose::new(
        glam::DVec3::new(0.4, -1.0, 0.3),
        glam::DQuat::from_rotation_x(0.7) * glam::DQuat::from_rotation_z(1.9),
    );
    for frame in &mut turned.frames {
        frame.patch_pose_world[0] = other * frame.patch_pose_world[0];
    }
    let (mut first, mut second) = (tracker(&plain), tracker(&turned));
    let mut compared = 0;
    for (plain, turned) in plain.frames.iter().zip(&turned.frames) {
        first.update(plain).unwrap();
        second.update(turned).unwrap();
        for (own, other) in first.regions().iter().zip(second.regions()) {
            for (own, other) in own.course.features().iter().zip(other.course.features()) {
                assert!((own - other).abs() < 1e-9, "{own} {other}");
                compared += 1;
            }
        }
    }
    assert!(compared > 1000);
}
