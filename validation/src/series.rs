//! Check 14: arm, contact and object are springs in series.

use glam::DVec3;
use nalgebra::Vector3;
use underbrush_oracles::{beam, foam, statics};
use underbrush_sim::object::foam_roll::FoamRoll;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::{Arm, PhysicsOptions};

use crate::pressed_arm::{self, Beside, LEAF, OPTIONS, PressedArm, scale_friction, scale_stiffness};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 14.
pub const CHECK: Check = Check {
    name: "series-pushing",
    summary: "Pushing force follows the series stiffness of arm, contact and object",
    cases: &[
        Case { compare: |simulated| leaf("leaf, high on the blade", 0.30, simulated), falsifications: &[STIFF_BLADE] },
        Case { compare: |simulated| leaf("leaf, low on the blade", 0.15, simulated), falsifications: &[STIFF_BLADE] },
        Case { compare: roll, falsifications: &[STIFF_FOAM] },
        Case { compare: trunk, falsifications: &[STIFF_JOINTS] },
    ],
};

const STIFF_BLADE: Falsification = Falsification::new("flexural rigidity of the simulated leaf", "10 % too high");
const STIFF_FOAM: Falsification = Falsification::new("modulus of the simulated roll", "10 % too high");
const STIFF_JOINTS: Falsification = Falsification::new("stiffness of the simulated joints", "5 % too high");

/// A roll that relaxes within a fifth of a second, so that a state of rest shows the relaxed stiffness.
const ROLL: FoamRoll = FoamRoll { relaxation_time_s: 0.2, ..pressed_arm::ROLL };

/// A state of rest of the pushed object.
struct Pushed {
    force_n: f64,
    /// Direction in which the arm pushes, unit, world frame.
    outward_world: DVec3,
    /// Where the forearm is touched, m, link frame.
    place_link: DVec3,
    angle_rad: Vec<f64>,
    equilibrium_rad: Vec<f64>,
    /// Overlap of the two shapes, m.
    overlap_m: f64,
}

/// A leaf whose foot stands `drop_m` under the forearm's axis.
fn leaf(name: &str, drop_m: f64, simulated: Simulated) -> Found {
    let leaf = Leaf {
        // Narrow, so that it is touched at its midline and not twisted.
        width_m: 0.01,
        flexural_rigidity_n_m2: LEAF.flexural_rigidity_n_m2 * simulated.with(STIFF_BLADE, 1.0, 1.1),
        loss_factor: 0.3,
        root_stiffness_nm_per_rad: None,
        // Many, so that the beam's closed form applies.
        segments: 20,
        ..LEAF
    };
    let beside = Beside::facing(Box::new(leaf), 0.002, drop_m);
    let object_n_per_m = |height_m| 1.0 / beam::beam_deflection_m(1.0, height_m, LEAF.flexural_rigidity_n_m2);
    series(name, beside, [0.003, 0.004], simulated, object_n_per_m)
}

/// A roll that is touched at the middle of its sixth slice of ten. A slice is compressed like a bar as long and as wide
/// as the roll's diameter. The core leans so that its top moves like the top of a cantilever, and lower points move in
/// proportion to their height.
fn roll(simulated: Simulated) -> Found {
    let roll = FoamRoll { modulus_pa: ROLL.modulus_pa * simulated.with(STIFF_FOAM, 1.0, 1.1), ..ROLL };
    let remaining_pa = ROLL.modulus_pa * (1.0 - ROLL.relaxing_share);
    let slice_m2 = ROLL.diameter_m * ROLL.height_m / 10.0;
    let slice = foam::bar_force_n(remaining_pa, slice_m2, ROLL.diameter_m, 1.0);
    let area_moment_m4 = std::f64::consts::PI * ROLL.diameter_m.powi(4) / 64.0;
    let top_m_per_n = beam::beam_deflection_m(1.0, ROLL.height_m, remaining_pa * area_moment_m4);
    let object_n_per_m = |height_m: f64| statics::in_series(&[slice, (ROLL.height_m / height_m).powi(2) / top_m_per_n]);
    let beside = Beside::facing(Box::new(roll), 0.061, 0.275);
    series("roll", beside, [0.002, 0.003], simulated, object_n_per_m)
}

fn trunk(simulated: Simulated) -> Found {
    series("trunk", Beside { gap_m: 0.016, ..Beside::trunk() }, [0.006, 0.011], simulated, |_| f64::INFINITY)
}

