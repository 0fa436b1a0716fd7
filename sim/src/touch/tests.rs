use super::*;
use crate::arm::Arm;
use crate::clutter::{Clutter, PlacedObject};
use crate::object::{Object, leaf::Leaf, trunk::Trunk};
use crate::physics::PhysicsOptions;
use crate::sensor::SensorOptions;
use nalgebra::DVector;

/// The arm pressed for `seconds` against one object at the left of its forearm by equilibrium angles that would
/// press with `force_n` (N) if nothing moved.
fn press(object: Box<dyn Object>, gap_m: f64, force_n: f64, seconds: f64) -> (Arm, World, Vec<f64>, Touch) {
    let arm = Arm::cody().unwrap();
    let posture = arm.start_posture_rad();
    let poses = arm.forward_kinematics(&posture);
    let forearm = arm.link_index("forearm").unwrap();
    let place = poses[forearm].transform_point(DVec3::new(0.0, 0.0, 0.10));
    let foot_world = (place + DVec3::Y * (0.04604 + gap_m)).with_z(place.z - 0.3);
    let objects = vec![PlacedObject {
        object,
        foot_world,
        yaw_rad: std::f64::consts::FRAC_PI_2,
    }];
    let clutter = Clutter {
        objects,
        goals: Vec::new(),
    };
    let options = PhysicsOptions {
        step_s: 0.005,
        substeps: 4,
        gravity_m_per_s2: 9.81,
    };
    let mut world = World::new(&arm, &posture, &clutter, options, false);
    let jacobian = arm.position_jacobian(&poses, forearm, place);
    let torque = jacobian.transpose() * nalgebra::Vector3::new(0.0, force_n, 0.0);
    let equilibrium: Vec<f64> = (0..posture.len())
        .map(|joint| posture[joint] + torque[joint] / arm.joints[joint].stiffness_nm_per_rad)
        .collect();
    for _ in 0..(seconds / underbrush_recording::FRAME_PERIOD_S) as usize {
        world.advance_frame(&arm, &equilibrium, &clutter);
        world.audit_frame(&arm, &Touch::default());
    }
    let options = SensorOptions {
        perfect: true,
        ..SensorOptions::default()
    };
    let mut sensor = Sensor::new(&options, &arm.skin, 0, "test", 0);
    let touch = feel(&world, &arm.skin.layout, &SkinPatch::of_arm(&arm), &mut sensor);
    (arm, world, equilibrium, touch)
}

fn largest_force_n(touch: &Touch) -> f64 {
    touch.largest_force().map_or(0.0, |force| force.force_n)
}

fn trunk() -> Box<dyn Object> {
    Box::new(Trunk {
        diameter_m: 0.03,
        height_m: 0.6,
    })
}

/// Pins that a taxel's object is the one that presses most in sum: two pieces of a leaf outdo a trunk that presses harder
/// than either, and of equals the first is named.
#[test]
fn a_taxel_names_the_object_that_presses_most_in_sum() {
    let mut load = Load::default();
    assert_eq!(load.object(), None);
    let (leaf, trunk) = (7, 2);
    load.add(leaf, 0.3, DVec3::X);
    load.add(trunk, 0.4, DVec3::ZERO);
    assert_eq!(load.object(), Some(trunk));
    load.add(leaf, 0.3, DVec3::Y);
    assert_eq!(load.object(), Some(leaf));
    assert!((load.normal_n - 1.0).abs() < 1e-15 && load.shear_link == DVec3::new(1.0, 1.0, 0.0));
    load.add(trunk, 0.2, DVec3::ZERO);
    assert_eq!(load.object(), Some(trunk));
}

/// Pins the force that a stop force is held against: that between one link and one object, skin and bare parts together;
/// forces of other links or other objects are not added, and the patch named is the one that feels most of it.
#[test]
fn forces_add_up_by_link_and_object() {
    let pair = |patch, link, object| Pair { patch, link, object };
    let touch = |pairs: &[(Pair, DVec3)]| Touch {
        pairs: pairs.iter().copied().collect(),
        ..Touch::default()
    };
    assert_eq!(Touch::default().largest_force(), None);
    let found = touch(&[
        (pair(Some(0), 3, 5), DVec3::X * 60.0),
        (pair(None, 3, 5), DVec3::X * 50.0),
        (pair(Some(1), 4, 5), DVec3::X * 90.0),
        (pair(None, 3, 6), DVec3::X * 100.0),
    ]);
    let expected = LinkForce {
        link: 3,
        object: 5,
        patch: Some(0),
        force_n: 110.0,
    };
    assert_eq!(found.largest_force(), Some(expected));
    let bare = touch(&[
        (pair(Some(0), 3, 5), DVec3::X * 3.0),
        (pair(None, 3, 5), DVec3::Y * 4.0),
    ]);
    let expected = LinkForce {
        patch: None,
        force_n: 5.0,
        ..expected
    };
    assert_eq!(bare.largest_force(), Some(expected));
}

