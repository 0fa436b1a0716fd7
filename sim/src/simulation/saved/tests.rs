//! A saved simulation continues exactly, and bad states are refused.

use super::StateError;
use crate::simulation::{FrameReport, Simulation};
use crate::{ReachPlan, Scene};

/// Leaves, a trunk, foam and a roll near the arm, with all effects of the sensor.
const SCENE: &str = r#"
summary = "One of each"
[goals]
count = 1
[[objects.foam_block]]
count = 2
[[objects.trunk]]
count = 2
[[objects.leaf]]
count = 8
[[objects.foam_roll]]
count = 1
"#;

fn plan(seed: u64) -> ReachPlan {
    ReachPlan::new(Scene::parse("saved.toml", SCENE.into()).unwrap(), None, seed).unwrap()
}

/// Continues along recorded equilibrium angles, and returns the report of each frame.
fn go_on(simulation: &mut Simulation, angles: &[Vec<f64>]) -> Vec<FrameReport> {
    angles.iter().map(|angles| simulation.step(angles).clone()).collect()
}

/// Tests that a state saved at many moments of a reach, with contacts and with objects that are woken and put to rest,
/// is loaded into a fresh simulation which then continues bit for bit: every number of every report, the sensor's noise
/// included.
#[test]
fn a_loaded_simulation_continues_bit_for_bit() {
    let plan = plan(3);
    let recording = plan.run(0, &mut |_| {}).unwrap();
    assert!(!recording.contacts.is_empty(), "the reach touches something");
    let frames = recording.frames.into_iter().take(400);
    let angles: Vec<Vec<f64>> = frames.map(|frame| frame.equilibrium_angle_rad).collect();
    let mut simulation = plan.simulation(0).unwrap();
    let mut saved = vec![simulation.save().unwrap()];
    let mut reports = Vec::new();
    let mut changes = 0;
    let mut active = 0;
    for angles in &angles {
        let report = simulation.step(angles).clone();
        let now = report.objects.iter().filter(|object| object.active).count();
        changes += usize::from(now != active);
        active = now;
        reports.push(report);
        saved.push(simulation.save().unwrap());
    }
    assert!(changes > 2, "objects are woken and put to rest");
    for start in (0..angles.len()).step_by(7) {
        let mut loaded = plan.simulation(0).unwrap();
        loaded.load(&saved[start]).unwrap();
        let end = (start + 60).min(angles.len());
        let found = go_on(&mut loaded, &angles[start..end]);
        for (found, expected) in found.iter().zip(&reports[start..end]) {
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "saved after frame {start}");
        }
        // Saving again gives the same bytes, so nothing that is saved was lost on the way.
        assert!(loaded.save().unwrap() == saved[end], "saved after frame {start}");
    }
}

/// Tests that bytes that are no state, a state with a changed or missing byte, and a state of another clutter are
/// refused, each with its own error, and leave the simulation as it was.
#[test]
fn bad_states_are_refused() {
    let mut simulation = plan(3).simulation(0).unwrap();
    let saved = simulation.save().unwrap();
    let before = simulation.report().clone();
    for bytes in [&b""[..], b"underbrush", b"PAR1 and more than sixteen bytes"] {
        assert!(matches!(simulation.load(bytes), Err(StateError::NotAState)));
    }
    let cut = &saved[..saved.len() - 1];
    assert!(matches!(simulation.load(cut), Err(StateError::Damaged)));
    assert!(matches!(simulation.load(&saved[..40]), Err(StateError::Damaged)));
    let mut flipped = saved.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    assert!(matches!(simulation.load(&flipped), Err(StateError::Damaged)));
    let foreign = plan(4).simulation(0).unwrap().save().unwrap();
    assert!(matches!(simulation.load(&foreign), Err(StateError::Foreign)));
    assert_eq!(simulation.report(), &before);
    simulation.load(&saved).unwrap();
}
