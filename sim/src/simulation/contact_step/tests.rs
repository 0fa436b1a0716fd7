//! Tests that no contact is lost.

use glam::{DVec3, EulerRot};
use underbrush_recording::{BodyPart, BodyShape, Pose};

use crate::contact::surface::Surface;
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
        rig.load(ball, DVec3::Z * -5.0, rig.center_of_mass_world(ball), DVec3::ZERO);
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
        let turn = glam::DQuat::from_euler(
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
