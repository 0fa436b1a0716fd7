#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use underbrush_sim::scene::Scene;

use super::*;

#[path = "../../../tests/support/scenes.rs"]
#[expect(dead_code, reason = "one scene is enough here")]
mod scenes;

/// Pins that a reach counts as touching one category alone only if the category presses on a taxel in some trial. The
/// same reach does not count once nothing presses on its taxels.
#[test]
fn a_reach_with_spurious_trials_alone_is_not_wanted() {
    let text = scenes::TRUNKS_AT_FOREARM.to_owned();
    let plan = ReachPlan::new(Scene::parse("trunks.toml", text).unwrap(), None, 0).unwrap();
    let options = TrialOptions::default();
    let wanted = |category, recording: &Recording| Wanted::Only(category).is(recording, &options).unwrap();
    let mut reaches = (0..8).map(|index| plan.run(index, &mut |_, _| {}).unwrap());
    let mut reach = reaches.find(|reach| wanted(Category::TRUNK, reach)).unwrap();
    assert!(!wanted(Category::LEAF, &reach));
    let readings = reach.frames.iter_mut().flat_map(|frame| &mut frame.taxels);
    readings.for_each(|reading| (reading.object, reading.true_normal_force_n) = (None, 0.0));
    assert!(!taxel_trials(&reach, &options).unwrap().is_empty());
    assert!(!wanted(Category::TRUNK, &reach));
}
