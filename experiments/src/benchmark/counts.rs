//! Numbers of right verdicts, and the figures that follow from them.

use std::ops::Range;

use super::objects::{Class, JudgedObject};

/// Mean over classes of the share of right answers, from their numbers and the numbers of all answers; `None` if there are
/// no answers to a class.
pub(super) fn balanced(classes: &[[usize; 2]]) -> Option<f64> {
    let shares = classes.iter().map(|[right, all]| *right as f64 / *all as f64);
    Some(shares.sum::<f64>() / classes.len() as f64).filter(|mean| mean.is_finite())
}

/// Leaves and trunks, in [`Counts::accuracy`].
pub(super) const KNOWN: Range<usize> = 0..2;
/// Unknown objects alone.
pub(super) const UNKNOWN: Range<usize> = 2..3;
/// All three classes.
pub(super) const ALL: Range<usize> = 0..3;
const CLASSES: [Class; ALL.end] = [Class::Leaf, Class::Trunk, Class::Unknown];

/// Numbers of right verdicts and of objects, in a reach at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// For leaves, trunks and unknown objects.
    classes: [[usize; 2]; ALL.end],
    /// Leaves and trunks that are called unknown.
    called_unknown: usize,
}

impl Counts {
    pub(super) fn of(objects: &[JudgedObject], moment: usize) -> Self {
        let mut counts = Counts::default();
        for object in objects {
            let verdict = object.verdicts[moment];
            let Some(class) = CLASSES.iter().position(|class| *class == object.truth) else { continue };
            counts.classes[class][0] += usize::from(verdict == object.truth);
            counts.classes[class][1] += 1;
            counts.called_unknown += usize::from(verdict == Class::Unknown && object.truth != Class::Unknown);
        }
        counts
    }

    fn sum(all: &[&Counts]) -> Counts {
        let mut sum = Counts::default();
        for own in all {
            for (sum, own) in sum.classes.iter_mut().flatten().zip(own.classes.iter().flatten()) {
                *sum += own;
            }
            sum.called_unknown += own.called_unknown;
        }
        sum
    }

    /// Numbers of leaves, trunks and unknown objects.
    pub(super) fn objects(all: &[&Counts]) -> [usize; ALL.end] {
        Counts::sum(all).classes.map(|[_, objects]| objects)
    }

    /// Mean over these classes of the share that is called what it is; `None` if there is no object of a class.
    pub(super) fn accuracy(all: &[&Counts], classes: Range<usize>) -> Option<f64> {
        balanced(&Counts::sum(all).classes[classes])
    }

    /// The share of leaves and trunks that are called unknown.
    pub(super) fn false_alarms(all: &[&Counts]) -> Option<f64> {
        let sum = Counts::sum(all);
        balanced(&[[sum.called_unknown, sum.classes[KNOWN].iter().map(|[_, objects]| objects).sum()]])
    }
}

#[cfg(test)]
mod tests {
    use super::super::objects::JUDGED_MOMENTS;
    use super::Class::{Leaf, Trunk, Uncertain, Unknown};
    use super::*;

    /// Tests the figures of six objects against values counted by hand.
    #[test]
    fn figures_are_those_counted_by_hand() {
        let object = |truth, verdict| JudgedObject { truth, verdicts: [verdict; JUDGED_MOMENTS] };
        let objects = [
            object(Leaf, Leaf),
            object(Leaf, Unknown),
            object(Leaf, Uncertain),
            object(Trunk, Trunk),
            object(Unknown, Unknown),
            object(Unknown, Trunk),
        ];
        let counts = Counts::of(&objects, 0);
        let near = |found: Option<f64>, expected: f64| assert!((found.unwrap() - expected).abs() < 1e-15, "{found:?}");
        near(Counts::accuracy(&[&counts], KNOWN), (1.0 / 3.0 + 1.0) / 2.0);
        near(Counts::accuracy(&[&counts], UNKNOWN), 0.5);
        near(Counts::accuracy(&[&counts, &counts], ALL), (1.0 / 3.0 + 1.0 + 0.5) / 3.0);
        near(Counts::false_alarms(&[&counts]), 0.25);
        assert_eq!(Counts::accuracy(&[&Counts::of(&objects[..3], 0)], KNOWN), None);
    }
}
