//! Verdicts of a model on every taxel in contact, frame by frame, as sections.

use serde::Serialize;
use underbrush_classifier::Model;
use underbrush_classifier::online::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_recording::{Frame, Recording, SkinLayout};

use crate::container::Sections;

/// A model, and how it judges.
#[derive(Debug)]
pub struct Judging {
    /// What the page calls the model: the name of its file.
    pub name: String,
    /// The model.
    pub model: Model,
    /// The patch, the threshold of contact and the decision.
    pub options: OnlineOptions,
}

/// What the page has to know to read the verdicts.
#[derive(Clone, Debug, Serialize)]
pub struct VerdictHeader {
    /// The model.
    model: String,
    /// Name of its kind of classifier.
    classifier: &'static str,
    /// The columns of its features.
    features: Vec<String>,
    /// The patch that it judges.
    patch: usize,
    /// A taxel is judged where it senses more than this, N.
    pub threshold_n: f64,
    /// The categories of the scores.
    categories: Vec<String>,
    /// The names of the verdicts.
    verdicts: Vec<String>,
}

impl Judging {
    /// Checks that the model can judge frames of this skin.
    ///
    /// # Errors
    /// [`OnlineError`] if the patch is unknown or does not fit the model's features.
    pub fn check(&self, layout: &SkinLayout) -> Result<(), OnlineError> {
        OnlineClassifier::new(self.model.classifier.as_ref(), layout, &self.options).map(drop)
    }

    /// Begins to judge the frames of this skin.
    ///
    /// # Errors
    /// As [`Judging::check`].
    pub fn begin(&self, layout: &SkinLayout) -> Result<VerdictLog, OnlineError> {
        let classifier = self.model.classifier.as_ref();
        let categories = classifier.categories();
        let mut verdicts = categories.clone();
        for other in ["uncertain", "outlier"] {
            if !categories.iter().any(|category| category == other) {
                verdicts.push(other.into());
            }
        }
        let patch = layout.chosen_patch(self.options.patch.as_deref()).unwrap_or_default();
        let earlier = layout.patches.iter().take(patch);
        let columns = classifier.features().columns();
        Ok(VerdictLog {
            online: OnlineClassifier::new(classifier, layout, &self.options)?,
            first_taxel: earlier.map(|patch| patch.taxels.len()).sum(),
            verdicts: Verdicts {
                header: VerdictHeader {
                    model: self.name.clone(),
                    classifier: classifier.name(),
                    features: columns.into_iter().map(|column| column.to_string()).collect(),
                    patch,
                    threshold_n: self.options.threshold_n,
                    categories,
                    verdicts,
                },
                starts: vec![0],
                taxels: Vec::new(),
                codes: Vec::new(),
                samples: Vec::new(),
                scores: Vec::new(),
            },
        })
    }

    /// The verdicts on all frames of a recording.
    ///
    /// # Errors
    /// [`OnlineError`] if a frame does not fit.
    pub fn judge(&self, recording: &Recording) -> Result<Verdicts, OnlineError> {
        let mut log = self.begin(&recording.layout)?;
        recording.frames.iter().try_for_each(|frame| log.update(frame))?;
        Ok(log.verdicts)
    }
}

/// Judges frame by frame and keeps all verdicts.
#[derive(Debug)]
pub struct VerdictLog {
    online: OnlineClassifier,
    first_taxel: usize,
    verdicts: Verdicts,
}

impl VerdictLog {
    /// Judges the next frame.
    ///
    /// # Errors
    /// [`OnlineError`] if it does not fit.
    pub fn update(&mut self, frame: &Frame) -> Result<(), OnlineError> {
        let own = &mut self.verdicts;
        for taxel in self.online.update(frame)? {
            let code = own.header.verdicts.iter().position(|name| name == taxel.verdict.name());
            own.taxels.push((self.first_taxel + taxel.taxel) as u32);
            own.codes.push(code.unwrap_or_default() as u8);
            own.samples.push(taxel.samples as u32);
            own.scores.extend(&taxel.scores);
        }
        own.starts.push(own.taxels.len() as u32);
        Ok(())
    }

    /// The verdicts so far.
    pub fn verdicts(&self) -> &Verdicts {
        &self.verdicts
    }
}

/// Verdicts on every taxel in contact: those of frame f are the rows `starts[f]` to `starts[f + 1]`.
#[derive(Clone, Debug)]
pub struct Verdicts {
    /// What the page has to know to read them.
    pub(crate) header: VerdictHeader,
    starts: Vec<u32>,
    taxels: Vec<u32>,
    codes: Vec<u8>,
    samples: Vec<u32>,
    scores: Vec<f64>,
}

impl Verdicts {
    /// Adds those on the frames from number `from` on as the sections `verdict_*`; rows are counted from the first of these,
    /// and `verdict_score` has one number a category.
    pub(crate) fn add(&self, from: usize, sections: &mut Sections) {
        let starts = self.starts.get(from..).unwrap_or_default();
        let first = starts.first().copied().unwrap_or_default() as usize;
        let rows = first..self.taxels.len();
        sections.add("verdict_start", starts.iter().map(|start| start - first as u32));
        sections.add("verdict_taxel", self.taxels[rows.clone()].iter().copied());
        sections.add("verdict_code", self.codes[rows.clone()].iter().copied());
        sections.add("verdict_samples", self.samples[rows].iter().copied());
        let scores = &self.scores[first * self.header.categories.len()..];
        sections.add_single("verdict_score", scores.iter().copied());
    }
}