/// Increase of force over displacement of the equilibrium point between two states of rest, compared with arm and object in
/// series. The arm has neither friction nor gravity. `moves_m` are the moves of its equilibrium point across the forearm; in the
/// first millimetre of a move nothing is touched. Position and direction of the contact are the means of the two states.
///
/// The skin also gives way, so the overlap of the shapes is measured and subtracted from the push. Of the expected
/// value, only the position of the contact is read from the simulation.
fn series(
    name: &str,
    beside: Beside,
    moves_m: [f64; 2],
    simulated: Simulated,
    object_n_per_m: impl Fn(f64) -> f64,
) -> Found {
    let wrong = |arm: &mut Arm| {
        scale_friction(arm, 0.0);
        // A skin so stiff that the place of the contact does not shift with its depth; `contact-law` checks the skin's own
        // stiffness.
        arm.skin.stiffness_n_per_m3 = 1e9;
        scale_stiffness(arm, simulated.with(STIFF_JOINTS, 1.0, 1.05));
    };
    let mut pressed = PressedArm::new(beside, PhysicsOptions { gravity_m_per_s2: 0.0, ..OPTIONS }, wrong)?;
    let (less, more) = (pushed(&mut pressed, moves_m[0])?, pushed(&mut pressed, moves_m[1])?);
    let rise_n = more.force_n - less.force_n;
    let outward = (less.outward_world + more.outward_world).normalize();
    let place_link = 0.5 * (less.place_link + more.place_link);
    let place =
        |angle_rad: &[f64]| pressed.arm.forward_kinematics(angle_rad)[pressed.forearm].transform_point(place_link);
    let middle: Vec<f64> = less.angle_rad.iter().zip(&more.angle_rad).map(|(a, b)| 0.5 * (a + b)).collect();
    let poses = pressed.arm.forward_kinematics(&middle);
    let row = Vector3::from(outward.to_array()).transpose() * pressed.jacobian(&poses, place(&middle));
    let joints = row.iter().zip(&pressed.arm.joints);
    let arm = 1.0 / joints.map(|(lever, joint)| lever * lever / joint.stiffness_nm_per_rad).sum::<f64>();
    let height_m = place(&middle).z - pressed.simulation.clutter().objects[0].foot_world.z;
    let push_m = (place(&more.equilibrium_rad) - place(&less.equilibrium_rad)).dot(outward);
    let overlap_m = more.overlap_m - less.overlap_m;
    let expected = statics::in_series(&[arm, object_n_per_m(height_m)]);
    let found = rise_n / (push_m - overlap_m);
    let reason = "2 %: the arm's stiffness and the lever change during the push; the height of the contact on a leaf, \
                  whose cube enters, is known to a third of a millimetre in 0.1 m, as it lies between two segments";
    Ok(vec![Comparison::of(format!("force over push, {name}"), "N/m", expected, found).relative(2e-2, reason)])
}

/// The state of rest after a move of the equilibrium point, m.
fn pushed(pressed: &mut PressedArm, move_m: f64) -> Result<Pushed, Fault> {
    let equilibrium_rad = pressed.moving_rad(move_m);
    pressed.hold(&equilibrium_rad, 8.0);
    let contacts = &pressed.report().contacts;
    let force: DVec3 = contacts.iter().map(|contact| contact.force_world).sum();
    if force == DVec3::ZERO || contacts.iter().any(|contact| contact.link != pressed.forearm) {
        return Err(Fault::Run("the forearm does not touch the object, or another link does".into()));
    }
    // The overlap is weighted by the normal forces.
    let normals_n = contacts.iter().map(|contact| contact.force_world.dot(contact.inward_world));
    let overlaps = normals_n.clone().zip(contacts).map(|(normal_n, contact)| contact.penetration_m * normal_n);
    let weights = contacts.iter().map(|contact| contact.force_world.length());
    let places = contacts.iter().map(|contact| contact.position_link * contact.force_world.length());
    Ok(Pushed {
        force_n: force.length(),
        outward_world: -force.normalize(),
        place_link: places.sum::<DVec3>() / weights.sum::<f64>(),
        angle_rad: pressed.report().joint_angle_rad(),
        equilibrium_rad,
        overlap_m: overlaps.sum::<f64>() / normals_n.sum::<f64>(),
    })
}
