//! The map and the controller, each against something that shares no code with it.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use nalgebra::Matrix3xX;
use underbrush_recording::{Frame, ObstacleKind, Pose};

use super::arm_shapes::ArmShapes;
use super::bare::BareSurface;
use super::contacts::{judged, largest_share, touches};
use super::map::{Caution, Map, Touch};
use super::*;
use crate::controller::{ContactVerdict, TaxelContact, Touched};
use crate::reach::ReachPlan;
use crate::scene::{ProgressRule, Scene};
use underbrush_recording::Outcome;

mod plans;

fn touch(x: f64, y: f64, normal: DVec3, kind: ObstacleKind, time_s: f64) -> Touch {
    Touch { position_world: DVec3::new(x, y, -0.3), outward_normal_world: normal, kind, time_s }
}

/// Tests the estimate against closed forms: one touch puts the axis a radius behind the skin, and touches all around a
/// trunk give its middle and radius.
#[test]
fn touches_give_place_and_radius() {
    let mut map = Map::default();
    assert!(map.learn(&touch(0.5, 0.0, DVec3::X, ObstacleKind::Fixed, 0.0), false));
    assert!((map.obstacles[0].axis_world().x - 0.518).abs() < 1e-4);
    // A trunk of 25 mm at (0.5, -0.1): the skin's normal points to its axis.
    let mut map = Map::default();
    for number in 0..24 {
        let angle_rad = f64::from(number) * PI / 12.0;
        let normal = DVec3::new(angle_rad.cos(), angle_rad.sin(), 0.0);
        let point = DVec3::new(0.5, -0.1, 0.0) - normal * 0.025;
        map.learn(&touch(point.x, point.y, normal, ObstacleKind::Fixed, f64::from(number)), false);
    }
    let [own] = &map.obstacles[..] else { panic!("{} obstacles", map.obstacles.len()) };
    assert!(own.axis_world().distance(glam::DVec2::new(0.5, -0.1)) < 1e-3, "{:?}", own.mean_m);
    assert!((own.radius_m() - 0.025).abs() < 2e-3, "{}", own.radius_m());
    let deviation_m = own.covariance_m2.diagonal().map(f64::sqrt);
    assert!(deviation_m.max() < 0.006, "{deviation_m}");
}

/// Tests that what gives way is forgotten first and with the goal, and that the obstacle that was touched last stays.
#[test]
fn the_newest_obstacle_is_kept() {
    let kinds = [ObstacleKind::Fixed, ObstacleKind::Doubtful, ObstacleKind::Yielding, ObstacleKind::Fixed];
    let mut map = Map::default();
    for (number, kind) in kinds.into_iter().enumerate() {
        map.learn(&touch(0.2 * number as f64, 0.0, DVec3::X, kind, number as f64), false);
    }
    let of = |map: &Map| map.obstacles.iter().map(|own| own.kind).collect::<Vec<_>>();
    let mut later = map.clone();
    later.begin_goal();
    assert_eq!(of(&later), [ObstacleKind::Fixed, ObstacleKind::Doubtful, ObstacleKind::Fixed]);
    assert!(map.forget_one());
    assert_eq!(of(&map), [ObstacleKind::Fixed, ObstacleKind::Doubtful, ObstacleKind::Fixed]);
    assert!(map.forget_one() && map.forget_one() && !map.forget_one());
    assert!((map.obstacles[0].axis_world().x - 0.618).abs() < 1e-4);
}

/// Tests that a later verdict corrects an earlier one, and that a stop without a verdict does not.
#[test]
fn later_verdicts_correct_earlier_ones() {
    let mut map = Map::default();
    for (kind, time_s, expected) in [
        (ObstacleKind::Doubtful, 0.0, ObstacleKind::Doubtful),
        (ObstacleKind::Fixed, 1.0, ObstacleKind::Fixed),
        (ObstacleKind::Doubtful, 2.0, ObstacleKind::Fixed),
        (ObstacleKind::Yielding, 3.0, ObstacleKind::Yielding),
    ] {
        map.learn(&touch(0.5, 0.0, DVec3::X, kind, time_s), false);
        assert_eq!((map.obstacles.len(), map.obstacles[0].kind), (1, expected));
    }
}

