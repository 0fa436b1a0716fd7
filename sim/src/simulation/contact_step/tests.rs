//! Tests that no contact is lost, and that contacts at edges push in the right direction.

use glam::{DQuat, DVec3, EulerRot};
use underbrush_recording::{BodyPart, BodyShape, Pose};

use crate::contact::surface::Surface;
use crate::object::leaf::Leaf;
use crate::physics::PhysicsOptions;
use crate::simulation::test_rig::{FreeBody, Rig};

fn rig() -> Rig {
    Rig::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 })
}

fn part(shape: BodyShape) -> BodyPart {
    BodyPart { shape, pose_body: Pose::IDENTITY }
}

/// Tests that a plate of 4 mm carries a ball of 1 g that is pressed against it with 5 N. Free of contacts for a step of
/// 5 ms, the ball would be 12 cm beyond the plate, and the contact was lost when it was judged there.
#[test]
fn a_light_body_under_load_stays_on_a_thin_plate() {
    let mut rig = rig();
    let plate = BodyShape::Box { size_m: DVec3::new(0.2, 0.2, 0.004) };
    rig.add_fixed(&part(plate), Surface::hard(0.3), &Pose::from_position(DVec3::Z * -0.002)).unwrap();
    let ball = rig
        .add_free(&FreeBody {
            part: part(BodyShape::Sphere { radius_m: 0.005 }),
            mass_kg: 1e-3,
            surface: Surface::hard(0.3),
            pose_world: Pose::from_position(DVec3::Z * 0.005),
            velocity_world: DVec3::ZERO,
            may_rotate: false,
        })
        .unwrap();
    for _ in 0..100 {
        rig.push(ball, DVec3::Z * -5.0, rig.center_of_mass_world(ball), DVec3::ZERO);
        rig.step();
    }
    assert!((rig.pressing_force_n(ball) - 5.0).abs() < 1e-4, "{} N", rig.pressing_force_n(ball));
    assert!(rig.pose_world(ball).position.z > 0.0, "{}", rig.pose_world(ball).position);
}

/// Tests that the corners of a box that lie 2 to 6 mm inside the rim of a cylinder press on it, however the box is turned.
#[test]
fn corners_and_edges_on_a_rim_press() {
    for case in 0..200 {
        // Golden ratios spread the cases evenly.
        let spread = |step: f64, low: f64, high: f64| low + (high - low) * (f64::from(case) * step).fract();
        let mut rig = rig();
        let forearm = BodyShape::Cylinder { radius_m: 0.046, length_m: 0.237 };
        let skin = Surface { compliance_m3_per_n: 1.0 / 3e7, thickness_m: None, loss_time_s: 0.002, friction: 0.3 };
        rig.add_fixed(&part(forearm), skin, &Pose::IDENTITY).unwrap();
        // A piece of a leaf near the rim, turned at random, 2 to 6 mm inside both the mantle and the end.
        let half = DVec3::new(0.001, 0.0186, 0.0099);
        let turn = DQuat::from_euler(
            EulerRot::XYZ,
            spread(0.618_034, 0.0, 3.0),
            spread(0.754_878, 0.0, 3.0),
            spread(0.819_173, 0.0, 3.0),
        );
        let inside_m = spread(0.569_840, 0.002, 0.006);
        let rim = DVec3::new(0.046 - inside_m, 0.0, 0.1185 - inside_m);
        // Its lowest corner towards the axis and the middle of the cylinder.
        let inward = DVec3::new(-1.0, 0.0, -1.0);
        let corner = half * (turn.inverse() * inward).signum();
        let body = FreeBody {
            part: part(BodyShape::Box { size_m: 2.0 * half }),
            mass_kg: 1e-3,
            surface: Surface::hard(0.3),
            pose_world: Pose::new(rim - turn * corner, turn),
            velocity_world: DVec3::ZERO,
            may_rotate: true,
        };
        let piece = rig.add_free(&body).unwrap();
        rig.step();
        assert!(rig.pressing_force_n(piece) > 0.0, "case {case}");
    }
}

/// Tests that plates of 1 mm that fly at others, crosswise and up to 15 mm in a step, stay on their side. Before their sides
/// were remembered, 206 of 800 such plates passed through (0.2 to 3 m/s).
#[test]
fn thin_plates_do_not_pass_through_each_other() {
    let mut passed = 0;
    for speed_m_per_s in [0.2, 0.5, 0.7, 1.0, 2.0, 3.0] {
        for case in 0..40 {
            let mut rig = rig();
            let plate = |x: f64, speed_m_per_s: f64, turn: f64| FreeBody {
                part: part(BodyShape::Box { size_m: DVec3::new(0.001, 0.03, 0.3) }),
                mass_kg: 0.005,
                surface: Surface::hard(0.3),
                pose_world: Pose::new(DVec3::X * x, DQuat::from_rotation_x(turn)),
                velocity_world: DVec3::X * speed_m_per_s,
                may_rotate: true,
            };
            let case = f64::from(case);
            let still = rig.add_free(&plate(0.0, 0.0, 0.0)).unwrap();
            let moving = rig.add_free(&plate(-0.05 - 0.0003 * case, speed_m_per_s, 0.3 + 0.02 * case)).unwrap();
            rig.step_times((0.2 / speed_m_per_s / 0.005) as u32);
            passed += u32::from(rig.pose_world(moving).position.x > rig.pose_world(still).position.x);
        }
    }
    assert!(passed <= 2, "{passed} of 240");
}

