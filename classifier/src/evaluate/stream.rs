//! Online classification of a recorded reach against its ground truth, frame by frame (paper, Figs. 8 to 11 and 15).

use std::time::Instant;

use serde::Serialize;
use underbrush_recording::{Category, Frame, Recording};

use super::prediction::is_right;
use crate::decision::Verdict;
use crate::estimator::Classifier;
use crate::online::{OnlineClassifier, OnlineError, OnlineOptions, TaxelVerdict};

/// What counts as the truth for a taxel's verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamTruth {
    /// The object that presses hardest on the taxel in this frame. A taxel that nothing presses on (crosstalk, creep) has
    /// no truth.
    Object,
    /// The single category of the environment, whatever presses, as in the paper's engineered reaches (section V-B).
    Environment(Category),
}

/// Taxels in contact, counted by whether their verdict is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// The verdict is right, by the same rule as for whole trials ([`super::Prediction::is_correct`]).
    pub correct: usize,
    /// The verdict is another category, or outlier for something that is not one.
    pub misclassified: usize,
    /// No verdict yet.
    pub uncertain: usize,
    /// The truth is unknown.
    pub unknown: usize,
}

impl Tally {
    /// Number of taxels whose truth is known.
    pub fn judged(&self) -> usize {
        self.correct + self.misclassified + self.uncertain
    }

    fn count(&mut self, truth: Option<Category>, verdict: &Verdict) {
        let Some(truth) = truth else {
            self.unknown += 1;
            return;
        };
        match verdict {
            Verdict::Uncertain => self.uncertain += 1,
            verdict if is_right(truth.name(), verdict) => self.correct += 1,
            _ => self.misclassified += 1,
        }
    }
}

/// One frame of a reach.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StreamFrame {
    /// Time since the start of the reach, s.
    pub time_s: f64,
    /// Number of taxels in contact.
    pub in_contact: usize,
    /// The same, by whether the verdict is right.
    pub tally: Tally,
    /// The same, by verdict, in the order of [`Stream::verdicts`].
    pub by_verdict: Vec<usize>,
    /// Whether an object of each of [`Stream::truths`] truly presses on the patch.
    pub touched: Vec<bool>,
    /// Mean number of samples used (Fig. 9) over the taxels in contact: how many samples of its contact had arrived when a
    /// taxel's current verdict was first given, or 0 while it is uncertain. 0 without contact.
    pub mean_samples_used: f64,
    /// Mean number of samples since contact over the taxels in contact. 0 without contact.
    pub mean_samples_since_contact: f64,
}

/// One contact of a taxel with something, from the samples that were classified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamContact {
    /// The truth of the first sample that has one. Contacts that never have one are left out.
    pub truth: Category,
    /// Number of samples of the contact, from the first reading above the threshold.
    pub samples: usize,
    /// The number of samples that had arrived when the verdict was right for the first time; `None` if it never was.
    pub first_right: Option<usize>,
}

/// A reach classified online.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// The categories that an object of the recording can have: [`Category::BUILT_IN`], then further ones that occur.
    pub truths: Vec<Category>,
    /// Names of the verdicts: the classifier's categories in alphabetical order, uncertain, outlier.
    pub verdicts: Vec<String>,
    /// The frames.
    pub frames: Vec<StreamFrame>,
    /// Taxels in contact, summed over all frames, by truth ([`Stream::truths`], then without truth) and verdict.
    pub taxel_frames: Vec<Vec<usize>>,
    /// Contacts with ground truth, in the order in which they first had it.
    pub contacts: Vec<StreamContact>,
    /// Wall time of the classifier for each frame, s. This is the only field that depends on the machine.
    pub seconds: Vec<f64>,
}

/// The last verdict on a taxel.
#[derive(Clone, Debug, Default)]
struct Last {
    verdict: Option<Verdict>,
    samples_used: usize,
    /// Its present contact in [`Stream::contacts`].
    contact: Option<usize>,
}

