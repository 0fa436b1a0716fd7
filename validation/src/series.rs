//! Check 14: arm, contact and object are springs one behind the other.

use glam::DVec3;
use nalgebra::Vector3;
use rapier3d::prelude::ColliderHandle;
use underbrush_oracles::{beam, statics};
use underbrush_sim::arm::Arm;
use underbrush_sim::object::Object;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::object::trunk::Trunk;
use underbrush_sim::physics::{PhysicsOptions, pressed_points};

use crate::pressed_arm::{OPTIONS, PressedArm};
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 14.
pub const CHECK: Check = Check {
    number: 14,
    name: "series-pushing",
    summary: "Pushing, force rises with the equilibrium point as arm, contact and object in series say",
    falsification: "E I of the simulated leaf 10 % too high, stiffness of the simulated joints 5 % too high",
    compare,
};

const LEAF_HEIGHT_M: f64 = 0.4;
const LEAF_RIGIDITY_N_M2: f64 = 0.02;
/// The leaf's foot under the forearm's axis, m: high and low on the blade, where it is soft and stiff.
const DROPS_M: [f64; 2] = [0.30, 0.15];

/// A state of rest of the pushed object.
struct Pushed {
    force_n: f64,
    /// Direction in which the arm pushes, unit, world frame.
    outward_world: DVec3,
    /// Where the forearm is touched, m, link frame.
    place_link: DVec3,
    angle_rad: Vec<f64>,
    equilibrium_rad: Vec<f64>,
    /// How far the engine lets the two shapes into each other, m.
    overlap_m: f64,
}

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let leaf = Leaf {
        height_m: LEAF_HEIGHT_M,
        // Narrow, so that it is touched at its middle line and not twisted.
        width_m: 0.01,
        flexural_rigidity_n_m2: LEAF_RIGIDITY_N_M2 * simulated.with(1.0, 1.1),
        mass_per_area_kg_per_m2: 0.8,
        loss_factor: 0.3,
        root_stiffness_nm_per_rad: None,
        // Many, so that the closed form may be the beam's.
        segments: 20,
    };
    let trunk = Trunk {
        diameter_m: 0.03,
        height_m: 0.6,
    };
    let mut comparisons = Vec::new();
    for drop_m in DROPS_M {
        let pushed = push(Box::new(leaf), 0.002, drop_m, [0.003, 0.004], simulated)?;
        comparisons.push(series("leaf", &pushed, |height_m| {
            1.0 / beam::beam_deflection_m(1.0, height_m, LEAF_RIGIDITY_N_M2)
        })?);
    }
    let pushed = push(Box::new(trunk), 0.016, 0.3, [0.006, 0.011], simulated)?;
    comparisons.push(series("trunk", &pushed, |_| f64::INFINITY)?);
    Ok(comparisons)
}

/// The arm and two states of rest of one object, without friction and gravity, for two moves, m, of the equilibrium
/// point across the forearm. The first millimetre is air.
fn push(
    object: Box<dyn Object>,
    gap_m: f64,
    drop_m: f64,
    moves_m: [f64; 2],
    simulated: Simulated,
) -> Result<(PressedArm, [Pushed; 2]), CheckError> {
    let options = PhysicsOptions {
        gravity_m_per_s2: 0.0,
        ..OPTIONS
    };
    let arm = Arm::cody()?;
    let mut wrong = arm.clone();
    for joint in &mut wrong.joints {
        joint.stiffness_nm_per_rad *= simulated.with(1.0, 1.05);
    }
    let mut pressed = PressedArm::new(arm, wrong, object, gap_m, drop_m, options)?;
    for (_, collider) in pressed.world.physics.colliders.iter_mut() {
        collider.set_friction(0.0);
    }
    let mut state = |move_m: f64| {
        let equilibrium = pressed.moving_rad(move_m);
        pressed.hold(&equilibrium, 8.0);
        measure(&pressed, equilibrium)
    };
    let states = [state(moves_m[0])?, state(moves_m[1])?];
    Ok((pressed, states))
}

