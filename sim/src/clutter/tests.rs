//! Placement, goals and their errors, on made-up scenes.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::path::Path;

use glam::DVec3;
use parry3d::shape::SharedShape;
use underbrush_recording::{InputError, Pose};

use super::goals::passes_through;
use super::{Clutter, PlacedObject};
use crate::arm::{Arm, ArmAtStart, SkinAlongArm};
use crate::geometry::{Capsule, PlacedShape};
use crate::{ReachPlan, Scene};

/// Cody's arm without the shapes that would keep objects away from its start, and with skin 5 to 20 cm behind the end
/// effector.
fn arm() -> ArmAtStart {
    ArmAtStart {
        links: Vec::new(),
        skin: SkinAlongArm { behind_end_effector_m: [0.05, 0.125, 0.20], radius_m: 0.05 },
        ..ArmAtStart::of(&Arm::cody().unwrap())
    }
}

fn scene(name: &str, text: &str) -> Scene {
    let text = format!("summary = \"A test\"\n{text}");
    Scene::parse(name, text).unwrap()
}

fn draw(text: &str, arm: &ArmAtStart) -> Result<Clutter, InputError> {
    Clutter::draw(&scene("test.toml", text), arm, 0, 0)
}

/// One goal at (x, −0.1, −0.25) and one trunk of 4 cm at (0.5, −0.1).
fn goal_beside_a_trunk(x_m: f64) -> String {
    format!(
        "goals = {{ count = 1, x_m = {x_m}, y_m = -0.1, z_m = -0.25 }}\n\
         [[objects.trunk]]\ncount = 1\ndiameter_m = 0.04\nheight_m = 0.6\nplace = {{ x_m = 0.5, y_m = -0.1 }}\n"
    )
}

/// Tests that no goal lies where the hand would be inside the clearance of a trunk, and that the error counts the places
/// by their reasons.
#[test]
fn goals_leave_the_hand_room() {
    let clutter = draw(&goal_beside_a_trunk(0.6), &arm()).unwrap();
    assert_eq!(clutter.goals, [DVec3::new(0.6, -0.1, -0.25)]);
    // 3.5 cm from the axis: 1.5 cm from the surface, within the 2 cm that every link keeps.
    let error = draw(&goal_beside_a_trunk(0.535), &arm()).unwrap_err().to_string();
    assert!(error.contains("no goal number 1 in 100 places"), "{error}");
    assert!(error.contains("at 100 every posture found is too close to an obstacle"), "{error}");
}

/// Tests that a goal brings the skin to a plant: with the trunk 8.1 cm behind the end effector, skin that ends before the
/// trunk or begins behind it by more than the skin's radius is not enough.
#[test]
fn goals_bring_the_skin_to_a_plant() {
    let goal = DVec3::X * 0.581;
    let trunk = Capsule { start: DVec3::new(0.5, 0.0, -0.3), end: DVec3::new(0.5, 0.0, 0.3), radius_m: 0.02 };
    let passes = |behind_end_effector_m, radius_m| {
        let arm =
            ArmAtStart { shoulder_world: DVec3::ZERO, skin: SkinAlongArm { behind_end_effector_m, radius_m }, ..arm() };
        passes_through(&arm, &[trunk], goal, goal)
    };
    assert!(passes([0.05, 0.06, 0.07], 0.01));
    // The trunk's near side is 6.1 cm behind the end effector, its far side 10.1 cm.
    assert!(!passes([0.02, 0.03, 0.05], 0.01));
    assert!(passes([0.02, 0.03, 0.05], 0.012));
    assert!(!passes([0.12, 0.13, 0.14], 0.018));
    assert!(passes([0.12, 0.13, 0.14], 0.020));
}

/// Tests that goals beyond the reach of the arm are refused, and that the error says how many were. Cody's upper arm begins
/// 0.217 m to the right of the first joint and reaches 0.827 m.
#[test]
fn goals_are_within_reach() {
    let goal = |x_m: f64| format!("goals = {{ count = 2, x_m = {x_m}, y_m = -0.217, z_m = 0.0 }}\n");
    assert_eq!(draw(&goal(0.82), &arm()).unwrap().goals.len(), 2);
    let error = draw(&goal(0.83), &arm()).unwrap_err().to_string();
    assert!(error.contains("0 are farther than the arm is long, 100 are out of reach within the limits"), "{error}");
    // The offset of the shoulder counts as length: beyond 0.217 + 0.827 m no straight arm would reach.
    let error = draw(&goal(1.2), &arm()).unwrap_err().to_string();
    assert!(error.contains("100 are farther than the arm is long, 0 are out of reach"), "{error}");
}