/// Tests that a leaf that is bent back and let go does not swing through the one in front of it. Its tip moves 30 mm in a
/// step, and the pair was not looked at before it was through.
#[test]
fn a_leaf_that_is_let_go_does_not_swing_through_another() {
    let leaf = Leaf {
        height_m: 0.3,
        width_m: 0.04,
        flexural_rigidity_n_m2: 0.02,
        torsion_over_bending: 1.48,
        mass_per_area_kg_per_m2: 0.7,
        loss_factor: 0.1,
        yield_moment_nm: None,
        root_stiffness_nm_per_rad: None,
        grip: None,
        segments: 4,
    };
    for (gap_m, load_n) in [(0.02, 0.3), (0.04, 1.0), (0.04, 2.0)] {
        for case in 0..4 {
            let mut rig = rig();
            let tip = |bodies: Vec<_>| *bodies.last().unwrap();
            let still = tip(rig.add_object_at(&leaf, DVec3::ZERO, 0.0));
            let foot_world = DVec3::new(-gap_m, 0.002 * f64::from(case), 0.0);
            let bent = tip(rig.add_object_at(&leaf, foot_world, 0.04 * f64::from(case)));
            for step in 0..200 {
                let force_n = load_n * (f64::from(step) / 140.0).min(1.0);
                rig.push(bent, DVec3::X * -force_n, rig.center_of_mass_world(bent), DVec3::ZERO);
                rig.step();
            }
            for _ in 0..120 {
                rig.step();
                let beside = rig.pose_world(still).inverse_transform_point(rig.center_of_mass_world(bent));
                let is_through = beside.x > 0.004 && beside.y.abs() < 0.015 && beside.z.abs() < 0.075;
                assert!(!is_through, "load {load_n} N, case {case}: {beside}");
            }
        }
    }
}

/// A frictionless body without loss that may turn, 0.5 kg.
fn smooth(shape: BodyShape, pose_world: Pose, velocity_world: DVec3) -> FreeBody {
    let surface = Surface { loss_time_s: 0.0, ..Surface::hard(0.0) };
    FreeBody { part: part(shape), mass_kg: 0.5, surface, pose_world, velocity_world, may_rotate: true }
}

/// Tests that a ball that is thrown beside the edge of a large box keeps its energy and does not begin to spin, as the force on
/// a smooth ball acts along its radius. With normals from the faces of the box it left with 1.5 to 2.4 times its energy.
#[test]
fn a_smooth_ball_leaves_an_edge_with_its_energy() {
    for beside_m in [0.005, 0.01] {
        let mut rig = Rig::new(PhysicsOptions { step_s: 1e-4, gravity_m_per_s2: 0.0 });
        let from = Pose::from_position(DVec3::new(-0.134, 0.1 + beside_m, 0.0));
        let ball = smooth(BodyShape::Sphere { radius_m: 0.03 }, from, DVec3::X * 0.2);
        rig.add_fixed(&part(BodyShape::Box { size_m: DVec3::splat(0.2) }), ball.surface, &Pose::IDENTITY).unwrap();
        let ball = rig.add_free(&ball).unwrap();
        rig.step_times(12_000);
        let turned = rig.pose_world(ball).orientation;
        rig.step();
        let spin_rad_per_s = (rig.pose_world(ball).orientation * turned.inverse()).to_scaled_axis().length() / 1e-4;
        let energy = rig.velocity_world(ball).length_squared() + 0.4 * (0.03 * spin_rad_per_s).powi(2);
        assert!(rig.velocity_world(ball).y > 0.05, "the edge was missed");
        assert!((energy / 0.04 - 1.0).abs() < 0.05, "{beside_m} m: {energy}");
    }
}

/// Tests that a cylinder that lies in the gap between two boxes of different height stays there. With normals from the faces of
/// the boxes it spun at 50 rad/s after a few seconds.
#[test]
fn a_cylinder_in_a_gap_stays_at_rest() {
    let mut rig = Rig::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 9.81 });
    let surface = Surface { loss_time_s: 0.002, ..Surface::hard(0.1) };
    let (gap_m, drop_m, radius_m) = (0.04, 0.01, 0.04);
    let cube = part(BodyShape::Box { size_m: DVec3::splat(0.2) });
    for (side, top_m) in [(-1.0, 0.0), (1.0, -drop_m)] {
        let place = DVec3::new(side * (0.1 + 0.5 * gap_m), 0.0, top_m - 0.1);
        rig.add_fixed(&cube, surface, &Pose::from_position(place)).unwrap();
    }
    // As far from one edge as from the other.
    let half = 0.5 * DVec3::new(gap_m, 0.0, -drop_m);
    let above = DVec3::new(drop_m, 0.0, gap_m).normalize() * (radius_m * radius_m - half.length_squared()).sqrt();
    let from = half - DVec3::X * 0.5 * gap_m + above;
    let lying = Pose::new(from, DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    let cylinder = BodyShape::Cylinder { radius_m, length_m: 0.15 };
    let body = rig.add_free(&FreeBody { surface, ..smooth(cylinder, lying, DVec3::ZERO) }).unwrap();
    rig.step_times(800);
    let pose = rig.pose_world(body);
    assert!(pose.position.distance(from) < 2e-3, "{}", pose.position - from);
    assert!(pose.orientation.angle_between(lying.orientation) < 0.05);
}
