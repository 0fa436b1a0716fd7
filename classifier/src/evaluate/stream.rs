//! Online classification of a recorded reach against its ground truth, frame by frame (paper, Figs. 8 to 11 and 15).

use serde::Serialize;
use underbrush_recording::Category;

use super::prediction::is_right;
use super::tally::{Tally, mean};
use crate::decision::Verdict;
use crate::touch::TouchVerdict;

mod judge;

pub use judge::{classify_stream, classify_touch_stream};

/// The name of the verdict that nothing presses on a taxel. Only touch models give it.
pub const NOTHING: &str = "nothing";

/// What counts as the truth for a taxel's verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamTruth {
    /// The object that presses hardest on the taxel in this frame. An untouched taxel (crosstalk, creep) has no
    /// truth.
    Object,
    /// The single category of the environment, whatever presses, as in the paper's engineered reaches (section V-B).
    Environment(Category),
}

/// One frame of a reach.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StreamFrame {
    /// Time since the start of the reach, s.
    pub time_s: f64,
    /// Number of taxels in contact.
    pub in_contact: usize,
    /// The taxels in contact whose truth is known.
    pub tally: Tally,
    /// The taxels in contact, by verdict, in the order of [`Stream::verdicts`].
    pub by_verdict: Vec<usize>,
    /// Whether an object of each of [`Stream::truths`] truly presses on a judged patch.
    pub touched: Vec<bool>,
    /// Mean number of samples used (Fig. 9) over the taxels in contact: how many samples of its contact had arrived
    /// when a taxel's current verdict was first given, or 0 while it is uncertain. 0 without contact.
    pub mean_samples_used: f64,
    /// Mean number of samples since contact over the taxels in contact. 0 without contact.
    pub mean_samples_since_contact: f64,
}

impl StreamFrame {
    /// Number of taxels in contact without truth.
    pub fn without_truth(&self) -> usize {
        self.in_contact - self.tally.total()
    }
}

/// One contact of a taxel with something, from the samples that were classified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamContact {
    /// The truth of the first sample that has one. Contacts that never have one are left out.
    pub truth: Category,
    /// The number of samples that had arrived when the verdict was right for the first time; `None` if it never was.
    pub first_right: Option<usize>,
}

/// A reach classified online.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stream {
    /// The categories that an object of the recording can have: [`Category::BUILT_IN`], then further ones that occur.
    pub truths: Vec<Category>,
    /// Names of the verdicts: the classifier's categories in alphabetical order, uncertain, outlier; with a touch model
    /// also [`NOTHING`].
    pub verdicts: Vec<String>,
    /// The frames.
    pub frames: Vec<StreamFrame>,
    /// Taxels in contact, summed over all frames, by truth ([`Stream::truths`], then without truth) and verdict.
    pub taxel_frames: Vec<Vec<usize>>,
    /// Contacts with ground truth, in the order in which they first had it.
    pub contacts: Vec<StreamContact>,
    /// Wall time of the classifier for each frame, s; of a touch model also that of comparing its objects with the truth. This is
    /// the only field that depends on the machine.
    pub seconds: Vec<f64>,
}

impl Stream {
    /// The categories of the classifier.
    fn categories(&self) -> &[String] {
        let known = self.verdicts.iter().take_while(|name| *name != Verdict::Uncertain.name()).count();
        &self.verdicts[..known]
    }

    /// The taxels in contact with objects of this category, or without truth, summed over all frames. Only nothing is a right
    /// verdict without truth.
    pub fn tally_of(&self, truth: Option<Category>) -> Tally {
        let mut tally = Tally::default();
        let row = match truth {
            Some(truth) => self.truths.iter().position(|other| *other == truth),
            None => Some(self.truths.len()),
        };
        let counts = row.and_then(|row| self.taxel_frames.get(row));
        for (verdict, count) in counts.into_iter().flatten().enumerate() {
            self.count(&mut tally, truth, verdict, *count);
        }
        tally
    }

    /// The taxels in contact whose truth is known, summed over all frames.
    pub fn total(&self) -> Tally {
        Tally::sum(self.truths.iter().map(|truth| self.tally_of(Some(*truth))))
    }

    /// Counts taxels with this truth and index of a verdict, and says whether it is right, by the same rule as for whole trials
    /// ([`super::Record::is_right`]).
    fn count(&self, tally: &mut Tally, truth: Option<Category>, verdict: usize, count: usize) -> bool {
        let categories = self.categories();
        let named = TouchVerdict::named(&self.verdicts[verdict], categories);
        let is_right = match truth {
            Some(truth) => is_right(truth.name(), verdict, categories),
            None => named == TouchVerdict::Nothing,
        };
        tally.add(named, is_right, count);
        is_right
    }

    /// Mean of [`StreamFrame::mean_samples_used`] over frames with contact; `None` without any contact.
    pub fn mean_samples_used(&self) -> Option<f64> {
        mean(self.frames.iter().filter(|frame| frame.in_contact > 0).map(|frame| frame.mean_samples_used))
    }

    /// Classifier time per 100 taxels in contact, s (Fig. 8): the total time of frames with contact over the total
    /// number of taxels in contact.
    pub fn seconds_per_100_taxels(&self) -> Option<f64> {
        let with_contact = self.frames.iter().zip(&self.seconds).filter(|(frame, _)| frame.in_contact > 0);
        let (taxels, seconds) =
            with_contact.fold((0, 0.0), |(taxels, sum), (frame, seconds)| (taxels + frame.in_contact, sum + seconds));
        (taxels > 0).then(|| 100.0 * seconds / taxels as f64)
    }
}

#[cfg(test)]
mod tests;
