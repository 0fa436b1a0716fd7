#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::DVec3;
use underbrush_recording::Outcome;

use super::{ReachPlan, ReachSoFar};
use crate::controller::{ControlStatus, Controller, ControllerInput, ControllerKind, ControllerOutput, Intent, Preset};
use crate::{Arm, Scene};

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
    // Tests what `stiffness_scale = 4` does to each joint: four times the stiffness, of the joint and of the
    // controller's model, and the same D²/K.
    let (published, scaled) = (Arm::cody().unwrap(), plan("stiffness_scale = 4.0").arm);
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
    for (published, scaled) in published.joints.iter().zip(&scaled.joints) {
        assert!(close(scaled.stiffness_nm_per_rad, 4.0 * published.stiffness_nm_per_rad));
        let in_model = 4.0 * published.model_stiffness_nm_per_rad;
        assert!(close(scaled.model_stiffness_nm_per_rad, in_model));
        let ratio = |joint: &crate::arm::Joint| joint.damping_nm_s_per_rad.powi(2) / joint.stiffness_nm_per_rad;
        assert!(close(ratio(scaled), ratio(published)));
    }
    assert_eq!(plan("").arm.joints, published.joints);
}

#[test]
fn a_free_hand_moves_as_fast_as_it_is_told() {
    // Tests that the mean speed of a free hand, from start to goal, is proportional to `hand_speed_scale` within a
    // tenth: the arm's lag behind its equilibrium angles takes the same time at each speed.
    let mean_speed = |scale: f64| {
        let recording = plan(&format!("hand_speed_scale = {scale:?}")).run(0, &mut |_| {}).unwrap();
        assert_eq!(recording.outcome(), Outcome::Reached);
        let place = |frame: &underbrush_recording::Frame| frame.end_effector_pose_world.position;
        let way: f64 = recording.frames.windows(2).map(|pair| place(&pair[0]).distance(place(&pair[1]))).sum();
        way / recording.frames.last().unwrap().time_s
    };
    let published = mean_speed(1.0);
    for scale in [0.25, 0.5, 2.0] {
        let ratio = mean_speed(scale) / published;
        assert!((ratio / scale - 1.0).abs() < 0.1, "{scale}: {ratio}");
    }
}

/// Tests that the rules of a plan, which its provenance holds, are those of the scene's patience: the published ones without it.
#[test]
fn rules_are_those_of_the_scenes_patience() {
    let rules = |goals: &str| {
        let text = format!("summary = \"Free space\"\ngoals = {{ count = 1, {goals} }}\n");
        ReachPlan::new(Scene::parse("free.toml", text).unwrap(), None, 0).unwrap().rules
    };
    let published = super::ReachRules::published_with(ControllerKind::Cody2013);
    assert_eq!(rules("patience_s = 3.0"), published.watched_for(3.0));
    assert_ne!(rules("patience_s = 3.0"), rules("patience_s = 2.0"));
}

#[test]
fn the_allowed_force_is_scaled() {
    // Tests that `force_limit_scale` scales the f_max of each published controller and none of its other parameters.
    for kind in [ControllerKind::Cody2013, ControllerKind::IjrrFoliage] {
        let published = kind.preset();
        let text = "summary = \"x\"\n[robot]\nforce_limit_scale = 1.25\n";
        let plan = ReachPlan::new(Scene::parse("x.toml", text.into()).unwrap(), Some(kind), 0).unwrap();
        let floor_height_m = plan.scene.floor_height_m();
        let expected = Preset { force_limit_n: 1.25 * published.force_limit_n, floor_height_m, ..published };
        assert_eq!(plan.controller.preset(), Some(&expected));
    }
}

#[test]
fn scales_have_limits() {
    // Tests that a scale outside 0.1 to 10, or one that is not a number, is refused with its key and line.
    for (key, value) in [
        ("stiffness_scale", "0.0"),
        ("hand_speed_scale", "11.0"),
        ("force_limit_scale", "0.05"),
        ("stiffness_scale", "nan"),
    ] {
        let text = format!("summary = \"x\"\n[robot]\n{key} = {value}\n");
        let message = Scene::parse("x.toml", text).unwrap_err().to_string();
        assert!(message.contains(&format!("robot.{key}")) && message.contains("0.1 to 10"), "{message}");
        assert!(message.contains('3'), "{message}");
    }
}

