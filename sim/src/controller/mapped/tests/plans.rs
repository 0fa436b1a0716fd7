//! Tests of free postures and plans.

use glam::DVec3;

use crate::arm::Arm;
use crate::controller::mapped::arm_shapes::{ArmShapes, between, largest_change_rad};
use crate::controller::mapped::planner::{BUDGET, ForbiddenPostures, NoWay, Planner, length_rad};
use crate::geometry::Capsule;
use crate::seed::stream;
fn upright(x: f64, y: f64, radius_m: f64) -> Capsule {
    Capsule { start: DVec3::new(x, y, -1.0), end: DVec3::new(x, y, 0.0), radius_m }
}

fn planner<'a>(arm: &'a Arm, shapes: &'a ArmShapes, obstacles: &'a [Capsule]) -> Planner<'a> {
    Planner::new(arm, shapes, obstacles, BUDGET)
}

/// Postures of Cody within its limits.
fn postures(arm: &Arm, count: usize) -> Vec<Vec<f64>> {
    let mut random = stream(1, "mapped", 0, "test");
    let draw = |joint: &crate::arm::Joint, share: f64| {
        let [low, high] = joint.controller_limits_rad;
        low + (high - low) * share
    };
    let posture = |_| arm.joints.iter().map(|joint| draw(joint, rand::RngExt::random::<f64>(&mut random))).collect();
    (0..count).map(posture).collect()
}

/// The smallest distance of the arm's true shapes from an obstacle by parry, with no shape left out by its capsule.
fn distance_by_parry_m(arm: &Arm, posture_rad: &[f64], obstacle: &Capsule) -> f64 {
    let poses = arm.forward_kinematics(posture_rad);
    arm.placed_shapes(&poses).map(|shape| shape.distance(obstacle)).fold(f64::INFINITY, f64::min)
}

/// Tests that the arm counts as free exactly where parry's distances of all its shapes are larger than the margin.
#[test]
fn free_postures_are_those_that_parry_finds_free() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let obstacles = [upright(0.45, -0.2, 0.02), upright(0.3, 0.0, 0.015)];
    let mut counts = [0, 0];
    for posture in postures(&arm, 400) {
        let poses = arm.forward_kinematics(&posture);
        let distance_m =
            obstacles.iter().map(|own| distance_by_parry_m(&arm, &posture, own)).fold(f64::INFINITY, f64::min);
        let is_free = shapes.free_share(&poses, &[0.0; 7], &obstacles, 0.005).is_some();
        assert_eq!(is_free, distance_m > 0.005, "{distance_m}");
        counts[usize::from(is_free)] += 1;
    }
    assert!(counts[0] > 20 && counts[1] > 20, "{counts:?}");
}

/// Tests that an arm that touches itself is not free, and one that does not is: the Panda's shapes of links that are more than
/// two joints apart, by parry. Also that on the share of a motion that is said to be free they do not touch.
#[test]
fn an_arm_that_touches_itself_is_not_free() {
    let arm = Arm::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/arms/panda/panda.toml")).unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let touches = |posture_rad: &[f64]| {
        let poses = arm.forward_kinematics(posture_rad);
        let of = |link: usize| arm.links[link].colliders.iter().map(|own| own.placed(&poses[link])).collect::<Vec<_>>();
        let pairs = (0..arm.links.len()).flat_map(|near| (near + 3..arm.links.len()).map(move |far| (near, far)));
        pairs.into_iter().any(|(near, far)| {
            let far = of(far);
            of(near).iter().any(|one| far.iter().any(|other| one.distance_to(other.shape.as_ref(), &other.pose) <= 0.0))
        })
    };
    let near = DVec3::new(0.0, 0.0, 0.2);
    let upright = arm.forward_kinematics(&[0.0; 7]);
    assert!(shapes.is_near_itself(&upright, 7, near) && !shapes.is_near_itself(&upright, 7, near + DVec3::X));
    assert!(!shapes.is_near_itself(&upright, 3, near), "links that pass through each other");
    let (postures, mut count) = (postures(&arm, 8000), 0);
    for pair in postures.windows(2) {
        let change: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(from, to)| to - from).collect();
        let share = shapes.free_share(&arm.forward_kinematics(&pair[0]), &change, &[], 0.0);
        assert_eq!(share.is_none(), touches(&pair[0]));
        count += usize::from(share.is_none());
        let Some(share) = share else { continue };
        assert!(!touches(&between(&pair[0], &pair[1], 0.999 * share.min(1.0))));
    }
    assert!(count > 10, "{count}");
}

/// Tests that within the share of a motion that is said to be free no shape comes closer to an obstacle than the margin.
#[test]
fn the_free_share_of_a_motion_is_free() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let obstacles = [upright(0.45, -0.2, 0.02)];
    let postures = postures(&arm, 120);
    for pair in postures.windows(2) {
        let change: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(from, to)| to - from).collect();
        let poses = arm.forward_kinematics(&pair[0]);
        let Some(share) = shapes.free_share(&poses, &change, &obstacles, 0.005) else { continue };
        let posture = between(&pair[0], &pair[1], share.min(1.0));
        assert!(distance_by_parry_m(&arm, &posture, &obstacles[0]) > 0.005 - 1e-6);
    }
}