/// Classifies a recorded reach frame by frame, as online while the arm moves.
///
/// # Errors
/// [`OnlineError`] if patch, classifier, rule or a frame do not fit.
pub fn classify_stream(
    classifier: &dyn Classifier,
    recording: &Recording,
    options: &OnlineOptions,
    truth: StreamTruth,
) -> Result<Stream, OnlineError> {
    let mut online = OnlineClassifier::new(classifier, &recording.layout, options)?;
    let patch = recording
        .layout
        .chosen_patch(options.patch.as_deref())
        .unwrap_or_default();
    let mut verdicts = classifier.categories();
    verdicts.extend([Verdict::Uncertain.name().to_owned(), Verdict::Outlier.name().to_owned()]);
    let mut truths = Category::BUILT_IN.to_vec();
    truths.extend(recording.further_categories());
    if let StreamTruth::Environment(category) = truth
        && !truths.contains(&category)
    {
        truths.push(category);
    }
    let mut stream = Stream {
        taxel_frames: vec![vec![0; verdicts.len()]; truths.len() + 1],
        truths,
        verdicts,
        contacts: Vec::new(),
        frames: Vec::with_capacity(recording.frames.len()),
        seconds: Vec::with_capacity(recording.frames.len()),
    };
    let mut last: Vec<Last> = Vec::new();
    for frame in &recording.frames {
        let pressing = Pressing::of(frame, patch, recording, &stream.truths);
        let start = Instant::now();
        let judged = online.update(frame)?;
        stream.seconds.push(start.elapsed().as_secs_f64());
        stream.observe(frame.time_s, judged, &pressing, truth, &mut last);
    }
    Ok(stream)
}

/// Which objects truly press on the taxels of a patch in one frame.
struct Pressing {
    by_taxel: Vec<(usize, Category)>,
    /// Whether each of the categories presses.
    touched: Vec<bool>,
}

impl Pressing {
    fn of(frame: &Frame, patch: usize, recording: &Recording, truths: &[Category]) -> Self {
        let mut by_taxel = Vec::new();
        for reading in frame
            .taxels
            .iter()
            .filter(|reading| usize::from(reading.patch) == patch)
        {
            let object = reading
                .object
                .and_then(|object| recording.objects.get(usize::from(object)));
            if let Some(object) = object {
                by_taxel.push((usize::from(reading.taxel), object.category));
            }
        }
        let presses = |truth: &Category| by_taxel.iter().any(|(_, category)| category == truth);
        let touched = truths.iter().map(presses).collect();
        Pressing { by_taxel, touched }
    }

    fn on(&self, taxel: usize) -> Option<Category> {
        self.by_taxel.iter().find(|own| own.0 == taxel).map(|own| own.1)
    }
}