/// Tests that a goal at which the hand would be in the table is counted as such.
#[test]
fn goals_keep_the_hand_above_the_table() {
    let error = draw("goals = { count = 1, x_m = 0.5, y_m = -0.3, z_m = -0.60 }\n", &arm()).unwrap_err().to_string();
    assert!(error.contains("at 100 every posture found is too close to the table"), "{error}");
}

/// Tests that drawn goals are nearer to Cody's upper arm than the bones from there to the end effector are long. Four to
/// ten of a hundred were not when the shoulder's offset counted as length.
#[test]
fn no_drawn_goal_is_out_of_reach() {
    let scene = Scene::parse("mixed.toml", crate::scene::shipped("mixed.toml").unwrap().into()).unwrap();
    let cody = Arm::cody().unwrap();
    let bones = cody.joints[2..].iter().map(|joint| joint.origin_parent.position.length());
    let length_m = bones.sum::<f64>() + cody.end_effector_pose_link.position.length();
    let upper_arm = cody.joints[1].origin_parent.position;
    let arm = ArmAtStart::of(&cody);
    for index in 0..30 {
        for goal in Clutter::draw(&scene, &arm, 5, index).unwrap().goals {
            let distance_m = goal.distance(upper_arm);
            // An arm that is 1 mm away has arrived.
            assert!(distance_m <= length_m + 1e-3, "reach {index}: {distance_m} m of {length_m} m");
        }
    }
}

/// Tests the clearance between objects and the arm's start at its limit: 2 cm from the true shape.
#[test]
fn objects_keep_their_distance_from_the_arm() {
    // A ball of 5 cm, 2 cm of room and 2 cm of trunk make 9 cm from the trunk's axis at x = 0.5.
    let ball_at = |x_m: f64| ArmAtStart {
        links: vec![PlacedShape {
            shape: SharedShape::ball(0.05),
            pose: Pose::from_position(DVec3::new(x_m, -0.1, -0.3)),
        }],
        ..arm()
    };
    assert!(draw(&goal_beside_a_trunk(0.6), &ball_at(0.409)).is_ok());
    let error = draw(&goal_beside_a_trunk(0.6), &ball_at(0.411)).unwrap_err();
    let text = error.to_string();
    assert!(error.field.contains("objects.trunk") && error.field.contains("count"), "{error:?}");
    assert!(text.contains("0 were placed") && text.contains("1000 were too close to the arm's start"), "{text}");
}

/// Two groups of one object each at the same place, the first a foam block.
fn on_a_block(other: &str) -> String {
    format!(
        "goals = {{ count = 1, x_m = 0.62, y_m = -0.1, z_m = {{ uniform = [-0.38, -0.16] }} }}\n\
         [[objects.foam_block]]\ncount = 1\nplace = {{ x_m = 0.5, y_m = -0.1, yaw_deg = 0 }}\n\
         [[objects.{other}]]\ncount = 1\nplace = {{ x_m = 0.5, y_m = -0.1 }}\n"
    )
}

/// Tests which objects may share ground: leaves stand in foam, trunks go through it, and a roll stands on the bare
/// table.
#[test]
fn leaves_and_trunks_stand_in_foam() {
    let arm = arm();
    for kind in ["leaf", "trunk"] {
        let clutter = draw(&on_a_block(kind), &arm).unwrap_or_else(|error| panic!("{kind}: {error}"));
        let kinds: Vec<_> = clutter.objects.iter().map(|placed| placed.object.kind()).collect();
        assert!(kinds.contains(&kind) && kinds.contains(&"foam_block"), "{kinds:?}");
        let block = clutter.objects.iter().find(|placed| placed.object.kind() == "foam_block");
        let top_m = block.unwrap().foot_world.z + block.unwrap().object.size().1;
        let plant = clutter.objects.iter().find(|placed| placed.object.kind() == kind);
        let foot_m = plant.unwrap().foot_world.z;
        assert_eq!(foot_m, if kind == "leaf" { top_m } else { -0.58 });
    }
    let error = draw(&on_a_block("foam_roll"), &arm).unwrap_err().to_string();
    assert!(error.contains("1000 overlapped another object"), "{error}");
}

