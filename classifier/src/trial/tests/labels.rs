//! What a trial is told to be.

use super::*;

#[test]
fn truth_is_the_object_of_most_samples() {
    // Pins the majority vote, that samples without object have no vote, and no category without any.
    let recording = recording(&[
        (0.0, &[(0, 1.0, None), (5, 1.0, None)]),
        (0.0, &[(0, 1.0, None)]),
        (0.0, &[(0, 1.0, Some(1))]),
        (0.0, &[(0, 1.0, Some(0))]),
        (0.0, &[(0, 1.0, Some(1))]),
    ]);
    let trials = taxel_trials(&recording, &any_force()).unwrap();
    assert_eq!(
        (trials[0].object, trials[0].trial.category.as_deref()),
        (Some(1), Some("trunk"))
    );
    assert_eq!((trials[1].object, &trials[1].trial.category), (None, &None));
}

#[test]
fn the_environment_labels_what_nothing_touched() {
    // Pins labels: by contact a trial without an object has none; by environment it has that of the only category, foam
    // blocks aside; in mixed clutter both label alike.
    let touched: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1)), (9, 1.0, None)];
    let mut reach = recording(&[(0.0, touched), (0.0, touched)]);
    let labels = |reach: &Recording, labels| -> Vec<Option<String>> {
        let options = TrialOptions { labels, ..any_force() };
        let trials = taxel_trials(reach, &options).unwrap();
        trials.into_iter().map(|contact| contact.trial.category).collect()
    };
    let trunk = Some("trunk".to_owned());
    assert_eq!(labels(&reach, Labels::Contact), [trunk.clone(), None]);
    assert_eq!(labels(&reach, Labels::Environment), [trunk.clone(), None]);
    reach.objects[0].category = Category::Block;
    assert_eq!(labels(&reach, Labels::Contact), [trunk.clone(), None]);
    assert_eq!(labels(&reach, Labels::Environment), [trunk.clone(), trunk]);
}
