use underbrush_classifier::evaluate::JudgedObject;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::touch::TouchExamples;
use underbrush_recording::Recording;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::Experiment;
use crate::experiment::settings::{FoldedReaches, VerdictTransfer};
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

fn transfer(here: &FoldedReaches, nominal: &FoldedReaches) -> VerdictTransfer {
    VerdictTransfer::of("soft", &Experiment::paper().unwrap().touch_options(), here, nominal).unwrap()
}

/// Tests that verdicts of networks that know different categories are not counted together: they give no figure of a
/// setting, and are an error among the verdicts that were held out. Tests also that the contacts of a setting are counted
/// if only the networks of the scenes' own setting can be fitted.
#[test]
fn verdicts_of_other_categories_are_not_counted_together() {
    let trunks = touching(scenes::TRUNKS_AT_FOREARM, "trunk", 4);
    let leaves = touching(scenes::LEAVES_AT_FOREARM, "leaf", 4);
    let folded = |leaves: &[(usize, Recording)]| -> FoldedReaches {
        trunks.iter().cloned().enumerate().map(|(place, own)| (place % 2, own)).chain(leaves.to_vec()).collect()
    };
    let in_one_fold = folded(&[(1, leaves[0].clone()), (1, leaves[1].clone())]);
    let found = transfer(&in_one_fold, &in_one_fold);
    assert_eq!((found.fitted_here, found.fitted_nominally, found.contacts), (None, None, 0));

    let in_both: Vec<(usize, Recording)> =
        leaves.iter().cloned().enumerate().map(|(place, own)| (place % 2, own)).collect();
    // One reach in each fold is too little to fit to.
    let found = transfer(&vec![(0, trunks[0].clone()), (1, leaves[0].clone())], &folded(&in_both));
    assert!(found.fitted_here.is_none() && found.fitted_nominally.is_some() && found.contacts >= 2, "{found:?}");

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