impl Stream {
    fn observe<'a>(
        &mut self,
        time_s: f64,
        judged: impl Iterator<Item = &'a TaxelVerdict>,
        pressing: &Pressing,
        truth: StreamTruth,
        last: &mut Vec<Last>,
    ) {
        let mut frame = StreamFrame {
            time_s,
            in_contact: 0,
            tally: Tally::default(),
            by_verdict: vec![0; self.verdicts.len()],
            touched: pressing.touched.clone(),
            mean_samples_used: 0.0,
            mean_samples_since_contact: 0.0,
        };
        let (mut used, mut since_contact) = (0, 0);
        for taxel in judged {
            if last.len() <= taxel.taxel {
                last.resize(taxel.taxel + 1, Last::default());
            }
            let last = &mut last[taxel.taxel];
            if taxel.samples == 1 || last.verdict.as_ref() != Some(&taxel.verdict) {
                last.verdict = Some(taxel.verdict.clone());
                last.samples_used = if taxel.verdict == Verdict::Uncertain {
                    0
                } else {
                    taxel.samples
                };
            }
            let truth = match truth {
                StreamTruth::Object => pressing.on(taxel.taxel),
                StreamTruth::Environment(category) => Some(category),
            };
            if taxel.samples == 1 {
                last.contact = None;
            }
            self.follow(&mut last.contact, truth, taxel);
            frame.in_contact += 1;
            frame.tally.count(truth, &taxel.verdict);
            used += last.samples_used;
            since_contact += taxel.samples;
            let row = truth.and_then(|truth| self.truths.iter().position(|category| *category == truth));
            let row = row.unwrap_or(self.truths.len());
            if let Some(column) = self.verdicts.iter().position(|name| name == taxel.verdict.name()) {
                frame.by_verdict[column] += 1;
                self.taxel_frames[row][column] += 1;
            }
        }
        let taxels = frame.in_contact.max(1) as f64;
        frame.mean_samples_used = used as f64 / taxels;
        frame.mean_samples_since_contact = since_contact as f64 / taxels;
        self.frames.push(frame);
    }

    /// Counts a sample of a contact; `place` is where the contact is in the list, once it has a truth.
    fn follow(&mut self, place: &mut Option<usize>, truth: Option<Category>, taxel: &TaxelVerdict) {
        if place.is_none()
            && let Some(truth) = truth
        {
            *place = Some(self.contacts.len());
            self.contacts.push(StreamContact {
                truth,
                samples: 0,
                first_right: None,
            });
        }
        let Some(contact) = place.and_then(|place| self.contacts.get_mut(place)) else {
            return;
        };
        contact.samples = taxel.samples;
        if contact.first_right.is_none() && truth.is_some_and(|truth| is_right(truth.name(), &taxel.verdict)) {
            contact.first_right = Some(taxel.samples);
        }
    }

    /// The taxels in contact with objects of this category, summed over all frames.
    pub fn tally_of(&self, truth: Category) -> Tally {
        let mut tally = Tally::default();
        let Some(row) = self.truths.iter().position(|other| *other == truth) else {
            return tally;
        };
        for (verdict, count) in self.verdicts.iter().zip(&self.taxel_frames[row]) {
            if verdict == Verdict::Uncertain.name() {
                tally.uncertain += count;
            } else if verdict == truth.name() {
                tally.correct += count;
            } else {
                tally.misclassified += count;
            }
        }
        tally
    }

    /// The tallies of all frames together.
    pub fn total(&self) -> Tally {
        self.frames.iter().fold(Tally::default(), |sum, frame| Tally {
            correct: sum.correct + frame.tally.correct,
            misclassified: sum.misclassified + frame.tally.misclassified,
            uncertain: sum.uncertain + frame.tally.uncertain,
            unknown: sum.unknown + frame.tally.unknown,
        })
    }

    /// Mean of [`StreamFrame::mean_samples_used`] over frames with contact; `None` without any contact.
    pub fn mean_samples_used(&self) -> Option<f64> {
        let used: Vec<f64> = self
            .frames
            .iter()
            .filter(|frame| frame.in_contact > 0)
            .map(|frame| frame.mean_samples_used)
            .collect();
        (!used.is_empty()).then(|| used.iter().sum::<f64>() / used.len() as f64)
    }

    /// Classifier time per 100 taxels in contact, s (Fig. 8): the total time of frames with contact over the total number of
    /// taxels in contact.
    pub fn seconds_per_100_taxels(&self) -> Option<f64> {
        let with_contact = self
            .frames
            .iter()
            .zip(&self.seconds)
            .filter(|(frame, _)| frame.in_contact > 0);
        let (taxels, seconds) = with_contact.fold((0, 0.0), |(taxels, sum), (frame, seconds)| {
            (taxels + frame.in_contact, sum + seconds)
        });
        (taxels > 0).then(|| 100.0 * seconds / taxels as f64)
    }
}

#[cfg(test)]
mod tests;
