//! Areas under ROC curves, with each reach counted as often as a resample draws it.

/// Contacts in the order of their scores. Resamples differ only in how often they count each reach, so the contacts are
/// sorted once for all of them.
#[derive(Clone, Debug)]
pub(super) struct Ranked {
    /// Sorted from the highest score to the lowest.
    contacts: Vec<RankedContact>,
}

#[derive(Clone, Copy, Debug)]
struct RankedContact {
    score: f64,
    /// Index of the reach.
    reach: usize,
    is_positive: bool,
}

impl Ranked {
    /// The scores of positives and of negatives in each reach, which may be infinite. `None` if a score is NaN.
    pub(super) fn of(reaches: &[[Vec<f64>; 2]]) -> Option<Self> {
        let mut contacts = Vec::new();
        for (reach, sides) in reaches.iter().enumerate() {
            for (scores, is_positive) in sides.iter().zip([true, false]) {
                contacts.extend(scores.iter().map(|score| RankedContact { score: *score, reach, is_positive }));
            }
        }
        contacts.sort_unstable_by(|a, b| b.score.total_cmp(&a.score));
        let is_sound = contacts.iter().all(|contact| !contact.score.is_nan());
        is_sound.then_some(Ranked { contacts })
    }

    /// The probability that a positive scores higher than a negative, with ties counted half, if each reach counts as
    /// often as `times` says. `None` if there are no positives or no negatives among those that count.
    pub(super) fn area(&self, times: &[usize]) -> Option<f64> {
        // All sums are of whole numbers and halves, so they are exact.
        let (mut positives, mut negatives, mut area) = (0, 0, 0.0);
        // Equal scores, and 0 and −0, share one point of the curve.
        for tied in self.contacts.chunk_by(|a, b| a.score == b.score) {
            let mut counts = [0, 0];
            for contact in tied {
                counts[usize::from(contact.is_positive)] += times[contact.reach];
            }
            let [tied_negatives, tied_positives] = counts;
            area += tied_negatives as f64 * (2 * positives + tied_positives) as f64 / 2.0;
            positives += tied_positives;
            negatives += tied_negatives;
        }
        (positives > 0 && negatives > 0).then(|| area / positives as f64 / negatives as f64)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use underbrush_classifier::evaluate::RocCurve;

    use super::*;

    /// Tests that the area equals, bit for bit, the area under the curve of contacts that are repeated as often as
    /// their reach counts, with many ties, infinities and both zeros.
    #[test]
    fn areas_are_those_of_repeated_contacts() {
        const SCORES: [f64; 7] = [f64::NEG_INFINITY, -1.5, -0.0, 0.0, 1.0 / 3.0, 1.0, f64::INFINITY];
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut areas = 0;
        for _ in 0..2000 {
            let mut below = |end: usize| random.random_range(0..end as u64) as usize;
            let reaches = below(8);
            let mut side = || (0..below(4)).map(|_| SCORES[below(7)]).collect::<Vec<f64>>();
            let sides: Vec<[Vec<f64>; 2]> = (0..reaches).map(|_| [side(), side()]).collect();
            let times: Vec<usize> = (0..reaches).map(|_| below(4)).collect();
            let [positives, negatives] = [0, 1].map(|side| -> Vec<f64> {
                let repeated = sides.iter().zip(&times).map(|(own, times)| own[side].repeat(*times));
                repeated.flatten().collect()
            });
            let expected = RocCurve::of(&positives, &negatives).map(|curve| curve.area);
            assert_eq!(Ranked::of(&sides).unwrap().area(&times), expected, "{sides:?} {times:?}");
            areas += usize::from(expected.is_some());
        }
        assert!(areas > 1000, "{areas}");
    }

    /// Tests that a score that is not a number gives no area.
    #[test]
    fn scores_are_numbers() {
        assert!(Ranked::of(&[[vec![1.0], vec![f64::NAN]]]).is_none());
    }
}