/// Tests that an obstacle that the arm is inside of is forgotten if it is not felt, and is no obstacle for this goal if
/// it is felt, because the arm has pushed it aside.
#[test]
fn the_arm_cannot_be_where_an_obstacle_is() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let poses = arm.forward_kinematics(&arm.start_posture_rad());
    let hand = arm.end_effector_pose(&poses).position;
    let mut map = Map::default();
    map.learn(&Touch { position_world: hand, ..touch(hand.x, hand.y, DVec3::Z, ObstacleKind::Fixed, 10.0) }, false);
    let mut felt = map.clone();
    felt.visit(&shapes, &poses, 0.0, 10.1);
    assert_eq!((felt.obstacles.len(), felt.capsules(Caution::NONE, 0.0).len()), (1, 0));
    map.visit(&shapes, &poses, 0.0, 11.0);
    assert!(map.obstacles.is_empty());
}

/// Tests the posture along a path whose joints have different speeds: the slower joint decides.
#[test]
fn a_path_takes_the_steps_of_its_slowest_joint() {
    let path = Path::new(vec![vec![0.0, 0.0], vec![0.4, 0.1], vec![0.4, -0.1]], &[0.1, 0.01]);
    assert!((path.length() - 30.0).abs() < 1e-9);
    let close = |found: Vec<f64>, expected: [f64; 2]| {
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9), "{found:?}");
    };
    close(path.at(5.0), [0.2, 0.05]);
    close(path.at(20.0), [0.4, 0.0]);
    close(path.at(99.0), [0.4, -0.1]);
    close(Path::new(vec![vec![1.0, 2.0]], &[0.1, 0.1]).at(3.0), [1.0, 2.0]);
}

/// A contact on a lever of one joint: a positive change of the angle moves it along x.
fn contact(force_n: f64, inward: DVec3, category: Option<(&str, f64)>) -> TaxelContact {
    let named = |name: &str| ContactVerdict { touched: Touched::Category(name.into()), probability: 0.9 };
    TaxelContact {
        patch: 0,
        taxel: 0,
        link: 1,
        position_world: DVec3::ZERO,
        position_jacobian: Matrix3xX::from_column_slice(&[0.5, 0.0, 0.0]),
        inward_normal_world: inward,
        force_n,
        allowed_force_n: category.map(|(_, allowed_n)| allowed_n),
        verdict: category.map(|(name, _)| named(name)),
    }
}

/// Tests that a category is fixed if it may be pressed less than usual and gives way otherwise, whatever its name; that
/// contacts without a category are doubtful, or give way if all obstacles are known; and that what a model does not call
/// fixed may be pressed like what gives way, unless it has a limit of its own.
#[test]
fn allowed_forces_decide_what_is_fixed() {
    let plain = |force_n: f64| contact(force_n, DVec3::NEG_X, None);
    let uncertain = Some(ContactVerdict { touched: Touched::Uncertain, probability: 0.6 });
    let contacts = [
        contact(1.0, DVec3::NEG_X, Some(("reed", 1.5))),
        contact(1.0, DVec3::NEG_X, Some(("trunk", 5.0))),
        plain(1.0),
        TaxelContact { verdict: uncertain.clone(), ..plain(1.0) },
        TaxelContact { verdict: uncertain, allowed_force_n: Some(2.0), ..plain(1.0) },
    ];
    let [fixed, yielding, doubtful] = [ObstacleKind::Fixed, ObstacleKind::Yielding, ObstacleKind::Doubtful];
    let kinds =
        |knows_all| judged(&contacts, 3.0, knows_all).iter().map(|own| (own.kind, own.limit_n)).collect::<Vec<_>>();
    assert_eq!(kinds(false), [(fixed, 1.5), (yielding, 5.0), (doubtful, 3.0), (doubtful, 6.0), (doubtful, 2.0)]);
    assert_eq!(kinds(true)[2], (yielding, 6.0));
}