/// Tests the errors for a group without room and for leaves without foam, each with its numbers.
#[test]
fn groups_without_room_are_refused() {
    let crowd = "[workspace]\ntable_height_m = -0.3\n[[objects.trunk]]\ncount = 40\ndiameter_m = 0.04\nheight_m = 0.6\n\
                 place = { x_m = { uniform = [0.5, 0.56] }, y_m = { uniform = [0.0, 0.06] } }\n";
    let error = draw(crowd, &arm()).unwrap_err();
    let placed = error.allowed.split(" were placed").next().and_then(|before| before.split(' ').next_back());
    let placed: u32 = placed.unwrap().parse().unwrap();
    // Discs of 4 cm with their centres in 6 × 6 cm: one at least, and no more than the nine of a grid of 3 cm.
    assert!((1..=9).contains(&placed), "{error}");
    assert!(error.allowed.contains("1000 overlapped another object"), "{error}");
    let bare = "[[objects.leaf]]\ncount = 1\n";
    let error = draw(bare, &arm()).unwrap_err().to_string();
    assert!(error.contains("1000 had no foam to stand in"), "{error}");
}

/// Tests that bottles and free blocks are not placed beside the tables that a scene names, where they would fall, and that a trunk
/// may be there.
#[test]
fn what_would_fall_stands_on_a_table() {
    let beside = |group: &str| {
        let text = format!(
            "[goals]\npositions_m = [[0.5, -0.1, -0.25]]\n[[objects.table]]\ncount = 1\nlength_m = 0.5\nwidth_m = 0.5\n\
             place = {{ x_m = 0, y_m = 0 }}\n[[objects.{group}\ncount = 1\nplace = {{ x_m = 0.6, y_m = 0 }}\n"
        );
        draw(&text, &arm())
    };
    for group in ["water_bottle]]", "foam_block]]\nstands_free = 1"] {
        let error = beside(group).unwrap_err();
        assert!(error.allowed.contains("1000 were beside the table"), "{error}");
    }
    assert_eq!(beside("trunk]]").unwrap().objects.len(), 2);
}

/// Tests the random streams: seed, index of the reach, what the file says of the objects and the key `stream` each change
/// the clutter; the file's name, the sensor, the physics and the number of goals do not.
#[test]
fn streams_are_apart() {
    let arm = ArmAtStart::of(&Arm::cody().unwrap());
    let draw = |name: &str, text: &str, seed: u64, index: u64| {
        let clutter = Clutter::draw(&scene(name, text), &arm, seed, index).unwrap();
        (format!("{:?}", clutter.objects), clutter.goals)
    };
    let text = "goals = { count = 1 }\n[[objects.trunk]]\ncount = 5\n";
    let first = draw("a.toml", text, 1, 0);
    for same in ["", "sensor = { noise_n = 0.5 }\n", "physics = { step_s = 0.01 }\n", "controller = \"blind\"\n"] {
        assert_eq!(draw("b.toml", &format!("{same}{text}"), 1, 0), first, "{same}");
    }
    let named = format!("stream = \"own\"\n{text}");
    for other in [
        draw("a.toml", text, 2, 0),
        draw("a.toml", text, 1, 1),
        draw("a.toml", &format!("{text}height_m = 0.5\n"), 1, 0),
        draw("a.toml", &named, 1, 0),
    ] {
        assert_ne!(other.0, first.0);
        assert_ne!(other.1, first.1);
    }
    let more = draw("a.toml", &text.replace("{ count = 1 }", "{ count = 3 }"), 1, 0);
    assert_eq!((more.0, more.1[0], more.1.len()), (first.0, first.1[0], 3));
    // The same numbers, and other trunks in the same places.
    let with = |diameter_m: f64| {
        let text = format!("{named}diameter_m = {diameter_m}\n");
        let clutter = Clutter::draw(&scene("a.toml", &text), &arm, 1, 0).unwrap();
        let feet: Vec<DVec3> = clutter.objects.iter().map(|placed| placed.foot_world).collect();
        (feet, format!("{:?}", clutter.objects))
    };
    let (thin, thick) = (with(0.03), with(0.031));
    assert_eq!(thin.0, thick.0);
    assert_ne!(thin.1, thick.1);
}

