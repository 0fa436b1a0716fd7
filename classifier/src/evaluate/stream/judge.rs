//! Verdicts on a recorded reach, taxel by taxel and frame by frame, counted by the truth.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use underbrush_recording::{Category, Frame, Recording};

use super::super::touch_object::{JudgedObject, OpenObject};
use super::{NOTHING, Stream, StreamContact, StreamFrame, StreamTruth, Tally};
use crate::decision::Verdict;
use crate::touch::{Followed, TouchClassifier, TouchModel, TouchVerdict};
use crate::{Classifier, OnlineClassifier, OnlineError, OnlineOptions, TrialError};

/// A verdict on a taxel in contact.
struct Judged {
    /// Index of its patch in the skin, and of the taxel in its patch.
    place: (usize, usize),
    /// Samples since its contact began, at least 1.
    samples: usize,
    /// Index of the verdict in [`Stream::verdicts`].
    verdict: usize,
}

/// The last verdict on a taxel.
#[derive(Default)]
struct Last {
    verdict: Option<usize>,
    samples_used: usize,
    /// Index of the taxel's present contact in [`Stream::contacts`].
    contact: Option<usize>,
}

/// Classifies a recorded reach frame by frame, as the online classifier does while the arm moves.
///
/// # Errors
/// [`OnlineError`] if the patch, the classifier, the rule or a frame does not fit.
pub fn classify_stream(
    classifier: &dyn Classifier,
    recording: &Recording,
    options: &OnlineOptions,
    truth: StreamTruth,
) -> Result<Stream, OnlineError> {
    let mut online = OnlineClassifier::new(classifier, &recording.layout, options)?;
    let categories = classifier.categories();
    let stream = Stream::new(&categories, &[], recording, truth);
    // There is such a patch, or there would be no classifier.
    let patch = recording.layout.chosen_patch(options.patch.as_deref()).unwrap_or_default();
    stream.judged_by(recording, &[patch], truth, |frame, judged| {
        let verdicts = online.update(frame)?;
        let taxels = verdicts.filter_map(|taxel| {
            let verdict = taxel.verdict.index(&categories)?;
            Some(Judged { place: (patch, taxel.taxel), samples: taxel.samples, verdict })
        });
        judged.extend(taxels);
        Ok(())
    })
}

/// Like [`classify_stream`], but by a touch model, on all patches that it judges, with the objects that it tells apart there.
/// Something unlike all known categories counts as an outlier.
///
/// # Errors
/// [`TrialError`] if the skin lacks the model's patch, or a frame does not fit.
pub fn classify_touch_stream(
    model: &Arc<TouchModel>,
    recording: &Recording,
) -> Result<(Stream, Vec<JudgedObject>), TrialError> {
    let mut classifier = TouchClassifier::new(Arc::clone(model), &recording.layout)?;
    let categories = model.categories();
    let stream = Stream::new(categories, &[NOTHING], recording, StreamTruth::Object);
    let patches = model.options().judged_patches(&recording.layout);
    let (mut objects, mut frames) = (Followed::<OpenObject>::default(), 0);
    let stream = stream.judged_by(recording, &patches, StreamTruth::Object, |frame, judged| {
        classifier.update(frame)?;
        objects.judge(&classifier, frames, recording);
        frames += 1;
        judged.extend(classifier.taxels().iter().map(|taxel| Judged {
            place: (taxel.patch, taxel.taxel),
            samples: taxel.samples,
            verdict: match taxel.touch {
                TouchVerdict::Category(index) => index,
                TouchVerdict::Uncertain => categories.len(),
                TouchVerdict::Unknown => categories.len() + 1,
                TouchVerdict::Nothing => categories.len() + 2,
            },
        }));
        Ok::<(), TrialError>(())
    })?;
    Ok((stream, objects.judged(recording)))
}

/// Which objects truly press on the taxels of some patches in one frame, by [`Judged::place`].
type Pressing = BTreeMap<(usize, usize), Category>;

