#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use underbrush_recording::Outcome;

use super::ReachPlan;
use crate::arm::Arm;
use crate::scene::Scene;

/// A reach to one goal with nothing in the way.
fn plan(robot: &str) -> ReachPlan {
    let text = format!(
        "summary = \"Free space\"\n\
         goals = {{ count = 1, x_m = 0.6, y_m = 0.0, z_m = -0.2 }}\n\
         [robot]\n{robot}"
    );
    ReachPlan::new(Scene::parse("free.toml", text).unwrap(), None, 0).unwrap()
}

#[test]
fn a_stiffer_arm_keeps_its_damping_ratio() {
    // Pins what `stiffness_scale = 4` does to each joint: four times the stiffness, real and believed, and the same D²/K.
    let (published, scaled) = (Arm::cody().unwrap(), plan("stiffness_scale = 4.0").arm);
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    for (published, scaled) in published.joints.iter().zip(&scaled.joints) {
        assert!(close(scaled.stiffness_nm_per_rad, 4.0 * published.stiffness_nm_per_rad));
        let believed = 4.0 * published.believed_stiffness_nm_per_rad;
        assert!(close(scaled.believed_stiffness_nm_per_rad, believed));
        let ratio = |joint: &crate::arm::Joint| joint.damping_nm_s_per_rad.powi(2) / joint.stiffness_nm_per_rad;
        assert!(close(ratio(scaled), ratio(published)));
    }
    assert_eq!(plan("").arm.joints, published.joints);
}

#[test]
fn a_free_hand_moves_as_fast_as_it_is_told() {
    // Pins that the mean speed of a hand with nothing in its way, from start to goal, goes with `hand_speed_scale`; within
    // a tenth, because the arm's lag behind its equilibrium angles takes the same time at each speed.
    let mean_speed = |scale: f64| {
        let recording = plan(&format!("hand_speed_scale = {scale:?}"))
            .run(0, &mut |_, _, _| {})
            .unwrap();
        assert_eq!(recording.outcome(), Outcome::Reached);
        let place = |frame: &underbrush_recording::Frame| frame.tip_pose_world.position;
        let way: f64 = recording
            .frames
            .windows(2)
            .map(|pair| place(&pair[0]).distance(place(&pair[1])))
            .sum();
        way / recording.frames.last().unwrap().time_s
    };
    let published = mean_speed(1.0);
    for scale in [0.25, 0.5, 2.0] {
        let ratio = mean_speed(scale) / published;
        assert!((ratio / scale - 1.0).abs() < 0.1, "{scale}: {ratio}");
    }
}

#[test]
fn scales_have_limits() {
    // Pins that a scale outside 0.1 to 10, or no number, is refused with its key and line.
    for (key, value) in [
        ("stiffness_scale", "0.0"),
        ("hand_speed_scale", "11.0"),
        ("stiffness_scale", "nan"),
    ] {
        let text = format!("summary = \"x\"\n[robot]\n{key} = {value}\n");
        let message = Scene::parse("x.toml", text).unwrap_err().to_string();
        assert!(
            message.contains(&format!("robot.{key}")) && message.contains("0.1 to 10"),
            "{message}"
        );
        assert!(message.contains('3'), "{message}");
    }
}