/// Tests that a force counts against a motion into its contact, and not against one away from it.
#[test]
fn only_motion_into_a_contact_is_limited() {
    let contacts = [contact(4.5, DVec3::NEG_X, None)];
    let judged = judged(&contacts, 3.0, false);
    assert_eq!(largest_share(&judged, &[0.1]), 1.5);
    assert_eq!(largest_share(&judged, &[-0.1]), 0.0);
    assert_eq!(largest_share(&judged, &[0.0]), 1.5);
}

/// Tests that contacts close together are one touch, at their middle by force, and distant ones another.
#[test]
fn contacts_close_together_are_one_touch() {
    let at =
        |x: f64, force_n: f64| TaxelContact { position_world: DVec3::X * x, ..contact(force_n, DVec3::NEG_Y, None) };
    let contacts = [at(0.0, 1.0), at(0.02, 3.0), at(0.3, 0.5), at(0.31, 0.2)];
    let touches = touches(&judged(&contacts, 3.0, false), ObstacleKind::Doubtful, 7.0);
    let [(strong_n, first), (weak_n, second)] = &touches[..] else { panic!("{touches:?}") };
    assert_eq!((*strong_n, *weak_n), (3.0, 0.5));
    assert!((first.position_world.x - 0.015).abs() < 1e-12 && (second.position_world.x - 0.3).abs() < 1e-12);
    assert!(first.outward_normal_world.distance(DVec3::Y) < 1e-12);
}

/// A reach with a row of trunks in front of its goals.
fn plan(seed: u64) -> ReachPlan {
    let text = "summary = \"A row of trunks\"\ncontroller = \"mapped\"\n\
                goals = { count = 2, retries = 0, patience_s = 1.0, x_m = { uniform = [0.58, 0.7] } }\n\
                [[objects.trunk]]\ncount = 4\nplace = { x_m = 0.45, y_m = { uniform = [-0.45, 0.15] } }\n";
    ReachPlan::new(Scene::parse("row.toml", text.into()).unwrap(), None, seed).unwrap()
}

/// A reach of the Panda in docs/arms. Its base stands below the table.
fn plan_of_panda(seed: u64) -> ReachPlan {
    let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/arms/panda/foliage.toml")).unwrap();
    ReachPlan::new(scene, Some(crate::controller::ControllerKind::Mapped), seed).unwrap()
}

/// Tests that Cody and a Panda get round trunks that they do not know to more goals than with the published controller,
/// that a reach repeats bit for bit, and that a goal that is given up has a reason.
#[test]
fn arms_get_round_trunks() {
    let reached = |plan: &ReachPlan| {
        let reaches: Vec<_> = (0..3).map(|index| plan.run(index, &mut |_| {}).unwrap()).collect();
        for goal in reaches.iter().flat_map(|reach| &reach.goals) {
            assert_eq!(
                goal.given_up.is_some(),
                goal.outcome == Outcome::Stuck && plan.rules.progress == ProgressRule::Path
            );
        }
        reaches.iter().map(|reach| reach.goal_outcomes().reached).sum::<usize>()
    };
    let own = plan(5);
    assert!(own.run(0, &mut |_| {}).unwrap() == own.run(0, &mut |_| {}).unwrap());
    for own in [own, plan_of_panda(4)] {
        let kind = crate::controller::ControllerKind::Cody2013;
        let published = ReachPlan::new(own.scene.clone(), Some(kind), own.seed).unwrap();
        assert!(reached(&own) > reached(&published));
    }
}