/// A reach to one goal behind a row of trunks.
fn through_trunks(controller: &str, retries: u32) -> ReachPlan {
    let text = format!(
        "summary = \"A row of trunks\"\n\
         controller = \"{controller}\"\n\
         [goals]\ncount = 1\nretries = {retries}\n\
         [[objects.trunk]]\ncount = 8\n\
         place = {{ x_m = {{ uniform = [0.40, 0.46] }}, y_m = {{ uniform = [-0.60, 0.15] }} }}\n"
    );
    ReachPlan::new(Scene::parse("row.toml", text).unwrap(), None, 0).unwrap()
}

#[test]
fn a_force_over_the_stop_force_ends_the_reach() {
    // Tests on simulated reaches that a goal is aborted in the first frame with more than the stop force between one
    // link and one object, that the recording names both with that force, and that no other goal follows. The second
    // published controller stops at 15 N, which impacts on a trunk exceed within a few reaches.
    let plan = through_trunks("ijrr-foliage", 0);
    let mut aborted = 0;
    for reach_index in 0..6 {
        let recording = plan.run(reach_index, &mut |_| {}).unwrap();
        let last = recording.goals.last().unwrap();
        let peak = recording.contacts.iter().map(|contact| contact.peak_force_n).fold(0.0, f64::max);
        match &last.safety_stop {
            Some(stop) => {
                aborted += 1;
                assert_eq!(last.outcome, Outcome::Aborted);
                assert!(stop.force_n > plan.rules.stop_force_n);
                // A contact is of one patch or of the bare link; the force that stops the arm is that of the whole
                // link.
                let last_frame = recording.frames.len() as u32 - 1;
                let pressing = recording.contacts.iter().filter(|contact| {
                    contact.link == stop.link && Some(contact.object) == stop.object && contact.last_frame == last_frame
                });
                let sum: f64 = pressing.map(|contact| contact.peak_force_n).sum();
                assert!(sum >= stop.force_n * (1.0 - 1e-12), "{sum} N, {stop:?}");
            }
            None => {
                assert_ne!(last.outcome, Outcome::Aborted);
                // Skin and bare part of one link press on the same side, so either alone stays under the stop force.
                assert!(peak <= plan.rules.stop_force_n, "{peak} N");
            }
        }
    }
    assert!(aborted > 0, "no reach passed the stop force");
}

#[test]
fn a_stuck_arm_backs_off_and_tries_again() {
    // Tests what `retries = 1` adds to a reach that gets stuck: the frames until then are the same; then the end
    // effector is drawn back, away from the goal, and the goal is tried again. A trunk may hold the arm before it has
    // gone the 5 cm, so in each reach the end effector must go back a centimetre, ten times what counts as stuck, and
    // in one the whole way.
    let (once, twice) = (through_trunks("cody-2013", 0), through_trunks("cody-2013", 1));
    let (mut retried, mut farthest) = (0, 0.0_f64);
    for reach_index in 0..24 {
        let first = once.run(reach_index, &mut |_| {}).unwrap();
        let second = twice.run(reach_index, &mut |_| {}).unwrap();
        let until = first.frames.len();
        assert_eq!(first.frames, second.frames[..until]);
        if first.outcome() != Outcome::Stuck {
            assert_eq!(first.frames.len(), second.frames.len());
            continue;
        }
        // An arm that is wedged between trunks cannot move back without force.
        if second.outcome() == Outcome::Aborted {
            continue;
        }
        retried += 1;
        let stuck_at = first.frames[until - 1].end_effector_pose_world.position;
        let to_goal = (first.goals[0].position_world - stuck_at).with_z(0.0).normalize();
        let back = second.frames[until..]
            .iter()
            .map(|frame| (stuck_at - frame.end_effector_pose_world.position).dot(to_goal))
            .fold(0.0, f64::max);
        assert!(back > 10.0 * once.rules.stuck_distance_m, "drawn back by {back} m");
        farthest = farthest.max(back);
    }
    assert!(retried > 0, "no reach got stuck");
    // A point counts as reached within the reached distance, and a stuck arm may still have crept a little before it
    // moved back.
    let whole_way = 0.05 - once.rules.reached_distance_m - once.rules.stuck_distance_m;
    assert!(farthest >= whole_way, "{farthest} m, {whole_way} m");
}

/// Stands still for some legs and gives up every third of them; then it goes on as the inner controller does.
struct Hesitant {
    inner: Box<dyn Controller>,
    still_legs: usize,
    /// The first leg that it gives up.
    given_up_leg: usize,
    /// The target of each leg.
    targets_world: Arc<Mutex<Vec<DVec3>>>,
}

