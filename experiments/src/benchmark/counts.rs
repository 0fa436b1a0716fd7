//! Numbers of right verdicts on objects, and of right answers about the taxels in contact, frame by frame; and the figures that
//! follow from them.

use std::ops::Range;

use super::frozen::THRESHOLD_N;
use super::objects::{Class, JudgedObject};

/// Mean over classes of the share of right answers, from their numbers and the numbers of all answers; `None` if there are
/// no answers to a class.
fn balanced(classes: &[[usize; 2]]) -> Option<f64> {
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
/// Leaves and trunks together, for the share of them that is called unknown.
pub(super) const CALLED_UNKNOWN: Range<usize> = 3..4;

/// Numbers of right verdicts and of objects, in a reach at one moment: for leaves, trunks and unknown objects. The last are the
/// numbers of leaves and trunks that are called unknown, and of all of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts([[usize; 2]; CALLED_UNKNOWN.end]);

impl Counts {
    pub(super) fn of(objects: &[JudgedObject], moment: usize) -> Self {
        let mut counts = Counts::default();
        for object in objects {
            let verdict = object.verdicts[moment];
            let Some(class) = CLASSES.iter().position(|class| *class == object.truth) else { continue };
            counts.0[class][0] += usize::from(verdict == object.truth);
            counts.0[class][1] += 1;
            let is_known = KNOWN.contains(&class);
            counts.0[CALLED_UNKNOWN.start][0] += usize::from(is_known && verdict == Class::Unknown);
            counts.0[CALLED_UNKNOWN.start][1] += usize::from(is_known);
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

    /// Numbers of leaves, trunks and unknown objects.
    pub(super) fn objects(all: &[&Counts]) -> [usize; ALL.end] {
        let [leaves, trunks, unknown, _] = Counts::sum(all).0.map(|[_, objects]| objects);
        [leaves, trunks, unknown]
    }

    /// Mean over these classes of the share that is called what it is; `None` if there is no object of a class. For
    /// [`CALLED_UNKNOWN`], it is that share.
    pub(super) fn accuracy(all: &[&Counts], classes: Range<usize>) -> Option<f64> {
        balanced(&Counts::sum(all).0[classes])
    }
}

/// Number of forces of which one is chosen.
const CANDIDATES: usize = 54;

/// The forces of which one is chosen, N: geometric from the threshold of contact, at which no reading counts as nothing, to 4.7 N.
const CANDIDATES_N: [f64; CANDIDATES] = {
    let mut forces_n = [THRESHOLD_N; CANDIDATES];
    let mut index = 1;
    while index < CANDIDATES {
        forces_n[index] = 1.1 * forces_n[index - 1];
        index += 1;
    }
    forces_n
};
/// What touches a taxel, in [`FrameCounts`].
const TOUCHING: [Class; 3] = [Class::Nothing, Class::Leaf, Class::Trunk];

/// Numbers of right answers and of taxel frames whose truth is nothing, leaf and trunk, by the number of candidates that the
/// sensed force is above.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameCounts([[[usize; 2]; TOUCHING.len()]; CANDIDATES + 1]);

impl Default for FrameCounts {
    fn default() -> Self {
        FrameCounts([[[0; 2]; TOUCHING.len()]; CANDIDATES + 1])
    }
}

/// The fitted class "nothing": the index of the largest force that counts as nothing. Models without this class get it: up to
/// some sensed force, a reading counts as nothing. The force is fitted to reaches of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FittedNothing(usize);

impl FittedNothing {
    /// The candidate with the largest balanced accuracy on some reaches, and the smallest force of those that are as good.
    /// `None` if the reaches lack a class.
    pub(super) fn fit(reaches: &[&FrameCounts]) -> Option<Self> {
        let accuracy = |index| Some((index, FrameCounts::accuracy(reaches, Some(FittedNothing(index)))?));
        let best = (0..CANDIDATES).filter_map(accuracy).reduce(|best, own| if own.1 > best.1 { own } else { best })?;
        Some(FittedNothing(best.0))
    }

    /// The largest force that counts as nothing, N.
    pub(super) fn up_to_n(self) -> f64 {
        CANDIDATES_N[self.0]
    }
}

impl FrameCounts {
    /// Takes in the answer about a taxel that senses this force. Frames in which something other than a leaf or a trunk
    /// presses are left out.
    pub(super) fn push(&mut self, force_n: f64, answer: Class, truth: Class) {
        let above = CANDIDATES_N.partition_point(|candidate_n| force_n > *candidate_n);
        if let Some(class) = TOUCHING.iter().position(|class| *class == truth) {
            self.0[above][class][0] += usize::from(answer == truth);
            self.0[above][class][1] += 1;
        }
    }

    /// The balanced accuracy over the taxel frames of some reaches; `None` if they lack a class.
    pub(super) fn accuracy(reaches: &[&FrameCounts], nothing: Option<FittedNothing>) -> Option<f64> {
        let mut sums = [[0; 2]; TOUCHING.len()];
        for (above, bins) in (0..=CANDIDATES).map(|above| (above, reaches.iter().map(move |own| &own.0[above]))) {
            let is_nothing = nothing.is_some_and(|own| above <= own.0);
            for (class, [right, all]) in bins.flat_map(|bin| bin.iter().enumerate()) {
                let is_right = if TOUCHING[class] == Class::Nothing { *all } else { 0 };
                sums[class][0] += if is_nothing { is_right } else { *right };
                sums[class][1] += all;
            }
        }
        balanced(&sums)
    }
}

#[cfg(test)]
mod tests {
    use super::super::objects::JUDGED_MOMENTS;
    use super::Class::{Leaf, Nothing, Trunk, Uncertain, Unknown};
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
        near(Counts::accuracy(&[&counts], CALLED_UNKNOWN), 0.25);
        assert_eq!(Counts::accuracy(&[&Counts::of(&objects[..3], 0)], KNOWN), None);
    }

    fn frame_counts(frames: &[(f64, Class, Class)]) -> FrameCounts {
        let mut counts = FrameCounts::default();
        frames.iter().for_each(|(force_n, answer, truth)| counts.push(*force_n, *answer, *truth));
        counts
    }

    /// Tests that the fitted force separates weak readings without a touch from touches, that it raises the accuracy of a model
    /// without the class "nothing" above two thirds, and that foreign objects are left out.
    #[test]
    fn the_fitted_force_separates_readings_from_touches() {
        let own = frame_counts(&[
            (0.04, Leaf, Nothing),
            (0.10, Leaf, Nothing),
            (0.30, Leaf, Leaf),
            (0.40, Trunk, Trunk),
            (0.05, Trunk, Unknown),
        ]);
        assert!((FrameCounts::accuracy(&[&own], None).unwrap() - 2.0 / 3.0).abs() < 1e-15);
        let fitted = FittedNothing::fit(&[&own]).unwrap();
        // The smallest of the forces 0.03 · 1.1ⁿ that is not below 0.1 N.
        assert!((fitted.up_to_n() - 0.03 * 1.1_f64.powi(13)).abs() < 1e-12, "{}", fitted.up_to_n());
        assert_eq!(FrameCounts::accuracy(&[&own], Some(fitted)), Some(1.0));
        assert_eq!(FittedNothing::fit(&[&frame_counts(&[(1.0, Leaf, Leaf)])]), None);
    }

    /// Tests that the accuracy of a model with a class "nothing" of its own counts its answers.
    #[test]
    fn own_answers_count() {
        let own = frame_counts(&[(0.1, Nothing, Nothing), (0.1, Leaf, Nothing), (0.1, Leaf, Leaf), (9.0, Leaf, Trunk)]);
        assert_eq!(FrameCounts::accuracy(&[&own], None), Some((0.5 + 1.0 + 0.0) / 3.0));
    }
}