/// Tests that an obstacle is at least as high as the place where it was touched, and stands as high as the tallest stems
/// before an arm whose base is lower than the table.
#[test]
fn obstacles_are_higher_than_touches() {
    let low = touch(0.5, 0.0, DVec3::X, ObstacleKind::Fixed, 0.0);
    let high = Touch { position_world: low.position_world.with_z(0.6), ..low };
    let top_m = |touch: &Touch, caution| {
        let mut map = Map::default();
        map.learn(touch, false);
        let capsule = map.capsules(caution, 0.5)[0];
        capsule.end.z + capsule.radius_m
    };
    let is_low = Caution { is_low: true, ..Caution::NONE };
    let tops_m =
        [(low, Caution::NONE), (low, is_low), (high, Caution::NONE), (high, is_low)].map(|own| top_m(&own.0, own.1));
    for (found_m, expected_m) in tops_m.into_iter().zip([0.5, -0.26, 0.64, 0.64]) {
        assert!((found_m - expected_m).abs() < 1e-12, "{tops_m:?}");
    }
    let plan = plan_of_panda(4);
    let own = Mapped::new(plan.controller.preset().unwrap().clone(), &plan.arm);
    // A table at 0.2 m under 8 cm of foam, and the first joint at 0.333 m.
    assert!((own.top_m - 0.78).abs() < 1e-12, "{}", own.top_m);
}

/// Tests that no equilibrium angle changes faster than its joint may turn, on the way, while the arm plans and when it gives a goal up.
#[test]
fn no_angle_changes_faster_than_its_joint_may_turn() {
    let mut plan = plan(5);
    plan.arm.joints.iter_mut().for_each(|joint| joint.slew_limit_rad_per_s = 0.15);
    let frames = plan.run(0, &mut |_| {}).unwrap().frames;
    let changes = frames
        .windows(2)
        .map(|pair| largest_change_rad(&pair[1].equilibrium_angle_rad, &pair[0].equilibrium_angle_rad));
    let largest = changes.fold(0.0, f64::max);
    assert!((largest - 0.15 * 0.04).abs() < 1e-9, "{largest}");
}

/// Tests that at the end of its way an arm that something holds is pushed on by an offset that grows by the missing angle
/// times half the rate at which the joints' damping slows their slowest motion.
#[test]
fn damping_says_how_fast_the_arm_pushes_on() {
    let arm = Arm::cody().unwrap();
    let mut own = Mapped::new(Preset::cody_2013(), &arm);
    let q = arm.start_posture_rad();
    let poses = arm.forward_kinematics(&q);
    let end_effector = arm.end_effector_pose(&poses);
    let goal = end_effector.position + DVec3::new(0.0, 0.0, 0.03);
    let missing_rad = difference(&arm.posture_at(goal, &q).unwrap(), &q);
    let mut phi = q.clone();
    let mut offsets_rad = Vec::new();
    for _ in 0..30 {
        phi = own
            .control(&ControllerInput {
                joint_angle_rad: q.clone(),
                joint_velocity_rad_per_s: vec![0.0; 7],
                equilibrium_angle_rad: phi,
                end_effector_pose_world: end_effector,
                end_effector_jacobian: Matrix3xX::zeros(7),
                goal_position_world: goal,
                contacts: Vec::new(),
            })
            .equilibrium_angle_rad;
        offsets_rad.push(difference(&phi, &q));
    }
    // The rate makes D − rate M singular.
    let damping = nalgebra::DVector::from_iterator(7, arm.joints.iter().map(|joint| joint.damping_nm_s_per_rad));
    let is_slower =
        |rate: f64| (nalgebra::DMatrix::from_diagonal(&damping) - arm.mass_matrix(&poses) * rate).cholesky().is_some();
    let (mut slow, mut fast) = (0.0, 1e3);
    for _ in 0..60 {
        let middle = (slow + fast) / 2.0;
        if is_slower(middle) { slow = middle } else { fast = middle }
    }
    let joint = (0..7).max_by(|a, b| missing_rad[*a].abs().total_cmp(&missing_rad[*b].abs())).unwrap();
    // The arm is at the end of its way after half a second.
    for pair in offsets_rad[13..].windows(2) {
        let growth_rad = pair[1][joint] - pair[0][joint];
        let expected_rad = 0.5 * slow * missing_rad[joint] / 25.0;
        assert!((growth_rad / expected_rad - 1.0).abs() < 1e-6, "{growth_rad} rad, {expected_rad} rad");
    }
}

