//! Verdicts on single contacts of taxels, compared with ground truth.

use serde::Serialize;

use crate::frequency::largest;
use crate::touch::{TaxelTouch, TouchVerdict};
use underbrush_recording::math;

/// Samples in a tenth of a second, at 100 Hz.
const TENTH_SECOND_SAMPLES: usize = 10;

/// A contact of a taxel that something of a known category truly touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JudgedContact {
    /// Index of the true category.
    pub category: usize,
    /// The likeliest category at its end.
    pub at_end: usize,
    /// The likeliest category after ten samples, or at its end if it is shorter.
    pub after_tenth_second: usize,
    /// Samples until the first right verdict; `None` if there was none.
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
        if let TouchVerdict::Category(index) = taxel.touch {
            self.first_verdicts[index].get_or_insert(self.samples);
        }
    }

    /// The contact, if a known category touched the taxel in most of the samples in which anything did.
    pub(super) fn close(self) -> Option<JudgedContact> {
        let (category, _) = largest(self.votes.into_iter().enumerate()).filter(|(_, votes)| *votes > 0)?;
        (category < self.first_verdicts.len()).then(|| JudgedContact {
            category,
            at_end: self.likeliest,
            after_tenth_second: self.after_tenth_second,
            samples_until_right: self.first_verdicts[category],
        })
    }
}
