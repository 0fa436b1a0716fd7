//! The rules that end an attempt, each at its limit, on made-up paths of the end effector.

use super::*;
use crate::controller::Intent::{GivenUp, Onward, TurningRound};

/// Rules with numbers that are sums of a few powers of two, so that limits are met exactly: stuck under 2⁻¹⁰ m in 8
/// frames.
fn rules() -> ReachRules {
    ReachRules {
        stop_force_n: 16.0,
        reached_distance_m: 0.0625,
        stuck_distance_m: 1.0 / 1024.0,
        stuck_window_s: 0.08,
        time_out_s: 0.25,
        progress: ProgressRule::MeanPosition,
    }
}

fn far() -> DVec3 {
    DVec3::new(100.0, 0.0, 0.0)
}

/// The frame, counted from 1, in which an end effector on this path ends its attempt at a distant goal, and the
/// outcome.
fn end(rules: ReachRules, position_m: impl Fn(usize) -> f64) -> Option<(usize, Outcome)> {
    let mut monitor = Monitor::new(rules, far());
    (1..=200).find_map(|frame| {
        let outcome = monitor.observe(DVec3::X * position_m(frame), 0.0, &Onward)?;
        Some((frame, outcome))
    })
}

/// Tests that only a force over the stop force aborts, and that it does so even at the goal.
#[test]
fn a_force_over_the_stop_force_aborts() {
    let mut monitor = Monitor::new(rules(), DVec3::ZERO);
    assert_eq!(monitor.observe(far(), 16.0, &Onward), None);
    assert_eq!(monitor.observe(far(), 16.000001, &Onward), Some(Outcome::Aborted));
    let mut monitor = Monitor::new(rules(), DVec3::ZERO);
    assert_eq!(monitor.observe(DVec3::ZERO, 17.0, &Onward), Some(Outcome::Aborted));
}

/// Tests that a goal is reached at less than the distance, in any direction, and not exactly at it.
#[test]
fn a_goal_is_reached_within_the_distance() {
    let mut monitor = Monitor::new(rules(), DVec3::ZERO);
    assert_eq!(monitor.observe(DVec3::Z * 0.0625, 0.0, &Onward), None);
    assert_eq!(monitor.observe(DVec3::Y * -0.0624, 16.0, &Onward), Some(Outcome::Reached));
}

/// Tests that the arm is stuck if the means of the window's halves are closer than the distance, as soon as the window
/// is full and no sooner. At a speed of v per frame, the means of 4 and 4 frames are 4 v apart.
#[test]
fn an_end_effector_without_progress_is_stuck() {
    let border_m = 1.0 / 4096.0;
    assert_eq!(end(rules(), |frame| frame as f64 * border_m), Some((25, Outcome::TimedOut)));
    assert_eq!(end(rules(), |frame| frame as f64 * 0.99 * border_m), Some((8, Outcome::Stuck)));
    // 4 and 5 frames of a window of 9: the means are 4.5 v apart.
    let odd = || ReachRules { stuck_window_s: 0.09, ..rules() };
    let border_m = border_m * 8.0 / 9.0;
    assert_eq!(end(odd(), |frame| frame as f64 * 1.01 * border_m), Some((25, Outcome::TimedOut)));
    assert_eq!(end(odd(), |frame| frame as f64 * 0.99 * border_m), Some((9, Outcome::Stuck)));
}

/// Tests that an arm that shakes in place is stuck, and that an arm that stops after moving is stuck once it has been
/// at rest for the whole window.
#[test]
fn shaking_is_no_headway() {
    let shaking = |frame: usize| if frame.is_multiple_of(2) { 0.5 } else { -0.5 };
    assert_eq!(end(rules(), shaking), Some((8, Outcome::Stuck)));
    // 1 cm per frame until frame 10, then rest. At frame 16 the window begins with frame 9, 1 cm behind, which moves
    // the mean of its first four back by 2.5 mm; at frame 17 it contains only rest.
    let stopping = |frame: usize| frame.min(10) as f64 * 0.01;
    assert_eq!(end(rules(), stopping), Some((17, Outcome::Stuck)));
}

/// Tests that an attempt ends in the frame in which its time is over, and that being stuck in that frame takes
/// precedence.
#[test]
fn time_runs_out() {
    let moving = |frame: usize| frame as f64;
    assert_eq!(end(rules(), moving), Some((25, Outcome::TimedOut)));
    let short = ReachRules { time_out_s: 0.08, ..rules() };
    assert_eq!(end(short, moving), Some((8, Outcome::TimedOut)));
    assert_eq!(end(short, |_| 0.0), Some((8, Outcome::Stuck)));
}

/// Tests that by the rule of the path an arm that goes out and comes back makes progress, although its mean positions
/// coincide, and that it is stuck a window after it last moved by the distance.
#[test]
fn an_arm_that_turns_round_makes_progress_along_its_path() {
    let by_path = || ReachRules { progress: ProgressRule::Path, ..rules() };
    // Out for 4 frames and back for 4, twice the distance in each frame.
    let turning = |frame: usize| ((frame - 1) % 8).min(7 - (frame - 1) % 8) as f64 / 512.0;
    assert_eq!(end(rules(), turning).map(|(_, outcome)| outcome), Some(Outcome::Stuck));
    assert_eq!(end(by_path(), turning), Some((25, Outcome::TimedOut)));
    // It moves in frames 2 to 5 and stands from then on: 8 frames without progress follow frame 5.
    assert_eq!(end(by_path(), |frame| frame.min(5) as f64 / 512.0), Some((13, Outcome::Stuck)));
    // It shakes by less than the distance.
    assert_eq!(end(by_path(), |frame| (frame % 2) as f64 / 2048.0), Some((8, Outcome::Stuck)));
}

/// Tests that an arm whose controller says that it turns round is not stuck, and that the window begins anew when it
/// says so no more, under both rules.
#[test]
fn turning_round_is_not_being_stuck() {
    for progress in [ProgressRule::MeanPosition, ProgressRule::Path] {
        let mut monitor = Monitor::new(ReachRules { progress, time_out_s: 1.0, ..rules() }, far());
        let mut observe = |intent| monitor.observe(DVec3::ZERO, 0.0, &intent);
        assert!((0..20).all(|_| observe(TurningRound).is_none()));
        let ended = (1..20).find(|_| observe(Onward) == Some(Outcome::Stuck));
        assert!(matches!(ended, Some(7 | 8)), "{ended:?}");
    }
}

/// Tests that a goal ends as soon as the controller gives it up.
#[test]
fn a_goal_that_is_given_up_ends() {
    let mut monitor = Monitor::new(rules(), far());
    assert_eq!(monitor.observe(DVec3::ZERO, 0.0, &Onward), None);
    assert_eq!(monitor.observe(DVec3::X, 0.0, &GivenUp("no way".into())), Some(Outcome::Stuck));
}