/// Tests that the pursuit of a goal begins anew where the goal before was, if that was given up.
#[test]
fn the_same_goal_is_pursued_again() {
    let arm = Arm::cody().unwrap();
    let mut own = Mapped::new(Preset::cody_2013(), &arm);
    let q = arm.start_posture_rad();
    let end_effector = arm.end_effector_pose(&arm.forward_kinematics(&q));
    let input = ControllerInput {
        joint_angle_rad: q.clone(),
        joint_velocity_rad_per_s: vec![0.0; 7],
        equilibrium_angle_rad: q,
        end_effector_pose_world: end_effector,
        end_effector_jacobian: Matrix3xX::zeros(7),
        goal_position_world: end_effector.position + DVec3::Z * 0.03,
        contacts: Vec::new(),
    };
    let given_up = [0, 0, 1].map(|goal_index| {
        own.observe(&Frame { goal_index, ..Frame::blank(7) });
        let intent = own.control(&input).intent;
        own.pursuit.as_mut().unwrap().given_up = Some("stopped".into());
        matches!(intent, Intent::GivenUp(_))
    });
    assert_eq!(given_up, [false, true, false]);
}

/// Tests that a force on a part without skin is found where it acts, from the torques of the joints alone, and that
/// torques that accelerate the arm are none.
#[test]
fn bare_contacts_are_found_from_torques() {
    let arm = Arm::cody().unwrap();
    let bare = BareSurface::new(&arm, &ArmShapes::new(&arm, f64::NEG_INFINITY));
    let q = arm.start_posture_rad();
    let poses = arm.forward_kinematics(&q);
    // 8 N from the right on the wrist's boot.
    let wrist = arm.link_index("wrist").unwrap();
    let (point, force) = (poses[wrist].position + DVec3::NEG_Y * 0.0475, DVec3::Y * 8.0);
    let torque = arm.position_jacobian(&poses, wrist, point).tr_mul(&nalgebra::Vector3::from(force.to_array()));
    // The springs balance it.
    let joints = arm.joints.iter().zip(&q).zip(torque.iter());
    let phi: Vec<f64> = joints.map(|((joint, q), torque)| q - torque / joint.stiffness_nm_per_rad).collect();
    let input = ControllerInput {
        joint_angle_rad: q.clone(),
        joint_velocity_rad_per_s: vec![0.0; 7],
        equilibrium_angle_rad: phi,
        end_effector_pose_world: Pose::new(DVec3::ZERO, DQuat::IDENTITY),
        end_effector_jacobian: Matrix3xX::zeros(7),
        goal_position_world: DVec3::ZERO,
        contacts: Vec::new(),
    };
    let still = nalgebra::DVector::zeros(7);
    let (force_n, touch, _) = bare.touch(&arm, &poses, &input, &still, 0.0).unwrap();
    assert!((force_n - 8.0).abs() < 1.0, "{force_n} N");
    assert!(touch.position_world.distance(point) < 0.05, "{}", touch.position_world.distance(point));
    assert!(touch.outward_normal_world.dot(DVec3::NEG_Y) > 0.8);
    // A spring whose equilibrium angle is far away pulls with its limit, and no more: the equation is that of a contact of this size.
    let limit_nm = arm.joints[0].torque_limit_nm;
    let beyond = |share: f64| {
        let phi = [q[0] + share * limit_nm / arm.joints[0].stiffness_nm_per_rad, q[1], q[2], q[3], q[4], q[5], q[6]];
        bare.touch(&arm, &poses, &ControllerInput { equilibrium_angle_rad: phi.to_vec(), ..input.clone() }, &still, 0.0)
    };
    let forces_n = [1.0, 3.0].map(|share| beyond(share).map(|(force_n, ..)| force_n));
    assert!(forces_n[0].is_some_and(|force_n| force_n > 10.0), "{forces_n:?}");
    assert_eq!(forces_n[0], forces_n[1]);
    // An arm that these torques accelerate touches nothing.
    let acceleration = arm.mass_matrix(&poses).cholesky().unwrap().solve(&-torque);
    assert!(bare.touch(&arm, &poses, &input, &acceleration, 0.0).is_none());
    // Without a contact there is none.
    let rest = ControllerInput { equilibrium_angle_rad: q, ..input };
    assert!(bare.touch(&arm, &poses, &rest, &still, 0.0).is_none());
}

