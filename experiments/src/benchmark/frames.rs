//! Taxels in contact, frame by frame: nothing, leaf or trunk.
//!
//! Models without the class "nothing" get one: up to some sensed force, a reading counts as nothing. The force is fitted to
//! reaches of its own.

use super::counts::balanced;
use super::frozen::THRESHOLD_N;
use super::objects::Class;

/// Number of forces of which one is chosen.
const CANDIDATES: usize = 54;

/// These forces, N: geometric from the threshold of contact, at which no reading counts as nothing, to 4.7 N.
const CANDIDATES_N: [f64; CANDIDATES] = {
    let mut forces_n = [THRESHOLD_N; CANDIDATES];
    let mut index = 1;
    while index < CANDIDATES {
        forces_n[index] = 1.1 * forces_n[index - 1];
        index += 1;
    }
    forces_n
};
const CLASSES: [Class; 3] = [Class::Nothing, Class::Leaf, Class::Trunk];

/// Numbers of right answers and of taxel frames whose truth is nothing, leaf and trunk, by the number of candidates that the
/// sensed force is above.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameCounts([[[usize; 2]; CLASSES.len()]; CANDIDATES + 1]);

impl Default for FrameCounts {
    fn default() -> Self {
        FrameCounts([[[0; 2]; CLASSES.len()]; CANDIDATES + 1])
    }
}

/// The fitted class "nothing": the index of the largest force that counts as nothing.
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
        if let Some(class) = CLASSES.iter().position(|class| *class == truth) {
            self.0[above][class][0] += usize::from(answer == truth);
            self.0[above][class][1] += 1;
        }
    }

    /// The balanced accuracy over the taxel frames of some reaches; `None` if they lack a class.
    pub(super) fn accuracy(reaches: &[&FrameCounts], nothing: Option<FittedNothing>) -> Option<f64> {
        let mut sums = [[0; 2]; CLASSES.len()];
        for (above, bins) in (0..=CANDIDATES).map(|above| (above, reaches.iter().map(move |own| &own.0[above]))) {
            let is_nothing = nothing.is_some_and(|own| above <= own.0);
            for (class, [right, all]) in bins.flat_map(|bin| bin.iter().enumerate()) {
                let is_right = if CLASSES[class] == Class::Nothing { *all } else { 0 };
                sums[class][0] += if is_nothing { is_right } else { *right };
                sums[class][1] += all;
            }
        }
        balanced(&sums)
    }
}

#[cfg(test)]
mod tests {
    use super::Class::{Leaf, Nothing, Trunk, Unknown};
    use super::*;

    fn counts(frames: &[(f64, Class, Class)]) -> FrameCounts {
        let mut counts = FrameCounts::default();
        frames.iter().for_each(|(force_n, answer, truth)| counts.push(*force_n, *answer, *truth));
        counts
    }

    /// Tests that the fitted force separates weak readings without a touch from touches, that it raises the accuracy of a model
    /// without the class "nothing" above two thirds, and that foreign objects are left out.
    #[test]
    fn the_fitted_force_separates_readings_from_touches() {
        let own = counts(&[
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
        assert_eq!(FittedNothing::fit(&[&counts(&[(1.0, Leaf, Leaf)])]), None);
    }

    /// Tests that the accuracy of a model with a class "nothing" of its own counts its answers.
    #[test]
    fn own_answers_count() {
        let own = counts(&[(0.1, Nothing, Nothing), (0.1, Leaf, Nothing), (0.1, Leaf, Leaf), (9.0, Leaf, Trunk)]);
        assert_eq!(FrameCounts::accuracy(&[&own], None), Some((0.5 + 1.0 + 0.0) / 3.0));
    }
}