/// Tests the properties of the arm on which goals depend. According to Cody's files, the rows of the forearm's skin are
/// 94.2 to 256.2 mm from the elbow axis, which is 278.53 mm from the wrist; the wrist is 270 mm behind the end
/// effector. The skin's radius is 46.04 mm.
#[test]
fn goals_know_the_arm_and_its_skin() {
    let cody = Arm::cody().unwrap();
    let close = |found: f64, expected: f64| (found - expected).abs() < 1e-5;
    let start = ArmAtStart::of(&cody);
    let SkinAlongArm { behind_end_effector_m, radius_m } = start.skin;
    let [first, middle, last] = behind_end_effector_m;
    assert!(close(first, 0.270 + 0.27853 - 0.2562), "{first}");
    assert!(close(last, 0.270 + 0.27853 - 0.0942), "{last}");
    assert!(close(middle, (first + last) / 2.0) && close(radius_m, 0.04604), "{middle} {radius_m}");

    // The same arm with the flipper's patch as the first: its skin ends at the end effector.
    let mut hand = cody.clone();
    hand.skin.layout.patches.swap(0, 1);
    hand.skin.surfaces.swap(0, 1);
    let [first, _, last] = ArmAtStart::of(&hand).skin.behind_end_effector_m;
    assert!(close(first, 0.0) && (0.13..0.25).contains(&last), "{first} {last}");

    // An arm that is twice as large in every length.
    let mut large = cody;
    for joint in &mut large.joints {
        joint.origin_parent.position *= 2.0;
    }
    large.end_effector_pose_link.position *= 2.0;
    for taxel in large.skin.layout.patches.iter_mut().flat_map(|patch| &mut patch.taxels) {
        taxel.position_link *= 2.0;
    }
    let SkinAlongArm { behind_end_effector_m: doubled, radius_m: wide } = ArmAtStart::of(&large).skin;
    let doubles = doubled.iter().zip(behind_end_effector_m).all(|(large, small)| close(*large, 2.0 * small));
    assert!(doubles && close(wide, 2.0 * radius_m), "{doubled:?} {wide}");
}

/// Tests that places that are drawn from a normal distribution are within the limits of places.
#[test]
fn normal_places_are_within_the_limits() {
    let far = "[[objects.trunk]]\ncount = 20\nplace = { x_m = { normal = [4.5, 3.0] } }\n";
    let text = goal_beside_a_trunk(0.7) + far;
    for index in 0..5 {
        let clutter = Clutter::draw(&scene("test.toml", &text), &arm(), 0, index).unwrap();
        assert_eq!(clutter.objects.len(), 21);
        for placed in &clutter.objects {
            assert!(placed.foot_world.x.abs() <= 5.0, "{}", placed.foot_world);
        }
    }
}

/// Tests that a draw written as a scene file gives the same objects and goals, for each scene that ships.
#[test]
fn an_arranged_scene_is_the_draw() {
    for (name, text) in crate::scene::shipped_by_name() {
        let plan = ReachPlan::new(Scene::parse(format!("{name}.toml"), text.into()).unwrap(), None, 5).unwrap();
        let drawn = plan.draw(2).unwrap();
        let arranged = Scene::parse("arranged.toml", drawn.arranged(&plan.scene, "arranged.toml".as_ref())).unwrap();
        let again = ReachPlan::new(arranged, None, 6).unwrap().draw(0).unwrap();
        let all = |clutter: &Clutter| -> Vec<_> {
            let one = |placed: &PlacedObject| {
                (placed.record(&clutter.materials), placed.yaw_rad, placed.object.structure(9.81))
            };
            clutter.objects.iter().map(one).collect()
        };
        assert_eq!(all(&again), all(&drawn), "{name}");
        assert_eq!(again.goals, drawn.goals, "{name}");
    }
}

/// Tests that a draw written as a scene file names a relative arm from the folder of that file, and an absolute one as it is.
#[test]
fn an_arranged_scene_finds_its_arm() {
    let arms = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/arms");
    let scene = Scene::load(arms.join("panda/foliage.toml")).unwrap();
    let arm = |scene: &Scene, place: &str| {
        let text = Clutter::default().arranged(scene, &arms.join(place));
        toml::from_str::<toml::Table>(&text).unwrap()["arm"].as_str().unwrap().to_owned()
    };
    assert_eq!(arm(&scene, "panda/new.toml"), "panda.toml");
    assert_eq!(arm(&scene, "new.toml"), "panda/panda.toml");
    assert_eq!(arm(&scene, "../guides/new.toml"), "../arms/panda/panda.toml");
    let absolute = std::path::absolute("panda.toml").unwrap().display().to_string();
    let text = scene.text.replace("\"panda.toml\"", &format!("{absolute:?}"));
    assert_eq!(arm(&Scene::parse("foliage.toml", text).unwrap(), "new.toml"), absolute);
}
