#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::sync::Mutex;

use underbrush_sim::scene::Scene;

use super::*;
use crate::progress::{Counter, Silent};
use crate::tests::scenes;

/// Tests that a reach counts as touching one category alone only if the category presses on a taxel in some trial. The
/// same reach does not count once nothing presses on its taxels.
#[test]
fn a_reach_with_spurious_trials_alone_is_not_wanted() {
    let text = scenes::TRUNKS_AT_FOREARM.to_owned();
    let plan = ReachPlan::new(Scene::parse("trunks.toml", text).unwrap(), None, 0).unwrap();
    let options = TrialOptions::default();
    let wanted = |category, recording: &Recording| Wanted::Only(category).is(recording, &options).unwrap();
    let mut reaches = (0..8).map(|index| plan.run(index, &mut |_| {}).unwrap());
    let mut reach = reaches.find(|reach| wanted(Category::TRUNK, reach)).unwrap();
    assert!(!wanted(Category::LEAF, &reach));
    let readings = reach.frames.iter_mut().flat_map(|frame| &mut frame.taxels);
    readings.for_each(|reading| (reading.object, reading.true_normal_force_n) = (None, 0.0));
    assert!(!taxel_trials(&reach, &options).unwrap().is_empty());
    assert!(!wanted(Category::TRUNK, &reach));
}

/// Keeps the remarks.
#[derive(Default)]
struct Remarks(Mutex<Vec<String>>);

impl Progress for Remarks {
    fn stage(&self, _: &str) {}

    fn remark(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }

    fn count(&self, _: &str, _: u64, _: u64) -> Box<dyn Counter> {
        Box::new(Silent)
    }
}

/// Tests that a cached reach whose file is damaged or missing is drawn again with a remark, and equals the first one;
/// and that an undamaged one is read without a remark.
#[test]
fn a_damaged_reach_is_drawn_again() {
    let folder = tempfile::tempdir().unwrap();
    let text = scenes::FEW_TRUNKS.to_owned();
    let search = Search {
        name: "trunks".into(),
        plan: ReachPlan::new(Scene::parse("trunks.toml", text).unwrap(), None, 0).unwrap(),
        options: TrialOptions::default(),
        wanted: Wanted::All(Vec::new()),
        enough: 1,
        max_draws: 1,
    };
    let plan = Plan::new(&Experiment::paper().unwrap(), 0, false);
    let found = || {
        let remarks = Remarks::default();
        let found = search.run(folder.path(), plan.clone(), &remarks).unwrap();
        (found.reaches, remarks.0.into_inner().unwrap())
    };
    let (first, _) = found();
    let file = folder.path().join("trunks-0.parquet");
    let whole = std::fs::read(&file).unwrap();
    assert!(found() == (first.clone(), Vec::new()));
    for damaged in [Some(whole[..whole.len() / 2].to_vec()), None] {
        match damaged {
            Some(bytes) => std::fs::write(&file, bytes).unwrap(),
            None => std::fs::remove_file(&file).unwrap(),
        }
        let (again, remarks) = found();
        assert_eq!((again.len(), remarks.len()), (1, 1), "{remarks:?}");
        assert!(remarks[0].contains("trunks-0.parquet") && remarks[0].contains("drawn again"));
        assert!(again == first);
        assert!(std::fs::read(&file).unwrap() == whole);
    }
}

/// Tests that two searches in one scene, each with its own requirement, do not take the files of each other: among leaves
/// one touches a leaf alone, and none a trunk, also if one thread searches for them one after the other.
#[test]
fn searches_in_one_scene_are_kept_apart() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    file("leaves.toml", scenes::LEAVES_AT_FOREARM);
    file("other-leaves.toml", &format!("stream = \"other\"\n{}", scenes::LEAVES_AT_FOREARM));
    file("trunks.toml", scenes::FEW_TRUNKS);
    file(
        "small.toml",
        r#"title = "Small"
training = [
    { scene = "other-leaves.toml", label = "leaf", reaches = 2 },
    { scene = "trunks.toml", label = "trunk", reaches = 2 },
]
engineered = [
    { scene = "leaves.toml", label = "leaf" },
    { scene = "leaves.toml", label = "trunk", max_draws = 1 },
]
"#,
    );
    let experiment = Experiment::load(&folder.path().join("small.toml")).unwrap();
    let session = || Session::new(&experiment, (3, false, 1), folder.path(), &Silent);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    // The second time they are read from the files.
    for _ in 0..2 {
        let found = one_thread.install(|| run(&session()).map(|found| found.engineered)).unwrap();
        assert_eq!([0, 1].map(|place| found[place].1.reaches.len()), [1, 0]);
        assert_eq!(found[1].1.drawn, 1);
    }
}