/// Pushes springs of these stiffnesses, N/m, one after the other along y at 0.05 m/s for a second, all with this verdict.
/// Returns after each whether verdicts are believed, and how hard it may be pressed, N.
fn pushed(category: (&str, f64), springs_n_per_m: &[f64]) -> Vec<(bool, f64)> {
    let mut trust = Trust::default();
    let mut push = |number: usize, stiffness_n_per_m: f64| {
        let mut limit_n = f64::NAN;
        for step in 1..=25 {
            let time_s = 10.0 * number as f64 + 0.04 * f64::from(step);
            let pushed_m = 0.002 * f64::from(step);
            let force_n = 0.35 + stiffness_n_per_m * pushed_m;
            let position_world = DVec3::Y * pushed_m;
            // A controller that holds the limit overshoots it.
            if force_n < 2.0 * category.1 {
                let felt = TaxelContact { position_world, ..contact(force_n, DVec3::NEG_Y, Some(category)) };
                trust.take_in(&judged(std::slice::from_ref(&felt), 3.0, false), 3.0, time_s);
                let contacts = [felt];
                let mut judged = judged(&contacts, 3.0, false);
                trust.allow_what_gave_way(&mut judged, 3.0);
                limit_n = judged[0].limit_n;
            }
        }
        (!trust.is_lost, limit_n)
    };
    springs_n_per_m.iter().enumerate().map(|(number, stiffness)| push(number, *stiffness)).collect()
}

/// Tests that verdicts that springs confirm are believed, and that wrong ones are not as soon as they are in the majority.
#[test]
fn what_is_felt_decides_whether_verdicts_are_believed() {
    let believed = |category, springs: &[f64]| pushed(category, springs).iter().map(|own| own.0).collect::<Vec<_>>();
    assert_eq!(believed(("leaf", 6.0), &[10.0, 40.0]), [true, true]);
    assert_eq!(believed(("trunk", 1.5), &[150.0, 300.0]), [true, true]);
    assert_eq!(believed(("trunk", 1.5), &[10.0]), [false]);
    assert_eq!(believed(("leaf", 6.0), &[10.0, 400.0, 400.0, 10.0]), [true, true, false, false]);
}

/// Tests that what has given way may be pressed as hard as leaves, whatever it is called, and that what holds may not.
#[test]
fn what_gave_way_may_be_pressed() {
    let limits_n = |category, springs: &[f64]| pushed(category, springs).iter().map(|own| own.1).collect::<Vec<_>>();
    assert_eq!(limits_n(("trunk", 1.5), &[400.0, 400.0, 10.0, 400.0]), [1.5, 1.5, 6.0, 1.5]);
    assert_eq!(limits_n(("leaf", 7.0), &[10.0]), [7.0]);
}

/// Tests that the recorded map has obstacles beside trunks that were touched, and none before the first touch.
#[test]
fn the_map_is_recorded() {
    let reaches: Vec<_> = (0..3).map(|index| plan(5).run(index, &mut |_| {}).unwrap()).collect();
    assert!(reaches.iter().any(|reach| !reach.map.is_empty()));
    for reach in &reaches {
        assert!(reach.map.is_sorted_by_key(|own| own.first_frame));
        let touched = reach.contacts.iter().map(|contact| contact.first_frame).min().unwrap_or(u32::MAX);
        for own in &reach.map {
            assert!(own.first_frame > touched && own.last_frame < reach.frames.len() as u32, "{own:?}");
            let distances =
                reach.objects.iter().map(|object| object.position_world.truncate().distance(own.top_world.truncate()));
            assert!(distances.fold(f64::INFINITY, f64::min) < 0.08, "{own:?}");
        }
    }
}
