//! Verdicts on single contacts of taxels, compared with ground truth.

use serde::Serialize;
use underbrush_recording::math;

use crate::frequency::largest;
use crate::stream_feature::SAMPLE_COUNTS;
use crate::touch::{TaxelTouch, TouchVerdict};

/// Samples in a tenth of a second, at 100 Hz.
const TENTH_SECOND_SAMPLES: usize = 10;

/// A contact of a taxel that something of a known category truly touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JudgedContact {
    /// The reach, from 0 in the order in which they were judged.
    pub reach: usize,
    /// Index of the true category.
    pub category: usize,
    /// The likeliest category at its end.
    pub at_end: usize,
    /// The likeliest category after ten samples, or at its end if it is shorter.
    pub after_tenth_second: usize,
    /// Whether the verdict that stood after each of [`SAMPLE_COUNTS`] was right; of a shorter contact, the last one counts.
    pub right_after: [bool; SAMPLE_COUNTS.len()],
    /// Whether the last verdict was right.
    pub right_at_end: bool,
    /// Samples until the first right verdict, which may not have stood; `None` if there was none.
    pub samples_until_right: Option<usize>,
}

/// A contact of a taxel that has not ended.
#[derive(Clone, Debug, Default)]
pub(super) struct OpenContact {
    samples: usize,
    /// Number of samples in which each known category touched the taxel, and then in which anything else did.
    votes: Vec<usize>,
    /// Sums of the log-probabilities of the categories, weighted by the probability of a touch.
    evidence: Vec<f64>,
    likeliest: usize,
    after_tenth_second: usize,
    /// The verdict that stood after each of [`SAMPLE_COUNTS`], and the last one.
    standing: [TouchVerdict; SAMPLE_COUNTS.len()],
    last: TouchVerdict,
    /// Samples until the first verdict of each category.
    first_verdicts: Vec<Option<usize>>,
}

impl OpenContact {
    pub(super) fn new(categories: usize) -> Self {
        let (votes, evidence) = (vec![0; categories + 1], vec![0.0; categories]);
        OpenContact { votes, evidence, first_verdicts: vec![None; categories], ..OpenContact::default() }
    }

    pub(super) fn push(&mut self, taxel: &TaxelTouch, probabilities: &[f64], truth: TouchVerdict) {
        self.samples = taxel.samples;
        match truth {
            TouchVerdict::Category(index) => self.votes[index] += 1,
            TouchVerdict::Unknown | TouchVerdict::Uncertain => *self.votes.last_mut().unwrap_or(&mut 0) += 1,
            TouchVerdict::Nothing => {}
        }
        for (sum, probability) in self.evidence.iter_mut().zip(probabilities) {
            *sum += (1.0 - taxel.nothing) * math::ln(probability.max(1e-6));
        }
        self.likeliest = largest(self.evidence.iter().copied().enumerate()).map_or(0, |(index, _)| index);
        if self.samples <= TENTH_SECOND_SAMPLES {
            self.after_tenth_second = self.likeliest;
        }
        self.last = taxel.touch;
        for (standing, count) in self.standing.iter_mut().zip(SAMPLE_COUNTS) {
            if self.samples <= count {
                *standing = taxel.touch;
            }
        }
        if let TouchVerdict::Category(index) = taxel.touch {
            self.first_verdicts[index].get_or_insert(self.samples);
        }
    }

    /// The contact of a first reach, if a known category touched the taxel in most of the samples in which anything did.
    pub(super) fn close(self) -> Option<JudgedContact> {
        let (category, _) = largest(self.votes.into_iter().enumerate()).filter(|(_, votes)| *votes > 0)?;
        let right = TouchVerdict::Category(category);
        (category < self.first_verdicts.len()).then(|| JudgedContact {
            reach: 0,
            category,
            at_end: self.likeliest,
            after_tenth_second: self.after_tenth_second,
            right_after: self.standing.map(|standing| standing == right),
            right_at_end: self.last == right,
            samples_until_right: self.first_verdicts[category],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that of verdicts that alternate between right and wrong, half are right: those that stand, not those that ever stood.
    #[test]
    fn alternating_verdicts_are_half_right() {
        let mut contacts = Vec::new();
        for first in 0..2 {
            let mut open = OpenContact::new(2);
            for samples in 1..=40 {
                let touch = TouchVerdict::Category((first + samples) % 2);
                let taxel = TaxelTouch { patch: 0, taxel: 7, samples, region: 0, nothing: 0.0, touch };
                open.push(&taxel, &[0.5, 0.5], TouchVerdict::Category(0));
            }
            contacts.push(open.close().unwrap());
        }
        for (index, count) in SAMPLE_COUNTS.into_iter().enumerate() {
            assert_eq!(contacts.iter().filter(|own| own.right_after[index]).count(), 1, "{count}");
        }
        // After 50 samples and more, the verdict on 40 samples stands.
        assert_eq!(contacts.iter().map(|own| own.right_at_end).collect::<Vec<_>>(), [true, false]);
        assert_eq!(contacts[0].right_after[6..], [true; 3]);
        assert!(contacts.iter().all(|own| own.samples_until_right.is_some()));
    }
}
