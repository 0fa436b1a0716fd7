//! Contacts of taxels, with what a model says about them.

use underbrush_recording::Category;

use super::frozen::MOMENTS;

/// Number of moments at which a contact is judged: [`MOMENTS`] and its end.
pub(super) const JUDGED_MOMENTS: usize = MOMENTS.len() + 1;

/// What a contact is, or is said to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    /// A reading without a touch.
    Nothing,
    /// A leaf.
    Leaf,
    /// A trunk.
    Trunk,
    /// Anything else. As the truth this is an object foreign to the foliage; as an answer it is another category of the
    /// model.
    Other,
}

/// What a model says about a taxel in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Answer {
    /// The likeliest of all classes that the model knows.
    pub(super) likeliest: Class,
    /// Whether a trunk is likelier than a leaf; `None` if they are equally likely, or the model gives no answer.
    pub(super) trunk: Option<bool>,
    /// How unlike the training data the contact is; larger values are more unlike.
    pub(super) unlike: f64,
}

/// The answer of a model that does not judge a taxel in contact, because it has another threshold.
pub(super) const SILENCE: Answer = Answer { likeliest: Class::Nothing, trunk: None, unlike: f64::NEG_INFINITY };

/// A contact and the answers to it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Contact {
    /// What truly pressed most often, counted over the frames in which anything did.
    pub(super) truth: Class,
    /// Number of samples from its beginning to its end.
    pub(super) samples: usize,
    /// The frames after each of [`MOMENTS`] (the last frame if the contact is shorter), and the last frame.
    pub(super) moments: [Moment; JUDGED_MOMENTS],
}

/// A frame of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Moment {
    /// What the model says in this frame.
    pub(super) answer: Answer,
    /// What the model said in the latest frame in which something pressed. If nothing has pressed yet, this is what the
    /// model says in this frame. A taxel still senses a force for a while after a touch, and what a model says then is
    /// no answer about the object.
    pub(super) while_pressed: Answer,
    /// What truly presses in this frame.
    pub(super) pressing: Pressing,
}

/// What presses on a taxel in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pressing {
    /// Nothing, or an object of this class.
    Known(Class),
    /// A foam block, which belongs to the environment.
    Block,
}

/// A contact that has not ended.
#[derive(Clone, Debug)]
pub(super) struct OpenContact {
    samples: usize,
    moments: [Moment; JUDGED_MOMENTS],
    while_pressed: Option<Answer>,
    /// Numbers of frames in which a leaf, a trunk, a foam block and anything else pressed.
    pressed: [usize; 4],
}

impl Default for OpenContact {
    fn default() -> Self {
        let moment = Moment { answer: SILENCE, while_pressed: SILENCE, pressing: Pressing::Known(Class::Nothing) };
        OpenContact { samples: 0, moments: [moment; JUDGED_MOMENTS], while_pressed: None, pressed: [0; 4] }
    }
}

impl OpenContact {
    pub(super) fn push(&mut self, answer: Answer, pressing: Option<Category>) {
        let (class, place) = match pressing {
            None => (Pressing::Known(Class::Nothing), None),
            Some(Category::LEAF) => (Pressing::Known(Class::Leaf), Some(0)),
            Some(Category::TRUNK) => (Pressing::Known(Class::Trunk), Some(1)),
            Some(Category::BLOCK) => (Pressing::Block, Some(2)),
            Some(_) => (Pressing::Known(Class::Other), Some(3)),
        };
        if place.is_some() {
            self.while_pressed = Some(answer);
        }
        self.samples += 1;
        for (own, last) in self.moments.iter_mut().zip(MOMENTS.into_iter().chain([usize::MAX])) {
            if self.samples <= last {
                *own = Moment { answer, while_pressed: self.while_pressed.unwrap_or(answer), pressing: class };
            }
        }
        if let Some(place) = place {
            self.pressed[place] += 1;
        }
    }

    /// The contact; `None` if a foam block pressed most often.
    pub(super) fn close(self) -> Option<Contact> {
        let most = self.pressed.into_iter().max().filter(|most| *most > 0);
        let truth = match most.and_then(|most| self.pressed.iter().position(|count| *count == most)) {
            None => Class::Nothing,
            Some(0) => Class::Leaf,
            Some(1) => Class::Trunk,
            Some(2) => return None,
            Some(_) => Class::Other,
        };
        Some(Contact { truth, samples: self.samples, moments: self.moments })
    }
}

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
