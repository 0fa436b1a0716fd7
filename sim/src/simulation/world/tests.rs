//! Tests of what a frame allocates, and of which objects are in the engine.

use std::f64::consts::TAU;

use allocation_counter::measure;
use glam::DVec3;

use crate::simulation::{Simulation, State, StepContact};
use crate::{ReachPlan, Scene};

/// Many leaves and a few trunks, which the arm meets with several links.
const SCENE: &str = r#"
summary = "Leaves and trunks"
[goals]
count = 1
retries = 0
[[objects.foam_block]]
count = 4
[[objects.trunk]]
count = 2
[[objects.leaf]]
count = 24
"#;

/// Numbers of allocations in one frame.
#[derive(Debug, Default)]
struct Allocations {
    /// Before each step: equilibrium angles.
    before_steps: u64,
    /// Steps: trees, pairs of shapes, patches, solution.
    steps: u64,
    /// Finding which objects rest and wake.
    dormancy: u64,
    /// The report of the frame, with skin and sensor.
    report: u64,
}

fn count(into: &mut u64, part: impl FnOnce()) {
    *into += measure(part).count_total;
}

/// Advances by one frame, as [`Simulation::step`] does.
fn advance(simulation: &mut Simulation, equilibrium_angle_rad: &[f64]) -> Allocations {
    let (model, state) = (&*simulation.model, &mut simulation.state);
    let mut found = Allocations::default();
    let State { world, report, .. } = state;
    report.contacts.clear();
    world.contact_colliders.clear();
    for _ in 0..2 {
        count(&mut found.before_steps, || {
            world.arm.set_equilibrium(&model.arm, equilibrium_angle_rad, &mut world.engine);
        });
        count(&mut found.steps, || {
            world.engine.step();
            world.gather_contacts(model, &mut report.contacts);
        });
    }
    count(&mut found.dormancy, || world.rest_and_wake(model, &report.contacts));
    report.frame += 1;
    count(&mut found.report, || state.write_report(model));
    found
}

/// Tests that frames allocate no memory, except those in which Rapier's broad phase runs: at most one in ten. The arm moves to
/// and fro among leaves and trunks that it touches. The frames are those of [`Simulation::step`].
#[test]
fn only_the_broad_phase_allocates_in_a_frame() {
    let plan = ReachPlan::new(Scene::parse("many.toml", SCENE.into()).unwrap(), None, 1).unwrap();
    // The frame with most touched taxels of six reaches.
    let touched = |index: u64| {
        let frames = plan.run(index, &mut |_| {}).unwrap().frames;
        let most = frames.iter().enumerate().max_by_key(|(_, frame)| frame.taxels.len());
        let (place, count) = most.map(|(place, frame)| (place, frame.taxels.len())).unwrap();
        (count, place, index, frames)
    };
    let (_, most, reach, frames) = (0..6).map(touched).max_by_key(|(count, ..)| *count).unwrap();
    let (mut simulation, mut twin) = (plan.simulation(reach).unwrap(), plan.simulation(reach).unwrap());
    for frame in &frames[..most] {
        advance(&mut simulation, &frame.equilibrium_angle_rad);
        twin.step(&frame.equilibrium_angle_rad);
    }
    let held = &frames[most].equilibrium_angle_rad;
    // Two periods of a second in which buffers may still grow, and one that counts.
    let (mut changed, mut counted, mut allocating) = (0, 0, 0);
    for frame in 0..300 {
        let sway = 0.02 * (f64::from(frame) * TAU / 100.0).sin();
        let angles: Vec<f64> = held.iter().map(|angle| angle + sway).collect();
        let active = |simulation: &Simulation| -> Vec<bool> {
            simulation.report().objects.iter().map(|object| object.active).collect()
        };
        let before = active(&simulation);
        let found = advance(&mut simulation, &angles);
        if active(&simulation) != before {
            changed = frame;
        }
        assert_eq!(simulation.report(), twin.step(&angles));
        // An object that enters the engine needs memory, there and in the next frames.
        if frame < 200 || frame < changed + 5 {
            continue;
        }
        counted += 1;
        let touching = simulation.report().contacts.len() as u64;
        assert!(touching >= 4, "{touching} contacts in frame {frame}");
        let own = [found.before_steps, found.dormancy, found.report];
        assert_eq!(own, [0; 3], "frame {frame}: {found:?}");
        allocating += usize::from(found.steps > 0);
    }
    assert!(10 * allocating <= counted, "{allocating} of {counted} frames");
    assert!(counted > 50, "{counted} frames without a change of the engine's objects");
}

/// Tests that an object that touched the arm in a frame stays in the engine until the next one, even if it rests and
/// the arm is already far away: the skin still reads its collision shapes.
#[test]
fn an_object_that_was_touched_is_not_taken_out() {
    let plan = ReachPlan::new(Scene::parse("many.toml", SCENE.into()).unwrap(), None, 1).unwrap();
    let mut simulation = plan.simulation(0).unwrap();
    let (model, state) = (&*simulation.model, &mut simulation.state);
    let world = &mut state.world;
    let dormant = world.mechanisms.iter().position(Option::is_none).unwrap();
    world.insert(model, dormant);
    let touch = StepContact {
        link: 0,
        object: Some(dormant),
        body: 0,
        position_link: DVec3::ZERO,
        inward_world: DVec3::X,
        force_world: DVec3::ZERO,
        moment_world: DVec3::ZERO,
        penetration_m: 0.0,
        radius_m: 0.0,
        area_m2: 1e-5,
        slip_world: DVec3::ZERO,
    };
    world.rest_and_wake(model, &[touch]);
    assert!(world.mechanisms[dormant].is_some());
    world.rest_and_wake(model, &[]);
    assert!(world.mechanisms[dormant].is_none());
}