fn measure(pressed: &PressedArm, equilibrium_rad: Vec<f64>) -> Result<Pushed, CheckError> {
    let contacts = pressed.world.contacts();
    let force: DVec3 = contacts.iter().map(|contact| contact.force_world).sum();
    if force == DVec3::ZERO || contacts.iter().any(|contact| contact.link != pressed.forearm) {
        return Err(CheckError::Case(
            "the forearm does not touch, or another link does".into(),
        ));
    }
    let weights = contacts.iter().map(|contact| contact.force_world.length());
    let places = contacts.iter().map(|contact| contact.position_link);
    let place = weights
        .clone()
        .zip(places)
        .map(|(weight, place)| place * weight)
        .sum::<DVec3>();
    Ok(Pushed {
        force_n: force.length(),
        outward_world: -force.normalize(),
        place_link: place / weights.sum::<f64>(),
        angle_rad: pressed.angles_rad(),
        equilibrium_rad,
        overlap_m: overlap_m(pressed),
    })
}

/// The rise of force over the rise of the equilibrium point between two states, beside arm, contact and object in
/// series. Place and direction of the contact are the means of the two states'.
fn series(
    name: &str,
    (pressed, [less, more]): &(PressedArm, [Pushed; 2]),
    object_n_per_m: impl Fn(f64) -> f64,
) -> Result<Comparison, CheckError> {
    let rise_n = more.force_n - less.force_n;
    let outward = (less.outward_world + more.outward_world).normalize();
    let place_link = 0.5 * (less.place_link + more.place_link);
    let place =
        |angle_rad: &[f64]| pressed.arm.forward_kinematics(angle_rad)[pressed.forearm].transform_point(place_link);
    let middle: Vec<f64> = less
        .angle_rad
        .iter()
        .zip(&more.angle_rad)
        .map(|(a, b)| 0.5 * (a + b))
        .collect();
    let poses = pressed.arm.forward_kinematics(&middle);
    let row = Vector3::from(outward.to_array()).transpose() * pressed.jacobian(&poses, place(&middle));
    let joints = row.iter().zip(&pressed.arm.joints);
    let arm = 1.0
        / joints
            .map(|(lever, joint)| lever * lever / joint.stiffness_nm_per_rad)
            .sum::<f64>();
    // The engine's softness of contacts is no material's; it is taken as measured, from the overlap of the shapes.
    let contact = rise_n / (more.overlap_m - less.overlap_m);
    let height_m = place(&middle).z - pressed.clutter.objects[0].foot_world.z;
    let push_m = (place(&more.equilibrium_rad) - place(&less.equilibrium_rad)).dot(outward);
    Ok(Comparison::relative(
        format!("force over push, {name} at {height_m:.2} m"),
        "N/m",
        statics::in_series(&[arm, contact, object_n_per_m(height_m)]),
        rise_n / push_m,
        1e-2,
        "1 %: the arm's stiffness and the lever change over the push; the contact's own stiffness is measured",
    ))
}

/// Overlap of the shapes at the contact points, weighed by their impulses, m.
fn overlap_m(pressed: &PressedArm) -> f64 {
    let physics = &pressed.world.physics;
    let colliders = pressed.world.arm.colliders.iter();
    let on_forearm = colliders
        .filter(|(_, link)| *link == pressed.forearm)
        .map(|(collider, _)| *collider);
    let points = on_forearm.flat_map(|collider: ColliderHandle| physics.narrow_phase.contact_pairs_with(collider));
    let points = points.flat_map(|pair| pair.manifolds()).flat_map(pressed_points);
    let (mut sum, mut weight) = (0.0, 0.0);
    for point in points {
        sum -= point.dist * point.data.impulse;
        weight += point.data.impulse;
    }
    sum / weight
}
