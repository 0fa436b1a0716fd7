//! Verdicts on single contacts of taxels, compared with ground truth.

use serde::Serialize;
use underbrush_recording::math;

use crate::frequency::largest;
use crate::stream_feature::SAMPLE_COUNTS;
use crate::touch::{TaxelTouch, TouchVerdict};

/// A contact of a taxel that something of a known category truly touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JudgedContact {
    /// The reach, from 0 in the order in which they were judged.
    pub reach: usize,
    /// Index of the true category.
    pub category: usize,
    /// The likeliest category at its end.
    pub at_end: usize,
    /// Whether the verdict that stood after each of [`SAMPLE_COUNTS`], and at last the one at its end, was right; of a shorter
    /// contact, the last one counts.
    pub right_after: [bool; SAMPLE_COUNTS.len() + 1],
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
    /// The verdict that stood after each of [`SAMPLE_COUNTS`], and the last one.
    standing: [TouchVerdict; SAMPLE_COUNTS.len() + 1],
}

impl OpenContact {
    pub(super) fn new(categories: usize) -> Self {
        OpenContact { votes: vec![0; categories + 1], evidence: vec![0.0; categories], ..OpenContact::default() }
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
        for (standing, count) in self.standing.iter_mut().zip(SAMPLE_COUNTS.into_iter().chain([usize::MAX])) {
            if self.samples <= count {
                *standing = taxel.touch;
            }
        }
    }

    /// The contact of a first reach, if a known category touched the taxel in most of the samples in which anything did.
    pub(super) fn close(self) -> Option<JudgedContact> {
        let (category, _) = largest(self.votes.into_iter().enumerate()).filter(|(_, votes)| *votes > 0)?;
        let right = TouchVerdict::Category(category);
        (category < self.evidence.len()).then(|| JudgedContact {
            reach: 0,
            category,
            at_end: self.likeliest,
            right_after: self.standing.map(|standing| standing == right),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that half of the standing verdicts are right if the verdicts alternate between right and wrong.
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
        assert_eq!(contacts[0].right_after[6..], [true; 4]);
        assert_eq!(contacts[1].right_after[6..], [false; 4]);
    }
}
