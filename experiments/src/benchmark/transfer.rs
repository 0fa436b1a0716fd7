//! Track 2: a model that was trained at one stiffness, speed, sensor and arm judges objects at another.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::mean;

use super::counts::{Counts, KNOWN};
use super::frozen::{OTHER_ARM, SETTINGS};
use crate::resampled::{Estimate, Ranking};

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    /// The settings; the first one is as in training.
    pub settings: Vec<TransferTo>,
}

/// How well the objects that touch the forearm at one setting are told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferTo {
    /// The setting.
    pub setting: String,
    /// Numbers of leaves and of trunks.
    pub objects: [usize; 2],
    /// Mean of the shares of leaves and of trunks that are called what they are at their end, by the model's own decision.
    pub leaf_or_trunk: Estimate,
    /// Difference of this accuracy from the one at the first setting. It has no value for the first setting itself.
    /// Reaches through the same clutter are resampled together.
    pub difference: Estimate,
}

/// The mean of this accuracy over some reaches.
fn accuracy(own: &[&Counts]) -> Option<f64> {
    Counts::accuracy(own, KNOWN)
}

/// The figures of the verdicts at the end of objects, which are given by setting and reach.
pub(super) fn figures(settings: &[Vec<Counts>]) -> Transfer {
    let setting = |(place, here): (usize, &Vec<Counts>)| {
        let name = SETTINGS[place].0;
        let [leaves, trunks, _] = Counts::objects(here);
        TransferTo {
            setting: name.to_owned(),
            objects: [leaves, trunks],
            leaf_or_trunk: Estimate::of(here, accuracy),
            difference: match &settings[0] {
                _ if place == 0 => Estimate::default(),
                // The clutter around the other arm is different, so reaches cannot be paired.
                usual if name == OTHER_ARM => {
                    Estimate::of_groups(&[usual, here], |groups| Some(accuracy(&groups[1])? - accuracy(&groups[0])?))
                }
                usual => {
                    let pairs: Vec<(&Counts, &Counts)> = usual.iter().zip(here).collect();
                    Estimate::of(&pairs, |own| {
                        let (usual, here): (Vec<&Counts>, Vec<&Counts>) = own.iter().copied().copied().unzip();
                        Some(accuracy(&here)? - accuracy(&usual)?)
                    })
                }
            },
        }
    };
    Transfer { settings: settings.iter().enumerate().map(setting).collect() }
}

/// The ranking by the mean accuracy over the settings other than that of the training. Reaches through the same clutter are
/// resampled together.
pub(super) fn ranking(halves: [&[Vec<Counts>]; 2]) -> Ranking {
    // Two groups: the settings with the same clutter, and the one with another arm. Each reach has its counts by setting.
    let groups = halves.map(|settings| {
        [true, false].map(|is_paired| {
            let own = settings.iter().zip(SETTINGS).skip(1).filter(|(_, (name, _))| (*name != OTHER_ARM) == is_paired);
            let own: Vec<&Vec<Counts>> = own.map(|(counts, _)| counts).collect();
            let reaches = own.first().map_or(0, |counts| counts.len());
            (0..reaches).map(|reach| own.iter().map(|counts| counts[reach]).collect()).collect::<Vec<Vec<Counts>>>()
        })
    });
    Ranking::of([&groups[0], &groups[1]], |groups| {
        let settings = groups.iter().flat_map(|reaches| {
            let count = reaches.first().map_or(0, |reach| reach.len());
            (0..count).map(|place| accuracy(&reaches.iter().map(|reach| &reach[place]).collect::<Vec<_>>()))
        });
        mean(settings.collect::<Option<Vec<f64>>>()?)
    })
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::touch::TouchVerdict;

    use super::super::objects::{JUDGED_MOMENTS, JudgedObject};
    use super::*;

    const LEAF: TouchVerdict = TouchVerdict::Category(0);
    const TRUNK: TouchVerdict = TouchVerdict::Category(1);

    /// Three reaches, in each of which a trunk and this many of four leaves are called what they are.
    fn reaches(right: usize) -> Vec<Counts> {
        let object = |truth, verdict| JudgedObject { truth, verdicts: [verdict; JUDGED_MOMENTS] };
        let mut objects = vec![object(TRUNK, TRUNK)];
        objects.extend((0..4).map(|leaf| object(LEAF, if leaf < right { LEAF } else { TRUNK })));
        vec![Counts::of(&objects, 0); 3]
    }

    /// Tests that the ranking is the mean over the six shifted settings, without that of the training, and that nothing is said
    /// about the difference of halves whose reaches are all alike.
    #[test]
    fn the_ranking_is_the_mean_over_shifted_settings() {
        let settings = [4, 0, 1, 2, 3, 4, 2].map(reaches);
        let ranking = ranking([&settings, &settings]);
        assert_eq!((ranking.audit.value, ranking.halves_differ()), (Some((12.0 / 24.0 + 1.0) / 2.0), None));
        let differences: Vec<Option<f64>> =
            figures(&settings).settings.iter().map(|own| own.difference.value).collect();
        assert_eq!(differences[..3], [None, Some(-0.5), Some(-0.375)]);
    }
}