impl Controller for Hesitant {
    fn name(&self) -> &str {
        "hesitant"
    }

    fn rate_hz(&self) -> f64 {
        self.inner.rate_hz()
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        let mut targets_world = self.targets_world.lock().unwrap();
        if targets_world.last() != Some(&input.goal_position_world) {
            targets_world.push(input.goal_position_world);
        }
        let leg = targets_world.len() - 1;
        if leg >= self.still_legs {
            return self.inner.control(input);
        }
        ControllerOutput {
            equilibrium_angle_rad: input.equilibrium_angle_rad.to_vec(),
            status: ControlStatus::Solved,
            intent: if leg % 3 == self.given_up_leg { Intent::GivenUp("no way".into()) } else { Intent::Onward },
        }
    }
}

#[test]
fn a_reason_for_giving_up_ends_with_its_leg() {
    // Tests that a reason for giving up the way back is not recorded for the goal, whether it is reached later or the arm
    // gets stuck again, and does not keep the arm from trying again. A goal that is given up itself keeps its reason.
    let hesitant = |still_legs, given_up_leg, retries| {
        let mut plan = plan("");
        plan.scene.file.goals.retries = retries;
        plan.rules.stuck_window_s = 0.5;
        let targets_world = Arc::new(Mutex::new(Vec::new()));
        let shown = targets_world.clone();
        let wrap = move |inner| -> Box<dyn Controller> {
            Box::new(Hesitant { inner, still_legs, given_up_leg, targets_world: shown.clone() })
        };
        let recording = plan.with_controller_within(wrap).run(0, &mut |_| {}).unwrap();
        let legs = targets_world.lock().unwrap().len();
        (legs, recording.goals[0].outcome, recording.goals[0].given_up.clone())
    };
    assert_eq!(hesitant(3, 1, 1), (4, Outcome::Reached, None));
    assert_eq!(hesitant(usize::MAX, 1, 2), (7, Outcome::Stuck, None));
    assert_eq!(hesitant(usize::MAX, 0, 2), (1, Outcome::Stuck, Some("no way".to_owned())));
}

#[test]
fn a_watched_reach_is_the_recorded_one() {
    // Tests that the recording so far has exactly the frames, poses, contacts and map that the finished one begins with, and
    // that there is none before the first frame.
    let scene = Scene::open(Path::new("trunk")).unwrap();
    let plan = ReachPlan::new(scene, Some(ControllerKind::Mapped), 0).unwrap();
    let mut so_far = ReachSoFar::new(&plan, 0);
    assert!(so_far.recording().is_none());
    let mut early = None;
    let finished = plan
        .run(0, &mut |observed| {
            so_far.observe(observed);
            if observed.frame.time_s >= 0.1 && early.is_none() {
                early = so_far.recording();
            }
        })
        .unwrap();
    let (early, last) = (early.unwrap(), so_far.recording().unwrap());
    assert_eq!(last.frames, finished.frames);
    assert_eq!(last.bodies, finished.bodies);
    assert_eq!(last.contacts, finished.contacts);
    assert!(last.map == finished.map && !last.map.is_empty(), "{:?}", last.map);
    assert_eq!(last.objects, finished.objects);
    assert!(last.goals.is_empty() && !finished.goals.is_empty());
    assert_eq!(early.frames, finished.frames[..early.frames.len()]);
    assert!(early.frames.len() < 20, "{} frames", early.frames.len());
    for (early, finished) in early.bodies.iter().zip(&finished.bodies) {
        assert_eq!(early.track, finished.track[..early.track.len()]);
    }
}

#[test]
fn a_reach_stops_when_it_is_told() {
    // Tests that a reach that is stopped ends before its next frame, without a recording, and that the frames until
    // then are those of a reach that is not stopped.
    let plan = plan("");
    let whole = plan.run(0, &mut |_| {}).unwrap();
    let seen = std::cell::RefCell::new(Vec::new());
    let mut observer = |super::Observed { frame, .. }: super::Observed| {
        seen.borrow_mut().push(frame.clone());
    };
    let stopped = plan.run_until(0, &mut observer, &|| seen.borrow().len() == 5);
    assert!(matches!(stopped, Err(super::ReachError::Stopped)), "{stopped:?}");
    assert_eq!(seen.into_inner(), whole.frames[..5]);
}
