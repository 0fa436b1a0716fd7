//! Labels of trials.

use super::*;

/// Tests the majority vote, that samples without an object do not vote, and that there is no category without votes.
#[test]
fn truth_is_the_object_of_most_samples() {
    let recording = recording(&[
        (0.0, &[(0, 1.0, None), (5, 1.0, None)]),
        (0.0, &[(0, 1.0, None)]),
        (0.0, &[(0, 1.0, Some(1))]),
        (0.0, &[(0, 1.0, Some(0))]),
        (0.0, &[(0, 1.0, Some(1))]),
    ]);
    let trials = taxel_trials(&recording, &any_force()).unwrap();
    assert_eq!((trials[0].object, trials[0].trial.category.as_deref()), (Some(1), Some("trunk")));
    assert_eq!((trials[1].object, &trials[1].trial.category), (None, &None));
}

/// Tests both kinds of label: by contact, a trial without an object has none; by environment, it has the only category
/// other than that of foam blocks. In mixed clutter both are the same.
#[test]
fn the_environment_labels_what_nothing_touched() {
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
    reach.objects[0].category = Category::BLOCK;
    assert_eq!(labels(&reach, Labels::Contact), [trunk.clone(), None]);
    assert_eq!(labels(&reach, Labels::Environment), [trunk.clone(), trunk]);
}

/// Tests that a trial stores in which samples an object truly pressed: on the taxel itself, or on any taxel of a
/// component. A sensed force without a true one (a spurious reading, creep) is untouched even if the environment labels
/// it. Without objects in the recording it is unknown.
#[test]
fn a_trial_knows_when_it_was_touched() {
    // Taxels 7 and 8 are neighbours; 12 is alone, and no object presses on it.
    let lit: &[(u16, f64, Option<u16>)] = &[(7, 1.0, Some(1)), (8, 0.5, None), (12, 0.2, None)];
    let mut reach = recording(&[(0.0, lit), (0.0, lit), (0.0, lit)]);
    reach.objects[0].category = Category::BLOCK;
    for (index, frame) in reach.frames.iter_mut().enumerate() {
        // Taxel 7 is pressed in frames 0 and 1, taxel 8 in frame 2, taxel 12 never.
        let pressed = if index < 2 { 7 } else { 8 };
        for reading in &mut frame.taxels {
            reading.true_normal_force_n = if reading.taxel == pressed { 0.004 } else { 0.0 };
        }
    }
    let options = TrialOptions { labels: Labels::Environment, ..any_force() };
    let touched = |trials: Vec<ContactTrial>| -> Vec<(u32, Vec<Option<bool>>, Option<bool>)> {
        let of = |contact: ContactTrial| {
            assert_eq!(contact.trial.category.as_deref(), Some("trunk"));
            let samples = contact.trial.samples.iter().map(|sample| sample.touched).collect();
            (contact.trial.taxel.unwrap(), samples, contact.trial.touched())
        };
        trials.into_iter().map(of).collect()
    };
    let [yes, no] = [Some(true), Some(false)];
    let by_taxel = vec![(7, vec![yes, yes, no], yes), (8, vec![no, no, yes], yes), (12, vec![no; 3], no)];
    assert_eq!(touched(taxel_trials(&reach, &options).unwrap()), by_taxel);
    let by_component = vec![(7, vec![yes; 3], yes), (12, vec![no; 3], no)];
    assert_eq!(touched(component_trials(&reach, &options).unwrap()), by_component);

    reach.objects.clear();
    reach.frames.iter_mut().for_each(|frame| {
        frame.taxels.iter_mut().for_each(|reading| reading.object = None);
    });
    let trials = taxel_trials(&reach, &any_force()).unwrap();
    let touched: Vec<Option<bool>> = trials.iter().map(|contact| contact.trial.touched()).collect();
    assert_eq!(touched, [None; 3]);
}
