//! Components, and the regions that taxels belong to.

use super::*;

/// Tests 4-connectivity (no diagonals), wrap-around as the layout says, and the option that overrides it.
#[test]
fn components_wrap_around_only_where_asked() {
    let recording = recording(&[(0.0, &[(0, 1.0, Some(0)), (5, 2.0, Some(0)), (7, 3.0, Some(0)), (14, 4.0, None)])]);
    let largest = |wrap| -> Vec<f64> {
        let options = TrialOptions { wrap, ..any_force() };
        component_trials(&recording, &options).unwrap().iter().flat_map(forces).collect()
    };
    assert_eq!(largest(None), [2.0, 3.0, 4.0]);
    assert_eq!(largest(Some(false)), [1.0, 2.0, 3.0, 4.0]);
}

/// Tests force and motion of a component: taxels 7 and 8 (centre at column 1.5), then 7, 8 and 9 (centre at column 2)
/// with the patch moved by 1 mm.
#[test]
fn a_component_reports_its_largest_force_and_the_motion_of_its_centre() {
    let recording = recording(&[
        (0.000, &[(7, 0.5, None), (8, 0.9, None)]),
        (0.001, &[(7, 0.4, Some(1)), (8, 0.8, Some(1)), (9, 1.1, None)]),
    ]);
    let trials = component_trials(&recording, &any_force()).unwrap();
    assert_eq!(trials.len(), 1);
    assert_eq!(forces(&trials[0]), [0.9, 1.1]);
    assert_eq!(motions_mm(&trials[0]), [0.0, 6.0]);
    // The strongest taxel of the second frame touches nothing (crosstalk), so the truth comes from its neighbours.
    assert_eq!((trials[0].trial.taxel, trials[0].object), (Some(8), Some(1)));
}

/// Columns 0–1 and column 3.
const APART: Drawn = (0.0, &[(0, 1.0, Some(0)), (1, 1.0, Some(0)), (3, 2.0, Some(1))]);
/// Columns 0–3.
const TOGETHER: Drawn = (0.0, &[(0, 1.1, Some(0)), (1, 1.0, Some(0)), (2, 0.1, Some(0)), (3, 2.2, Some(1))]);

fn without_wrap(frames: &[Drawn]) -> Vec<ContactTrial> {
    let options = TrialOptions { wrap: Some(false), ..any_force() };
    component_trials(&recording(frames), &options).unwrap()
}

/// Tests merging: columns 0–1 and column 3 become 0–3 (centre 1.5). The first was 10 mm away, the second 15 mm.
#[test]
fn of_two_merging_components_the_nearer_goes_on() {
    let trials = without_wrap(&[APART, TOGETHER]);
    assert_eq!(trials.iter().map(forces).collect::<Vec<_>>(), [vec![1.0, 2.2], vec![2.0]]);
    assert_eq!(motions_mm(&trials[0]), [0.0, 10.0]);
}

/// Tests splitting: columns 0–3 (centre 1.5) become 0–1 (10 mm away) and 3 (15 mm away), which starts with zero motion.
#[test]
fn of_a_splitting_component_the_nearer_piece_goes_on() {
    let trials = without_wrap(&[TOGETHER, APART]);
    assert_eq!(trials.iter().map(forces).collect::<Vec<_>>(), [vec![2.2, 1.0], vec![2.0]]);
    assert_eq!(motions_mm(&trials[1]), [0.0]);
}

/// Tests association: when a patch slides 10 mm in x under a fixed contact, the contact moves by one column and stays
/// at rest in the world. If a contact jumps farther than allowed, its trial ends and a new one starts.
#[test]
fn tracking_is_greedy_by_world_distance() {
    let recording = recording(&[
        (0.00, &[(1, 1.0, Some(0)), (4, 5.0, Some(1))]),
        (-0.01, &[(2, 2.0, Some(0)), (5, 6.0, Some(1))]),
        (-0.01, &[(2, 3.0, Some(0))]),
        (-0.01, &[(17, 4.0, Some(0))]),
    ]);
    let options = TrialOptions { wrap: Some(false), ..any_force() };
    let trials = component_trials(&recording, &options).unwrap();
    let expected = [vec![1.0, 2.0, 3.0], vec![5.0, 6.0], vec![4.0]];
    assert_eq!(trials.iter().map(forces).collect::<Vec<_>>(), expected);
    assert_eq!(motions_mm(&trials[0]), [0.0; 3]);
}

/// Tests number of taxels, largest force and force sum of a taxel's region in each frame, in trials by taxel and by
/// component. In a grid with six columns, 1, 2 and 8 are connected and 11 is alone; then 2 loses contact and separates
/// 1 and 8.
#[test]
fn samples_know_their_contact_region() {
    let recording = recording(&[
        (0.0, &[(1, 0.5, Some(0)), (2, 0.25, None), (8, 1.0, Some(0)), (11, 2.0, Some(1))]),
        (0.0, &[(1, 0.5, Some(0)), (8, 0.75, Some(0)), (11, 2.0, Some(1))]),
    ]);
    let of = |contact: &ContactTrial| -> Vec<(u32, f64, f64)> {
        let regions = contact.trial.samples.iter().map(|sample| sample.region.unwrap());
        regions.map(|region| (region.taxels, region.largest_force_n, region.force_sum_n)).collect()
    };
    let options = TrialOptions { wrap: Some(false), ..any_force() };
    let taxels = taxel_trials(&recording, &options).unwrap();
    let joined = (3, 1.0, 1.75);
    let expected = [
        (Some(1), vec![joined, (1, 0.5, 0.5)]),
        (Some(2), vec![joined]),
        (Some(8), vec![joined, (1, 0.75, 0.75)]),
        (Some(11), vec![(1, 2.0, 2.0), (1, 2.0, 2.0)]),
    ];
    assert_eq!(taxels.iter().map(|contact| (contact.trial.taxel, of(contact))).collect::<Vec<_>>(), expected);
    let components = component_trials(&recording, &options).unwrap();
    assert_eq!(of(&components[0])[0], joined);
    assert!(components.iter().all(|contact| of(contact).len() == contact.trial.samples.len()));
    // Without a grid the neighbours are unknown.
    let mut loose = recording;
    loose.layout.patches[0].grid = None;
    let trials = taxel_trials(&loose, &options).unwrap();
    assert!(trials.iter().flat_map(|contact| &contact.trial.samples).all(|sample| sample.region.is_none()));
    // What the trials are made of follows from their regions.
    let unit =
        |contacts: Vec<ContactTrial>| Unit::of(&contacts.into_iter().map(|contact| contact.trial).collect::<Vec<_>>());
    assert_eq!([taxels, components, trials].map(unit), [Some(Unit::Taxel), Some(Unit::Component), None]);
}
