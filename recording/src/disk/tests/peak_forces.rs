use super::dataset::{make, recordings};

/// Tests that the list of largest contact forces has one entry per reach, in order, over several files, and 0 for the
/// reach without contacts.
#[test]
fn peak_forces_are_those_of_the_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(folder.path());
    let expected: Vec<f64> = recordings()
        .iter()
        .map(|recording| recording.contacts.iter().fold(0.0, |peak, contact| contact.peak_force_n.max(peak)))
        .collect();
    assert_eq!(expected.iter().filter(|peak| **peak == 0.0).count(), 1);
    let files = set.episodes().iter().map(|episode| (episode.chunk_index, episode.file_index));
    assert!(files.collect::<std::collections::BTreeSet<_>>().len() > 1, "one file would not test the order");
    assert_eq!(set.peak_contact_forces_n().unwrap(), expected);
}