/// Pins that contact forces balance the joints' springs, K (φ − q) = −Σ Jᵀ f, to 1e-3 once the arm is at rest, and
/// that taxels add up to them to 1e-9.
#[test]
fn springs_balance_contact_forces() {
    for force in [2.0, 9.0] {
        let (arm, world, equilibrium, touch) = press(trunk(), 0.017, force, 8.0);
        let angle = world.arm.joint_angle_rad(&world.physics);
        let poses = arm.forward_kinematics(&angle);
        let spring: Vec<f64> = (0..angle.len())
            .map(|joint| arm.joints[joint].stiffness_nm_per_rad * (equilibrium[joint] - angle[joint]))
            .collect();
        let spring = DVector::from_vec(spring);
        let mut contact = DVector::zeros(angle.len());
        for at in world.contacts() {
            let force = nalgebra::Vector3::from(at.force_world.to_array());
            let position = poses[at.link].transform_point(at.position_link);
            contact += arm.position_jacobian(&poses, at.link, position).transpose() * force;
        }
        assert!(contact.norm() > 0.1 * force, "no contact: {contact}");
        let residual = (&spring + &contact).norm() / spring.norm();
        assert!(
            residual < 1e-3,
            "relative residual {residual} at {force} N: {spring} {contact}"
        );
        let audit = world.auditor.audit();
        // The weaker push turns the joints with 0.3 Nm: too little for the audit to count.
        assert!(
            (audit.rest_frames > 0) == (force > 5.0) && audit.largest_static_residual < 0.05,
            "{audit:?}"
        );
        assert!(
            touch.force_residual < 1e-9,
            "taxels miss the solver's force by {}",
            touch.force_residual
        );
    }
}

/// Pins that a trunk lights a patch of taxels of the size of a stored frame of the real skin (nine newtons on
/// 4 × 2 taxels of 0.6–1.5 N), and that more force lights no fewer.
#[test]
fn a_broad_contact_lights_a_patch() {
    let lit = |force: f64| {
        let (.., touch) = press(trunk(), 0.017, force, 8.0);
        touch
            .taxels
            .iter()
            .filter(|taxel| taxel.true_normal_force_n > 0.02)
            .count()
    };
    let (few, many) = (lit(3.0), lit(12.0));
    assert!(
        (2..=12).contains(&few) && few <= many && many <= 24,
        "{few} taxels at 3 N, {many} at 12 N"
    );
}

/// Pins that an arm that starts 5 mm deep in a trunk is pushed out: the contact's 1e4 N/m give some 50 N at first, not
/// a throw, and after two seconds the arm rests against the trunk on its springs.
#[test]
fn an_arm_that_starts_in_contact_is_pushed_out() {
    // Too low for the upper arm, which cannot give way there.
    let trunk = Trunk {
        diameter_m: 0.03,
        height_m: 0.34,
    };
    let (_, world, _, touch) = press(Box::new(trunk), 0.010, 0.0, 2.0);
    let audit = world.auditor.audit();
    assert!(audit.largest_frame_force_jump_n < 100.0, "{audit:?}");
    let force = largest_force_n(&touch);
    // 5 mm against the arm's 0.1–0.5 kN/m.
    assert!((0.1..10.0).contains(&force), "{force} N");
}

/// Pins that a leaf gives way where a trunk does not: the same push, a tenth of the force.
#[test]
fn a_leaf_pushes_back_less_than_a_trunk() {
    let leaf = Leaf {
        height_m: 0.4,
        width_m: 0.03,
        flexural_rigidity_n_m2: 0.02,
        mass_per_area_kg_per_m2: 0.8,
        loss_factor: 0.1,
        root_stiffness_nm_per_rad: Some(2.0),
        segments: 8,
    };
    let (.., soft) = press(Box::new(leaf), 0.005, 6.0, 4.0);
    let (.., hard) = press(trunk(), 0.017, 6.0, 4.0);
    assert!(largest_force_n(&soft) > 0.01, "the leaf was not touched");
    assert!(
        largest_force_n(&soft) < 0.3 * largest_force_n(&hard),
        "{} N, {} N",
        largest_force_n(&soft),
        largest_force_n(&hard)
    );
}