impl Stream {
    /// A stream without frames. `further` are the names of verdicts after the usual ones.
    fn new(categories: &[String], further: &[&str], recording: &Recording, truth: StreamTruth) -> Self {
        let mut verdicts = categories.to_vec();
        let usual = [Verdict::Uncertain, Verdict::Outlier];
        verdicts.extend(usual.iter().map(|verdict| verdict.name().to_owned()));
        verdicts.extend(further.iter().map(|name| (*name).to_owned()));
        let mut truths = Category::BUILT_IN.to_vec();
        truths.extend(recording.further_categories());
        if let StreamTruth::Environment(category) = truth
            && !truths.contains(&category)
        {
            truths.push(category);
        }
        Stream {
            taxel_frames: vec![vec![0; verdicts.len()]; truths.len() + 1],
            truths,
            verdicts,
            contacts: Vec::new(),
            frames: Vec::with_capacity(recording.frames.len()),
            seconds: Vec::with_capacity(recording.frames.len()),
        }
    }

    /// The stream of a recording whose taxels are judged frame by frame. `judge` appends a frame's verdicts to a list.
    fn judged_by<E>(
        mut self,
        recording: &Recording,
        patches: &[usize],
        truth: StreamTruth,
        mut judge: impl FnMut(&Frame, &mut Vec<Judged>) -> Result<(), E>,
    ) -> Result<Self, E> {
        let (mut judged, mut last) = (Vec::new(), BTreeMap::new());
        for frame in &recording.frames {
            judged.clear();
            let start = Instant::now();
            judge(frame, &mut judged)?;
            self.seconds.push(start.elapsed().as_secs_f64());
            let readings = frame.taxels.iter().filter(|reading| patches.contains(&usize::from(reading.patch)));
            let pressing = readings.filter_map(|reading| {
                let category = recording.category_of(reading.object?)?;
                Some(((usize::from(reading.patch), usize::from(reading.taxel)), category))
            });
            let pressing: Pressing = pressing.collect();
            self.observe(frame.time_s, &judged, &pressing, truth, &mut last);
        }
        Ok(self)
    }

    /// Counts the verdicts on a frame. `last` has the last verdict on each taxel that was in contact.
    fn observe(
        &mut self,
        time_s: f64,
        judged: &[Judged],
        pressing: &Pressing,
        truth: StreamTruth,
        last: &mut BTreeMap<(usize, usize), Last>,
    ) {
        let (mut tally, mut by_verdict) = (Tally::default(), vec![0; self.verdicts.len()]);
        let (mut used, mut since_contact) = (0, 0);
        for taxel in judged {
            let last = last.entry(taxel.place).or_default();
            if taxel.samples == 1 || last.verdict != Some(taxel.verdict) {
                last.verdict = Some(taxel.verdict);
                last.samples_used = if taxel.verdict == self.categories().len() { 0 } else { taxel.samples };
            }
            let truth = match truth {
                StreamTruth::Object => pressing.get(&taxel.place).copied(),
                StreamTruth::Environment(category) => Some(category),
            };
            if taxel.samples == 1 {
                last.contact = None;
            }
            if let Some(truth) = truth {
                let is_right = self.count(&mut tally, Some(truth), taxel.verdict, 1);
                let contact = *last.contact.get_or_insert(self.contacts.len());
                if contact == self.contacts.len() {
                    self.contacts.push(StreamContact { truth, first_right: None });
                }
                if is_right {
                    self.contacts[contact].first_right.get_or_insert(taxel.samples);
                }
            }
            used += last.samples_used;
            since_contact += taxel.samples;
            let row = truth.and_then(|truth| self.truths.iter().position(|category| *category == truth));
            let row = row.unwrap_or(self.truths.len());
            by_verdict[taxel.verdict] += 1;
            self.taxel_frames[row][taxel.verdict] += 1;
        }
        let taxels = judged.len().max(1) as f64;
        self.frames.push(StreamFrame {
            time_s,
            in_contact: judged.len(),
            tally,
            by_verdict,
            touched: self.truths.iter().map(|truth| pressing.values().any(|own| own == truth)).collect(),
            mean_samples_used: used as f64 / taxels,
            mean_samples_since_contact: since_contact as f64 / taxels,
        });
    }
}
