//! The arm's joints against the contact forces that are read from the engine, while it moves.

use nalgebra::DVector;
use underbrush_sim::scene::PhysicsSection;

use sweep::Sweep;

#[path = "../../benches/peers/sweep.rs"]
mod sweep;

/// Means over one second of the sweep, from its second to its third, of the torques of springs and dampers and of the
/// contact forces, Nm.
///
/// The forearm then goes at its fastest through the leaves: contact points come and go in every frame.
fn mean_torques(leaves: usize) -> (DVector<f64>, DVector<f64>) {
    let mut simulation = Sweep::new(leaves, 0).simulation(PhysicsSection::default().options(), true);
    let arm = simulation.arm().clone();
    let joints = arm.joints.len();
    let (mut springs, mut contacts) = (DVector::zeros(joints), DVector::zeros(joints));
    let mut frame = 0;
    Sweep::run(&mut simulation, |report| {
        if (200..300).contains(&frame) {
            springs += DVector::from_vec(report.joint_torque_nm()) / 100.0;
            contacts += DVector::from_vec(report.contact_torque_nm(&arm)) / 100.0;
        }
        frame += 1;
    });
    (springs, contacts)
}

/// Pins that no contact force is counted that did not act: contacts balance the joints' springs and dampers on the move
/// through leaves as at rest, where what moves the arm itself, taken from the same sweep without leaves, is subtracted.
///
/// Within 5 %: the leaves bend the arm from the free motion by some hundredths of a radian, so what moves it differs by
/// some per cent of itself, which is a fifth of the leaves' torque. Impulses left over from earlier steps were 16 %.
#[test]
fn contacts_balance_the_springs_on_the_move() {
    let (free, nothing) = mean_torques(0);
    assert_eq!(nothing.norm(), 0.0, "contact without leaves");
    let (springs, contacts) = mean_torques(24);
    let needed = &free - springs;
    assert!(needed.norm() > 0.5, "the leaves hardly push: {needed}");
    let residual = (&needed - &contacts).norm() / needed.norm();
    assert!(
        residual < 0.05,
        "relative residual {residual}: {needed} needed, {contacts} found"
    );
}
