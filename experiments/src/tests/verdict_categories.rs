use underbrush_classifier::evaluate::JudgedObject;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::touch::TouchExamples;
use underbrush_recording::Recording;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::Experiment;
use crate::experiment::verdicts::{held_out, pooled};
use crate::tests::scenes;

fn examples(recordings: &[Recording]) -> TouchExamples {
    let mut examples = TouchExamples::new(Experiment::paper().unwrap().touch_options());
    recordings.iter().for_each(|recording| examples.add(recording).unwrap());
    examples
}

/// The first `count` reaches of a scene whose examples have this category alone.
fn touching(text: &str, category: &str, count: usize) -> Vec<Recording> {
    let plan = ReachPlan::new(Scene::parse("some.toml", text.into()).unwrap(), None, 0).unwrap();
    let reaches = (0..40).map(|index| plan.run(index, &mut |_| {}).unwrap());
    let own = reaches.filter(|own| examples(std::slice::from_ref(own)).categories() == [category]);
    let found: Vec<Recording> = own.take(count).collect();
    assert_eq!(found.len(), count, "{category}");
    found
}

/// Tests that verdicts of networks that know different categories are not counted together: they are an error among the verdicts that
/// were held out.
#[test]
fn verdicts_of_other_categories_are_not_counted_together() {
    let trunks = touching(scenes::TRUNKS_AT_FOREARM, "trunk", 2);
    let leaves = touching(scenes::LEAVES_AT_FOREARM, "leaf", 1);
    let recordings = [leaves[0].clone(), trunks[0].clone(), trunks[1].clone()];
    let error = held_out(&examples(&recordings), &recordings, 0).err().unwrap().to_string();
    assert!(error.contains("without fold 1 of 3, only trunk of the categories leaf, trunk"), "{error}");
}

/// Tests that sets of reaches are counted together and not averaged: three right objects of one set and a wrong one of another are
/// 75 % of four reaches.
#[test]
fn sets_of_reaches_count_by_their_size() {
    let set = |verdicts: &[&str]| {
        let object = |(reach, verdict): (usize, &&str)| JudgedObject {
            reach,
            truth: "leaf".into(),
            at_end: (*verdict).into(),
            ..JudgedObject::default()
        };
        TouchEvaluation {
            objects: verdicts.iter().enumerate().map(object).collect(),
            reaches: vec![Default::default(); verdicts.len()],
            ..TouchEvaluation::default()
        }
    };
    let found = pooled([&set(&["leaf"; 3]), &set(&["trunk"])], &["leaf".into(), "trunk".into()]).object_verdicts;
    assert_eq!((found.len(), found[0].at, found[0].objects), (1, "end", 4));
    assert_eq!((found[0].right, found[0].wrong, found[0].uncertain), (0.75, 0.25, 0.0));
    assert!(found[0].right_interval.is_some_and(|own| own.low < 0.75 && own.high == 1.0), "{found:?}");
}
