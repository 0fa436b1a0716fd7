//! Joint torques and contact forces of the moving arm balance.

use nalgebra::DVector;
use underbrush_sim::scene::PhysicsSection;

use sweep::Sweep;

#[path = "../../benches/peers/sweep.rs"]
mod sweep;

/// Mean torques, N m, of springs and dampers, and of contact forces, from 2 s to 3 s of the sweep.
///
/// The forearm then moves at its fastest through the leaves, and contact points come and go in every frame.
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

/// Tests that only real contact forces are counted: while the arm moves through leaves, contacts balance the joints'
/// springs and dampers, as they do at rest, after the torques of the same sweep without leaves are subtracted.
///
/// The tolerance is 5 %. The leaves push the arm off its free motion by some hundredths of a radian, which changes the
/// driving torques by a few per cent; these are a fifth of the leaves' torque. Counting old impulses gave 16 %.
#[test]
fn contacts_balance_the_springs_on_the_move() {
    let (free, nothing) = mean_torques(0);
    assert_eq!(nothing.norm(), 0.0, "contact without leaves");
    let (springs, contacts) = mean_torques(24);
    let needed = &free - springs;
    assert!(needed.norm() > 0.5, "the leaves hardly push: {needed}");
    let residual = (&needed - &contacts).norm() / needed.norm();
    assert!(residual < 0.05, "relative residual {residual}: {needed} needed, {contacts} found");
}
