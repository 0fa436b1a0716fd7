//! Verdicts on a recorded reach, taxel by taxel and frame by frame, counted by the truth.

use std::sync::Arc;
use std::time::Instant;

use underbrush_recording::{Category, Frame, Recording, SkinLayout};

use super::super::prediction::is_right;
use super::{NOTHING, Stream, StreamContact, StreamFrame, StreamTruth, Tally};
use crate::decision::Verdict;
use crate::touch::{Touch, TouchClassifier, TouchModel};
use crate::{Classifier, OnlineClassifier, OnlineError, OnlineOptions, TrialError};

/// A verdict on a taxel in contact.
struct Judged {
    /// Its index in the skin.
    taxel: usize,
    /// Samples since its contact began, at least 1.
    samples: usize,
    /// Index of the verdict in [`Stream::verdicts`].
    verdict: usize,
}

/// The last verdict on a taxel.
#[derive(Clone, Debug, Default)]
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
    let patches: Vec<usize> = recording.layout.chosen_patch(options.patch.as_deref()).into_iter().collect();
    let first = first_taxels(&recording.layout);
    stream.judged_by(recording, &patches, truth, |frame, judged| {
        let verdicts = online.update(frame)?;
        let taxels = verdicts.filter_map(|taxel| {
            let verdict = taxel.verdict.index(&categories)?;
            Some(Judged { taxel: first[*patches.first()?] + taxel.taxel, samples: taxel.samples, verdict })
        });
        judged.extend(taxels);
        Ok(())
    })
}

/// Like [`classify_stream`], but by a touch model, on all patches that it judges. Something unlike all known categories counts as
/// an outlier.
///
/// # Errors
/// [`TrialError`] if the skin lacks the model's patch, or a frame does not fit.
pub fn classify_touch_stream(model: &Arc<TouchModel>, recording: &Recording) -> Result<Stream, TrialError> {
    let mut classifier = TouchClassifier::new(Arc::clone(model), &recording.layout)?;
    let categories = model.categories();
    let stream = Stream::new(categories, &[NOTHING], recording, StreamTruth::Object);
    let patches = model.options().judged_patches(&recording.layout);
    let first = first_taxels(&recording.layout);
    stream.judged_by(recording, &patches, StreamTruth::Object, |frame, judged| {
        classifier.update(frame)?;
        judged.extend(classifier.taxels().iter().map(|taxel| Judged {
            taxel: first[taxel.patch] + taxel.taxel,
            samples: taxel.samples,
            verdict: match taxel.touch {
                Touch::Category(index) => index,
                Touch::Uncertain => categories.len(),
                Touch::Unknown => categories.len() + 1,
                Touch::Nothing => categories.len() + 2,
            },
        }));
        Ok(())
    })
}

/// The index in the skin of the first taxel of each patch.
fn first_taxels(layout: &SkinLayout) -> Vec<usize> {
    let mut next = 0;
    let first = layout.patches.iter().map(|patch| {
        next += patch.taxels.len();
        next - patch.taxels.len()
    });
    first.collect()
}

/// Which objects truly press on the taxels of some patches in one frame.
struct Pressing {
    by_taxel: Vec<(usize, Category)>,
    /// Whether each of the categories presses.
    touched: Vec<bool>,
}

impl Pressing {
    /// `first` has the index in the skin of each patch's first taxel.
    fn of(frame: &Frame, patches: &[usize], first: &[usize], recording: &Recording, truths: &[Category]) -> Self {
        let readings = frame.taxels.iter().filter(|reading| patches.contains(&usize::from(reading.patch)));
        let pressed = readings.filter_map(|reading| {
            let object = recording.objects.get(usize::from(reading.object?))?;
            Some((first[usize::from(reading.patch)] + usize::from(reading.taxel), object.category))
        });
        let by_taxel: Vec<(usize, Category)> = pressed.collect();
        let presses = |truth: &Category| by_taxel.iter().any(|(_, category)| category == truth);
        let touched = truths.iter().map(presses).collect();
        Pressing { by_taxel, touched }
    }

    fn on(&self, taxel: usize) -> Option<Category> {
        self.by_taxel.iter().find(|own| own.0 == taxel).map(|own| own.1)
    }
}

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
        let first = first_taxels(&recording.layout);
        let (mut judged, mut last) = (Vec::new(), Vec::new());
        for frame in &recording.frames {
            judged.clear();
            let start = Instant::now();
            judge(frame, &mut judged)?;
            self.seconds.push(start.elapsed().as_secs_f64());
            let pressing = Pressing::of(frame, patches, &first, recording, &self.truths);
            self.observe(frame.time_s, &judged, &pressing, truth, &mut last);
        }
        Ok(self)
    }

    /// Counts the verdicts on a frame. `last` has the last verdict on each taxel.
    fn observe(
        &mut self,
        time_s: f64,
        judged: &[Judged],
        pressing: &Pressing,
        truth: StreamTruth,
        last: &mut Vec<Last>,
    ) {
        let uncertain = self.verdicts.iter().position(|name| name == Verdict::Uncertain.name());
        let mut frame = StreamFrame {
            time_s,
            in_contact: judged.len(),
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
            if taxel.samples == 1 || last.verdict != Some(taxel.verdict) {
                last.verdict = Some(taxel.verdict);
                last.samples_used = if last.verdict == uncertain { 0 } else { taxel.samples };
            }
            let truth = match truth {
                StreamTruth::Object => pressing.on(taxel.taxel),
                StreamTruth::Environment(category) => Some(category),
            };
            if taxel.samples == 1 {
                last.contact = None;
            }
            self.follow(&mut last.contact, truth, taxel);
            frame.tally.count(truth, &self.verdicts[taxel.verdict], self.categories(), 1);
            used += last.samples_used;
            since_contact += taxel.samples;
            let row = truth.and_then(|truth| self.truths.iter().position(|category| *category == truth));
            let row = row.unwrap_or(self.truths.len());
            frame.by_verdict[taxel.verdict] += 1;
            self.taxel_frames[row][taxel.verdict] += 1;
        }
        let taxels = frame.in_contact.max(1) as f64;
        frame.mean_samples_used = used as f64 / taxels;
        frame.mean_samples_since_contact = since_contact as f64 / taxels;
        self.frames.push(frame);
    }

    /// Counts a sample of a contact; `place` is the index of the contact in [`Stream::contacts`], once it has a truth.
    fn follow(&mut self, place: &mut Option<usize>, truth: Option<Category>, taxel: &Judged) {
        if place.is_none()
            && let Some(truth) = truth
        {
            *place = Some(self.contacts.len());
            self.contacts.push(StreamContact { truth, samples: 0, first_right: None });
        }
        let verdict = &self.verdicts[taxel.verdict];
        let is_right = truth.is_some_and(|truth| is_right(truth.name(), verdict, self.categories()));
        let Some(contact) = place.and_then(|place| self.contacts.get_mut(place)) else { return };
        contact.samples = taxel.samples;
        if contact.first_right.is_none() && is_right {
            contact.first_right = Some(taxel.samples);
        }
    }
}
