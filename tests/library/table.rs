//! A table that is an object of the scene.

use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::Simulation;

/// The height of the table, m: within the reach of the lowered hand.
const HEIGHT_M: f64 = -0.40;

/// A simulation of Cody over the ground, with or without a table that can be touched.
fn simulation(table: &str) -> Simulation {
    let text = format!(
        "summary = \"A table\"\nworkspace.table_height_m = {HEIGHT_M:?}\ngoals.positions_m = [[0.5, -0.3, -0.46]]\n{table}"
    );
    let plan = ReachPlan::new(Scene::parse("table.toml", text).unwrap(), None, 1).unwrap();
    plan.simulation(0).unwrap()
}

/// The change of shoulder and elbow by which the hand would be some 5 cm below the table, rad.
const TURN_RAD: [f64; 2] = [0.3, -0.5];

/// Lowers the equilibrium angles over one second, waits for two, and returns the simulation and the height of the end effector, m.
fn lowered(table: &str) -> (Simulation, f64) {
    let mut simulation = simulation(table);
    let start = simulation.arm().start_posture_rad();
    for frame in 0..300 {
        let share = (f64::from(frame) / 100.0).min(1.0);
        let mut equilibrium = start.clone();
        equilibrium[0] += share * TURN_RAD[0];
        equilibrium[3] += share * TURN_RAD[1];
        simulation.step(&equilibrium);
    }
    let height_m = simulation.report().end_effector_pose_world.position.z;
    (simulation, height_m)
}

/// Tests that the table stops the hand, that the contact is one with the table, and that at rest its force balances the joints'
/// springs. The tolerance is 2 %: after two seconds the arm still moves a little.
#[test]
fn a_table_stops_the_arm() {
    let (free, free_height_m) = lowered("");
    assert!(free.report().contacts.is_empty() && free_height_m < HEIGHT_M - 0.03, "{free_height_m}");
    let (stopped, height_m) = lowered("[[objects.table]]\ncount = 1\n");
    let report = stopped.report();
    assert!(height_m > HEIGHT_M - 0.02, "{height_m}");
    assert!(!report.contacts.is_empty() && report.contacts.iter().all(|contact| contact.object == Some(0)));
    assert!(report.contacts.iter().all(|contact| contact.force_world.z > 0.0 && contact.penetration_m < 0.01));
    let (springs, contacts) = (report.joint_torque_nm(), report.contact_torque_nm(stopped.arm()));
    let sum: f64 = springs.iter().zip(&contacts).map(|(spring, contact)| (spring + contact).powi(2)).sum();
    let scale: f64 = contacts.iter().map(|contact| contact.powi(2)).sum();
    assert!(sum.sqrt() < 0.02 * scale.sqrt(), "{springs:?} and {contacts:?}");
}