/// Tests that every planned path starts at the arm, ends with the end effector at the goal, and keeps clear of all
/// obstacles where it is looked at far more densely than the planner does.
#[test]
fn planned_paths_are_free_and_arrive() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, -0.5);
    let start = arm.start_posture_rad();
    let mut corners = 0;
    for (number, (x, y)) in [(0.6, -0.3), (0.55, 0.0), (0.65, -0.15), (0.5, 0.15)].into_iter().enumerate() {
        let goal = DVec3::new(x, y, -0.25);
        let obstacles = [upright(0.42, -0.35, 0.02), upright(0.42, -0.05, 0.02), upright(0.5, 0.1, 0.02)];
        let mut random = stream(2, "mapped", number as u64, "test");
        let path = planner(&arm, &shapes, &obstacles).plan(&start, goal, &mut random).unwrap();
        assert_eq!(path[0], start);
        let end = arm.end_effector_pose(&arm.forward_kinematics(&path[path.len() - 1]));
        assert!(end.position.distance(goal) < 2e-3);
        for pair in path.windows(2) {
            for step in 0..=200 {
                let posture = between(&pair[0], &pair[1], f64::from(step) / 200.0);
                for obstacle in &obstacles {
                    // Between two postures that the planner looks at the arm moves by at most 5 mm.
                    assert!(distance_by_parry_m(&arm, &posture, obstacle) > 0.002);
                }
            }
        }
        corners = corners.max(path.len());
    }
    assert!(corners > 2, "no way led round anything");
}

/// Tests that where nothing is in the way, plans are in the mean at most 3 % longer than straight ways to the best of the postures
/// that inverse kinematics finds from 400 others.
#[test]
fn free_plans_are_nearly_the_shortest() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let start = arm.start_posture_rad();
    let (others, mut sums) = (postures(&arm, 400), [0.0; 2]);
    for (number, (x, y)) in [(0.6, -0.3), (0.55, 0.0), (0.65, -0.15), (0.5, 0.15), (0.45, -0.4)].into_iter().enumerate()
    {
        let goal = DVec3::new(x, y, -0.25);
        let path =
            planner(&arm, &shapes, &[]).plan(&start, goal, &mut stream(5, "mapped", number as u64, "test")).unwrap();
        let found = others.iter().filter_map(|from| arm.posture_at(goal, &between(&start, from, 0.3)));
        sums[0] += length_rad(&path);
        sums[1] += found.map(|end| largest_change_rad(&start, &end)).fold(f64::INFINITY, f64::min);
    }
    assert!(sums[0] < 1.03 * sums[1], "{sums:?}");
}

/// Tests that plans round obstacles are in the mean at least a tenth shorter than the first ways that are found.
#[test]
fn plans_are_shorter_than_first_ways() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, -0.5);
    let start = arm.start_posture_rad();
    let obstacles = [upright(0.42, -0.35, 0.02), upright(0.42, -0.05, 0.02), upright(0.5, 0.1, 0.02)];
    let mut sums = [0.0; 2];
    for number in 0..8 {
        let goal = DVec3::new(0.6, -0.3 + 0.05 * number as f64, -0.25);
        let mut random = stream(6, "mapped", number, "test");
        sums[0] += length_rad(&planner(&arm, &shapes, &obstacles).plan(&start, goal, &mut random).unwrap());
        sums[1] += length_rad(&planner(&arm, &shapes, &obstacles).any_path(&start, goal, &mut random).unwrap());
    }
    assert!(sums[0] < 0.9 * sums[1], "{sums:?}");
}

/// Tests that the reason is right where there is no way: beyond the arm's length, inside a trunk, and from inside one.
#[test]
fn reasons_are_told_apart() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let start = arm.start_posture_rad();
    let plan = |obstacles: &[Capsule], goal: DVec3| {
        planner(&arm, &shapes, obstacles).plan(&start, goal, &mut stream(3, "mapped", 0, "test")).unwrap_err()
    };
    assert_eq!(plan(&[], DVec3::new(1.5, 0.0, 0.0)), NoWay::OutOfReach);
    assert_eq!(plan(&[upright(0.6, -0.2, 0.1)], DVec3::new(0.6, -0.2, -0.3)), NoWay::NoFreePosture);
    let hand = arm.end_effector_pose(&arm.forward_kinematics(&start)).position;
    assert_eq!(plan(&[upright(hand.x, hand.y, 0.05)], DVec3::new(0.6, -0.2, -0.3)), NoWay::Wedged);
}

/// Tests that the same plan is found again, and that it stays out of forbidden postures.
#[test]
fn plans_repeat_and_avoid_what_is_forbidden() {
    let arm = Arm::cody().unwrap();
    let shapes = ArmShapes::new(&arm, f64::NEG_INFINITY);
    let start = arm.start_posture_rad();
    let goal = DVec3::new(0.6, -0.2, -0.25);
    let plan = |forbidden: &[ForbiddenPostures]| {
        let mut planner = Planner { forbidden, ..planner(&arm, &shapes, &[]) };
        planner.plan(&start, goal, &mut stream(4, "mapped", 0, "test")).unwrap()
    };
    let straight = plan(&[]);
    assert_eq!((straight.len(), plan(&[])), (2, straight.clone()));
    let middle = between(&straight[0], &straight[1], 0.5);
    let ball = ForbiddenPostures { center_rad: middle.clone(), radius_rad: 0.2 };
    for pair in plan(std::slice::from_ref(&ball)).windows(2) {
        for step in 0..=100 {
            let posture = between(&pair[0], &pair[1], f64::from(step) / 100.0);
            // Postures are looked at a tenth of a radian apart, so a path cuts at most half as deep into the ball.
            assert!(largest_change_rad(&posture, &middle) > 0.15);
        }
    }
}
