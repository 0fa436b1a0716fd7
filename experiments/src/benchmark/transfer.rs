//! Track 2: a model that was trained at one stiffness, speed, sensor and arm judges contacts at another.

use serde::{Deserialize, Serialize};

use super::contacts::{Balanced, Contact, Counts, JUDGED_MOMENTS};
use super::frozen::{OTHER_ARM, SETTINGS};
use crate::resampled::Estimate;

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    /// The settings; the first one is as in training.
    pub settings: Vec<TransferTo>,
}

/// How well contacts at one setting are told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferTo {
    /// The setting.
    pub setting: String,
    /// Number of contacts with leaves, and with trunks.
    pub contacts: [usize; 2],
    /// Balanced accuracy over contacts with leaves and trunks at their end, by which of the two is likelier.
    pub leaf_or_trunk: Estimate,
    /// Difference of this accuracy from the one at the first setting. It has no value for the first setting itself.
    /// Reaches through the same clutter are resampled together.
    pub difference: Estimate,
}

/// The figures of contacts, which are given by setting and reach.
pub(super) fn figures(settings: &[Vec<Vec<Contact>>]) -> Transfer {
    let balanced = Balanced::LeafOrTrunk;
    let counts = |reaches: &Vec<Vec<Contact>>| -> Vec<Counts> {
        let of_reach = |contacts: &Vec<Contact>| Counts::of(contacts, JUDGED_MOMENTS - 1, balanced);
        reaches.iter().map(of_reach).collect()
    };
    let counts: Vec<Vec<Counts>> = settings.iter().map(counts).collect();
    let setting = |(place, here): (usize, &Vec<Counts>)| {
        let name = SETTINGS[place].0;
        let [_, leaf, trunk] = Counts::contacts(&here.iter().collect::<Vec<_>>());
        TransferTo {
            setting: name.to_owned(),
            contacts: [leaf, trunk],
            leaf_or_trunk: Estimate::of(here, |own| Counts::balanced_accuracy(own, balanced)),
            difference: match &counts[0] {
                _ if place == 0 => Estimate::default(),
                // The clutter around the other arm is different, so reaches cannot be paired.
                usual if name == OTHER_ARM => Estimate::of_groups(&[usual, here], |groups| {
                    let [usual, here] = [0, 1].map(|group| Counts::balanced_accuracy(&groups[group], balanced));
                    Some(here? - usual?)
                }),
                usual => {
                    let pairs: Vec<(&Counts, &Counts)> = usual.iter().zip(here).collect();
                    Estimate::of(&pairs, |own| {
                        let (usual, here): (Vec<&Counts>, Vec<&Counts>) = own.iter().copied().copied().unzip();
                        Some(Counts::balanced_accuracy(&here, balanced)? - Counts::balanced_accuracy(&usual, balanced)?)
                    })
                }
            },
        }
    };
    Transfer { settings: counts.iter().enumerate().map(setting).collect() }
}
