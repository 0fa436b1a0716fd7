//! How often answers are right, reach by reach.

use super::contacts::{Class, Contact, Pressing};
use super::frozen::MOMENTS;

/// The classes over which accuracies are balanced; the last two are those of [`Balanced::LeafOrTrunk`].
const CLASSES: [Class; 3] = [Class::Nothing, Class::Leaf, Class::Trunk];

/// Which accuracy is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Balanced {
    /// Contacts with leaves and trunks, by which of the two is likelier.
    LeafOrTrunk,
    /// Taxels that are still in contact, by the likeliest of all classes. The truth is what presses at that moment, or
    /// nothing.
    WithNothing,
}

/// Numbers of right answers and of contacts of each class in a reach, at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts([[usize; 2]; CLASSES.len()]);

impl Counts {
    pub(super) fn of(contacts: &[Contact], moment: usize, balanced: Balanced) -> Self {
        let mut counts = Counts::default();
        for contact in contacts {
            let own = contact.moments[moment];
            let (truth, right) = match balanced {
                Balanced::LeafOrTrunk => {
                    (contact.truth, own.while_pressed.trunk == Some(contact.truth == Class::Trunk))
                }
                Balanced::WithNothing => match own.pressing {
                    _ if MOMENTS.get(moment).is_none_or(|samples| contact.samples < *samples) => continue,
                    Pressing::Known(truth) => (truth, own.answer.likeliest == truth),
                    Pressing::Block => continue,
                },
            };
            let Some(class) = CLASSES.iter().position(|class| *class == truth) else {
                continue;
            };
            counts.0[class][0] += usize::from(right);
            counts.0[class][1] += 1;
        }
        counts
    }

    fn sum(all: &[&Counts]) -> Counts {
        let mut sum = Counts::default();
        for own in all {
            for (sum, own) in sum.0.iter_mut().flatten().zip(own.0.iter().flatten()) {
                *sum += own;
            }
        }
        sum
    }

    /// Number of contacts of each class: nothing, leaf, trunk.
    pub(super) fn contacts(all: &[&Counts]) -> [usize; CLASSES.len()] {
        Counts::sum(all).0.map(|[_, contacts]| contacts)
    }

    /// Mean over the classes of the share of right answers; `None` if a class has no contact.
    pub(super) fn balanced_accuracy(all: &[&Counts], balanced: Balanced) -> Option<f64> {
        let classes = match balanced {
            Balanced::LeafOrTrunk => 1..CLASSES.len(),
            Balanced::WithNothing => 0..CLASSES.len(),
        };
        let count = classes.len() as f64;
        let sum = Counts::sum(all);
        let shares = sum.0[classes].iter().map(|[right, contacts]| *right as f64 / *contacts as f64);
        let mean = shares.sum::<f64>() / count;
        mean.is_finite().then_some(mean)
    }
}

#[cfg(test)]
mod tests {
    use super::super::contacts::{Answer, JUDGED_MOMENTS, Moment};
    use super::*;

    fn contact(truth: Class, pressing: Class, likeliest: Class, trunk: Option<bool>) -> Contact {
        let answer = Answer { likeliest, trunk, unlike: 0.0 };
        let moment = Moment { answer, while_pressed: answer, pressing: Pressing::Known(pressing) };
        Contact { truth, samples: 1, moments: [moment; JUDGED_MOMENTS] }
    }

    /// Tests both accuracies of seven contacts against values counted by hand.
    #[test]
    fn accuracies_are_those_counted_by_hand() {
        use Class::{Leaf, Nothing, Other, Trunk};
        let contacts = [
            contact(Nothing, Nothing, Nothing, Some(true)),
            contact(Nothing, Nothing, Leaf, None),
            contact(Leaf, Leaf, Leaf, Some(false)),
            // The touch is over, but the taxel still reads a force.
            contact(Leaf, Nothing, Nothing, Some(false)),
            contact(Leaf, Leaf, Trunk, Some(true)),
            contact(Trunk, Trunk, Trunk, None),
            contact(Other, Other, Trunk, Some(true)),
        ];
        for (balanced, accuracy) in [
            // Two of three leaves; the trunk is tied, which is not right.
            (Balanced::LeafOrTrunk, (2.0 / 3.0 + 0.0) / 2.0),
            // Two of three moments without a touch, one of two with a leaf, and the one with the trunk.
            (Balanced::WithNothing, (2.0 / 3.0 + 1.0 / 2.0 + 1.0) / 3.0),
        ] {
            let counts = Counts::of(&contacts, 0, balanced);
            let found = Counts::balanced_accuracy(&[&counts], balanced).unwrap();
            assert!((found - accuracy).abs() < 1e-15, "{balanced:?}: {found}");
        }
        // None of the contacts lasts for the two samples of the next moment.
        let later = Counts::of(&contacts, 1, Balanced::WithNothing);
        assert_eq!(Counts::balanced_accuracy(&[&later], Balanced::WithNothing), None);
        let without_trunks = Counts::of(&contacts[..5], 0, Balanced::LeafOrTrunk);
        assert_eq!(Counts::balanced_accuracy(&[&without_trunks], Balanced::LeafOrTrunk), None);
    }
}
