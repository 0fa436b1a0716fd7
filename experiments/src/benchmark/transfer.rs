//! Track 2: a model that was trained at one stiffness, speed, sensor and arm judges contacts at another.

use serde::{Deserialize, Serialize};

use super::contacts::{Contact, JUDGED_MOMENTS};
use super::counts::{Balanced, Counts};
use super::frozen::{OTHER_ARM, TRANSFER_SCENES};
use super::resampled::Estimate;

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    /// The scenes; the first one is as in training.
    pub settings: Vec<TransferTo>,
}

/// How contacts in one scene are told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferTo {
    /// The scene.
    pub scene: String,
    /// Contacts with leaves, and with trunks.
    pub contacts: [usize; 2],
    /// Balanced accuracy over contacts with leaves and trunks at their end, by which of the two is likelier.
    pub leaf_or_trunk: Estimate,
    /// How much it differs from that of the first scene; without value for that one.
    pub difference: Estimate,
}

/// The figures of contacts by reach, each with the name of its scene.
pub(super) fn figures(reaches: &[(String, Vec<Contact>)]) -> Transfer {
    let (at_end, balanced) = (JUDGED_MOMENTS - 1, Balanced::LeafOrTrunk);
    let counts_in = |name: &str| -> Vec<Counts> {
        let own = reaches.iter().filter(|(scene, _)| scene == name);
        own.map(|(_, contacts)| Counts::of(contacts, at_end, balanced))
            .collect()
    };
    let usual = counts_in(TRANSFER_SCENES[0]);
    let setting = |name: &&str| {
        let here = counts_in(name);
        let [_, leaf, trunk] = Counts::contacts(&here.iter().collect::<Vec<_>>());
        TransferTo {
            scene: (*name).to_owned(),
            contacts: [leaf, trunk],
            leaf_or_trunk: Estimate::of(&here, |own| Counts::balanced_accuracy(own, balanced)),
            difference: if *name == TRANSFER_SCENES[0] {
                Estimate::default()
            } else {
                Estimate::of_groups(&[&usual, &here], |groups| {
                    let [usual, here] = [0, 1].map(|group| Counts::balanced_accuracy(&groups[group], balanced));
                    Some(here? - usual?)
                })
            },
        }
    };
    Transfer {
        settings: TRANSFER_SCENES.iter().chain([&OTHER_ARM]).map(setting).collect(),
    }
}
