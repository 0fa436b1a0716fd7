//! Track 1: what a contact is, by the number of samples since it began, with outliers that are unseen in training.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::RocCurve;

use super::contacts::{Class, Contact, JUDGED_MOMENTS};
use super::counts::{Balanced, Counts};
use super::frozen::{FOAM_ROLL, MOMENTS, WATER_BOTTLE};
use super::resampled::Estimate;

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// Contacts by what they are.
    pub contacts: ContactCounts,
    /// After each number of samples, and at the end of the contact.
    pub moments: Vec<VerdictsAt>,
}

/// How many contacts are judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ContactCounts {
    /// Readings without a touch.
    pub nothing: usize,
    /// With leaves.
    pub leaf: usize,
    /// With trunks.
    pub trunk: usize,
    /// With the foam roll.
    pub foam_roll: usize,
    /// With the water bottle.
    pub water_bottle: usize,
}

/// The figures at one moment of the contacts. A contact that is shorter counts with the last answer to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictsAt {
    /// Samples since the contact began; `None` at its end.
    pub samples: Option<usize>,
    /// Balanced accuracy over contacts with leaves and trunks, by which of the two is likelier.
    pub leaf_or_trunk: Estimate,
    /// The same with readings without a touch, by the likeliest of nothing, leaf and trunk.
    pub nothing_leaf_or_trunk: Estimate,
    /// Area under the ROC curve of contacts with the foam roll against those with leaves and trunks in the same scene.
    pub foam_roll_area: Estimate,
    /// The same for the water bottle.
    pub water_bottle_area: Estimate,
}

/// The figures of contacts by reach, each with the name of its scene.
pub(super) fn figures(reaches: &[(String, Vec<Contact>)]) -> Verdicts {
    let in_scene = |name: &str| -> Vec<&Vec<Contact>> {
        reaches
            .iter()
            .filter(|(scene, _)| scene == name)
            .map(|(_, contacts)| contacts)
            .collect()
    };
    let (rolls, bottles) = (in_scene(FOAM_ROLL), in_scene(WATER_BOTTLE));
    let others = |own: &[&Vec<Contact>]| {
        own.iter()
            .flat_map(|contacts| contacts.iter())
            .filter(|contact| contact.truth == Class::Other)
            .count()
    };
    let counts: Vec<Counts> = (reaches.iter())
        .map(|(_, contacts)| Counts::of(contacts, 0, Balanced::WithNothing))
        .collect();
    let [nothing, leaf, trunk] = Counts::contacts(&counts.iter().collect::<Vec<_>>());
    let at = |moment: usize| VerdictsAt {
        samples: MOMENTS.get(moment).copied(),
        leaf_or_trunk: accuracy(reaches, moment, Balanced::LeafOrTrunk),
        nothing_leaf_or_trunk: accuracy(reaches, moment, Balanced::WithNothing),
        foam_roll_area: area(&rolls, moment),
        water_bottle_area: area(&bottles, moment),
    };
    Verdicts {
        contacts: ContactCounts {
            nothing,
            leaf,
            trunk,
            foam_roll: others(&rolls),
            water_bottle: others(&bottles),
        },
        moments: (0..JUDGED_MOMENTS).map(at).collect(),
    }
}

/// A balanced accuracy over reaches.
fn accuracy(reaches: &[(String, Vec<Contact>)], moment: usize, balanced: Balanced) -> Estimate {
    let counts: Vec<Counts> = (reaches.iter())
        .map(|(_, contacts)| Counts::of(contacts, moment, balanced))
        .collect();
    Estimate::of(&counts, |own| Counts::balanced_accuracy(own, balanced))
}

/// How unlike the training data foreign objects are found, against leaves and trunks.
fn area(reaches: &[&Vec<Contact>], moment: usize) -> Estimate {
    let unlike = |contacts: &&Vec<Contact>| -> [Vec<f64>; 2] {
        let of = |wanted: fn(Class) -> bool| {
            let own = contacts.iter().filter(|contact| wanted(contact.truth));
            own.map(|contact| contact.moments[moment].answer.unlike).collect()
        };
        [
            of(|class| class == Class::Other),
            of(|class| matches!(class, Class::Leaf | Class::Trunk)),
        ]
    };
    let reaches: Vec<[Vec<f64>; 2]> = reaches.iter().map(unlike).collect();
    Estimate::of(&reaches, |own| {
        let [foreign, known] =
            [0, 1].map(|side| own.iter().flat_map(|reach| &reach[side]).copied().collect::<Vec<f64>>());
        RocCurve::of(&foreign, &known).map(|curve| curve.area)
    })
}
