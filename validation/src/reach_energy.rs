//! Check 12: in a whole reach, the work of the actuators is stored or lost somewhere.

use underbrush_sim::audit::energy::EnergyBalance;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::{Scene, shipped};

use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 12.
pub const CHECK: Check = Check {
    name: "reach-energy",
    summary: "Over a whole reach, the work of the actuators equals the energy stored in the arm plus the losses in dampers, \
              contacts and integrator",
    cases: &[
        Case { compare: |simulated| compare("trunks", "trunk.toml", simulated), falsifications: &[STRONG_DAMPERS] },
        Case { compare: |simulated| compare("leaves", "leaf.toml", simulated), falsifications: &[STRONG_DAMPERS] },
    ],
};

const STRONG_DAMPERS: Falsification =
    Falsification::new("dampers of the simulated joints", "20 % stronger than the balance knows");

/// The energy balance of one reach. The balance does not know of dampers that are wrong.
fn compare(name: &str, scene: &str, simulated: Simulated) -> Found {
    let wrong = simulated.with(STRONG_DAMPERS, 1.0, 1.2);
    let text = shipped(scene).ok_or_else(|| Fault::Run(format!("no scene {scene} ships")))?;
    let mut scene = Scene::parse(format!("{name}.toml"), text.into())?;
    scene.file.physics.step_s = 1e-3;
    let mut plan = ReachPlan::new(scene, None, 0)?;
    for joint in &mut plan.arm.joints {
        joint.damping_nm_s_per_rad *= wrong;
        // The engine does not report the work of a joint stop.
        joint.limits_rad = [f64::NEG_INFINITY, f64::INFINITY];
    }
    let recording = plan.run(0, &mut |_| {})?;
    // The same reach again, with its energies recorded.
    let mut simulation = plan.simulation(0)?;
    let mut balance = EnergyBalance::new(&simulation);
    // No step follows the last frame, which ends the reach.
    for frame in recording.frames.iter().rev().skip(1).rev() {
        simulation.step_observed(&frame.equilibrium_angle_rad, &mut |step| balance.observe_step(step));
    }
    let sums = balance.sums;
    let found = sums.stored_j + sums.dampers_j / wrong + sums.contacts_j + sums.integrator_j;
    if sums.contacts_j == 0.0 {
        return Err(Fault::Run(format!("the reach among {name} touched nothing")));
    }
    let reason = "1 % of the work exchanged: impacts and dampers are resolved to first order in the step of 1 ms";
    let quantity = format!("work of the actuators in a reach among {name}");
    let work = Comparison::of(quantity, "J", sums.actuators_j, found).relative(0.01, reason);
    Ok(vec![Comparison { residual: (found - sums.actuators_j).abs() / sums.exchanged_j, ..work }])
}
