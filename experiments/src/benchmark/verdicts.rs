//! Track 1: what a contact is, by the number of samples since it began, with outliers that are unseen in training.

use serde::{Deserialize, Serialize};

use super::contacts::{Balanced, Class, Contact, Counts, JUDGED_MOMENTS};
use super::frozen::{FOAM_ROLL, MOMENTS, WATER_BOTTLE};
use super::ranked::Ranked;
use crate::resampled::Estimate;

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// Numbers of contacts by what was touched.
    pub contacts: ContactCounts,
    /// After each number of samples, and at the end of the contact.
    pub moments: Vec<VerdictsAt>,
}

/// How many contacts are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ContactCounts {
    /// Contacts in which nothing ever pressed.
    pub nothing: usize,
    /// Contacts with leaves.
    pub leaf: usize,
    /// Contacts with trunks.
    pub trunk: usize,
    /// Contacts with the foam roll.
    pub foam_roll: usize,
    /// Contacts with the water bottle.
    pub water_bottle: usize,
}

/// The figures at one moment of the contacts. A contact that ended earlier counts with the last answer to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictsAt {
    /// Samples since the contact began; `None` at its end.
    pub samples: Option<usize>,
    /// Balanced accuracy over contacts with leaves and trunks, by which of the two is likelier.
    pub leaf_or_trunk: Estimate,
    /// Balanced accuracy over the taxels that are still in contact, by the likeliest of nothing, leaf and trunk,
    /// against what presses at that moment. There is no value at the end of contacts, when as a rule nothing presses.
    pub nothing_leaf_or_trunk: Estimate,
    /// Area under the ROC curve of contacts with the foam roll against those with leaves and trunks in all scenes.
    pub foam_roll_area: Estimate,
    /// Area under the ROC curve of contacts with the water bottle against those with leaves and trunks in all scenes.
    pub water_bottle_area: Estimate,
}

/// The figures of contacts, which are given by reach with the name of its scene.
pub(super) fn figures(reaches: &[(String, Vec<Contact>)]) -> Verdicts {
    let in_scene = |name: &str| -> Vec<&Vec<Contact>> {
        reaches.iter().filter(|(scene, _)| scene == name).map(|(_, contacts)| contacts).collect()
    };
    let (rolls, bottles) = (in_scene(FOAM_ROLL), in_scene(WATER_BOTTLE));
    let all: Vec<&Vec<Contact>> = reaches.iter().map(|(_, contacts)| contacts).collect();
    let count = |own: &[&Vec<Contact>], class: Class| {
        let contacts = own.iter().flat_map(|contacts| contacts.iter());
        contacts.filter(|contact| contact.truth == class).count()
    };
    let at = |moment: usize| VerdictsAt {
        samples: MOMENTS.get(moment).copied(),
        leaf_or_trunk: accuracy(reaches, moment, Balanced::LeafOrTrunk),
        nothing_leaf_or_trunk: accuracy(reaches, moment, Balanced::WithNothing),
        foam_roll_area: area(reaches, FOAM_ROLL, moment),
        water_bottle_area: area(reaches, WATER_BOTTLE, moment),
    };
    Verdicts {
        contacts: ContactCounts {
            nothing: count(&all, Class::Nothing),
            leaf: count(&all, Class::Leaf),
            trunk: count(&all, Class::Trunk),
            foam_roll: count(&rolls, Class::Other),
            water_bottle: count(&bottles, Class::Other),
        },
        moments: (0..JUDGED_MOMENTS).map(at).collect(),
    }
}

/// A balanced accuracy over reaches.
fn accuracy(reaches: &[(String, Vec<Contact>)], moment: usize, balanced: Balanced) -> Estimate {
    let counts: Vec<Counts> = (reaches.iter()).map(|(_, contacts)| Counts::of(contacts, moment, balanced)).collect();
    Estimate::of(&counts, |own| Counts::balanced_accuracy(own, balanced))
}

/// How well the foreign objects of a scene are told apart from leaves and trunks in all scenes, by how unlike the
/// training data the model finds them.
fn area(reaches: &[(String, Vec<Contact>)], scene: &str, moment: usize) -> Estimate {
    let unlike = |(own, contacts): &(String, Vec<Contact>)| -> [Vec<f64>; 2] {
        let of = |is_wanted: &dyn Fn(Class) -> bool| {
            let wanted = contacts.iter().filter(|contact| is_wanted(contact.truth));
            wanted.map(|contact| contact.moments[moment].while_pressed.unlike).collect()
        };
        [of(&|class| own == scene && class == Class::Other), of(&|class| matches!(class, Class::Leaf | Class::Trunk))]
    };
    let reaches: Vec<[Vec<f64>; 2]> = reaches.iter().map(unlike).collect();
    Ranked::of(&reaches)
        .map_or_else(Estimate::default, |ranked| Estimate::of_times(reaches.len(), |times| ranked.area(times)))
}
