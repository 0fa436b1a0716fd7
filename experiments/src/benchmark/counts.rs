//! Numbers of right verdicts on objects, and of right answers about the taxels in contact, frame by frame; and the figures that
//! follow from them.

use std::array;
use std::ops::Range;

use underbrush_classifier::evaluate::{Tally, mean, share};
use underbrush_classifier::touch::TouchVerdict;

use super::frozen::THRESHOLD_N;
use super::objects::{CATEGORIES, JudgedObject};

/// Mean of the shares of right answers on several classes; `None` if there are no answers to a class.
fn balanced(shares: impl IntoIterator<Item = Option<f64>>) -> Option<f64> {
    mean(shares.into_iter().collect::<Option<Vec<f64>>>()?)
}

/// Leaves and trunks, in [`Counts::accuracy`].
pub(super) const KNOWN: Range<usize> = 1..3;
/// Unknown objects alone.
pub(super) const UNKNOWN: Range<usize> = 3..4;
/// All three classes.
pub(super) const ALL: Range<usize> = 1..4;

/// Verdicts on the objects of a reach at one moment, by what is true ([`TouchVerdict::row`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts([Tally; ALL.end]);

impl Counts {
    pub(super) fn of(objects: &[JudgedObject], moment: usize) -> Self {
        let mut counts = Counts::default();
        for JudgedObject { truth, verdicts } in objects {
            counts.0[truth.row(CATEGORIES.len())].add(verdicts[moment], verdicts[moment] == *truth, 1);
        }
        counts
    }

    fn sum<'a>(all: impl IntoIterator<Item = &'a Counts> + Clone) -> [Tally; ALL.end] {
        array::from_fn(|row| Tally::sum(all.clone().into_iter().map(|own| own.0[row])))
    }

    /// Numbers of leaves, trunks and unknown objects.
    pub(super) fn objects(all: &[Counts]) -> [usize; 3] {
        let [_, leaves, trunks, unknown] = Counts::sum(all).map(|own| own.total());
        [leaves, trunks, unknown]
    }

    /// Mean over these classes of the share that is called what it is; `None` if there is no object of a class.
    pub(super) fn accuracy(all: &[&Counts], classes: Range<usize>) -> Option<f64> {
        balanced(Counts::sum(all.iter().copied())[classes].iter().map(|own| own.share(own.right)))
    }

    /// Share of leaves and trunks that are called unknown; `None` if there are none.
    pub(super) fn known_called_unknown(all: &[&Counts]) -> Option<f64> {
        let known = Tally::sum(Counts::sum(all.iter().copied())[KNOWN].iter().copied());
        known.share(known.unknown)
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
/// Answers about taxel frames whose truth is nothing, leaf and trunk, by the number of candidates that the sensed force is above.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameCounts([[Tally; KNOWN.end]; CANDIDATES + 1]);

impl Default for FrameCounts {
    fn default() -> Self {
        FrameCounts([[Tally::default(); KNOWN.end]; CANDIDATES + 1])
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
    pub(super) fn push(&mut self, force_n: f64, answer: TouchVerdict, truth: TouchVerdict) {
        let above = CANDIDATES_N.partition_point(|candidate_n| force_n > *candidate_n);
        if let Some(tally) = self.0[above].get_mut(truth.row(CATEGORIES.len())) {
            tally.add(answer, answer == truth, 1);
        }
    }

    /// The balanced accuracy over the taxel frames of some reaches; `None` if they lack a class.
    pub(super) fn accuracy(reaches: &[&FrameCounts], nothing: Option<FittedNothing>) -> Option<f64> {
        let mut sums = [[0; 2]; KNOWN.end];
        for (above, bins) in (0..=CANDIDATES).map(|above| (above, reaches.iter().map(move |own| &own.0[above]))) {
            let is_nothing = nothing.is_some_and(|own| above <= own.0);
            for (row, own) in bins.flat_map(|bin| bin.iter().enumerate()) {
                let right_if_nothing = if row == 0 { own.total() } else { 0 };
                sums[row][0] += if is_nothing { right_if_nothing } else { own.right };
                sums[row][1] += own.total();
            }
        }
        balanced(sums.map(|[right, all]| share(right, all)))
    }
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::touch::TouchVerdict::{Nothing, Uncertain, Unknown};

    use super::super::objects::JUDGED_MOMENTS;
    use super::*;

    const LEAF: TouchVerdict = TouchVerdict::Category(0);
    const TRUNK: TouchVerdict = TouchVerdict::Category(1);

    /// Tests the figures of six objects against values counted by hand.
    #[test]
    fn figures_are_those_counted_by_hand() {
        let object = |truth, verdict| JudgedObject { truth, verdicts: [verdict; JUDGED_MOMENTS] };
        let objects = [
            object(LEAF, LEAF),
            object(LEAF, Unknown),
            object(LEAF, Uncertain),
            object(TRUNK, TRUNK),
            object(Unknown, Unknown),
            object(Unknown, TRUNK),
        ];
        let counts = Counts::of(&objects, 0);
        let near = |found: Option<f64>, expected: f64| assert!((found.unwrap() - expected).abs() < 1e-15, "{found:?}");
        near(Counts::accuracy(&[&counts], KNOWN), (1.0 / 3.0 + 1.0) / 2.0);
        near(Counts::accuracy(&[&counts], UNKNOWN), 0.5);
        near(Counts::accuracy(&[&counts, &counts], ALL), (1.0 / 3.0 + 1.0 + 0.5) / 3.0);
        near(Counts::known_called_unknown(&[&counts]), 0.25);
        assert_eq!(Counts::accuracy(&[&Counts::of(&objects[..3], 0)], KNOWN), None);
    }

    fn frame_counts(frames: &[(f64, TouchVerdict, TouchVerdict)]) -> FrameCounts {
        let mut counts = FrameCounts::default();
        frames.iter().for_each(|(force_n, answer, truth)| counts.push(*force_n, *answer, *truth));
        counts
    }

    /// Tests that the fitted force separates weak readings without a touch from touches, that it raises the accuracy of a model
    /// without the class "nothing" above two thirds, and that foreign objects are left out.
    #[test]
    fn the_fitted_force_separates_readings_from_touches() {
        let own = frame_counts(&[
            (0.04, LEAF, Nothing),
            (0.10, LEAF, Nothing),
            (0.30, LEAF, LEAF),
            (0.40, TRUNK, TRUNK),
            (0.05, TRUNK, Unknown),
        ]);
        assert!((FrameCounts::accuracy(&[&own], None).unwrap() - 2.0 / 3.0).abs() < 1e-15);
        let fitted = FittedNothing::fit(&[&own]).unwrap();
        // The smallest of the forces 0.03 · 1.1ⁿ that is not below 0.1 N.
        assert!((fitted.up_to_n() - 0.03 * 1.1_f64.powi(13)).abs() < 1e-12, "{}", fitted.up_to_n());
        assert_eq!(FrameCounts::accuracy(&[&own], Some(fitted)), Some(1.0));
        assert_eq!(FittedNothing::fit(&[&frame_counts(&[(1.0, LEAF, LEAF)])]), None);
    }

    /// Tests that the accuracy of a model with a class "nothing" of its own counts its answers.
    #[test]
    fn own_answers_count() {
        let own = frame_counts(&[(0.1, Nothing, Nothing), (0.1, LEAF, Nothing), (0.1, LEAF, LEAF), (9.0, LEAF, TRUNK)]);
        assert_eq!(FrameCounts::accuracy(&[&own], None), Some((0.5 + 1.0 + 0.0) / 3.0));
    }
}
