//! Verdicts of a model on every taxel in contact, frame by frame, as sections.

use serde::Serialize;
use underbrush_classifier::Model;
use underbrush_classifier::online::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_recording::{Recording, SkinLayout};

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
#[derive(Debug, Serialize)]
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
    threshold_n: f64,
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

    /// Adds the verdicts on a recording: those of frame f are the rows `verdict_start[f]` to `verdict_start[f + 1]` of the
    /// sections `verdict_*`, and `verdict_score` has one number a category.
    ///
    /// # Errors
    /// [`OnlineError`] if a frame does not fit.
    pub fn add(&self, recording: &Recording, sections: &mut Sections) -> Result<VerdictHeader, OnlineError> {
        let classifier = self.model.classifier.as_ref();
        let layout = &recording.layout;
        let categories = classifier.categories();
        let mut verdicts = categories.clone();
        for other in ["uncertain", "outlier"] {
            if !categories.iter().any(|category| category == other) {
                verdicts.push(other.into());
            }
        }
        let patch = layout.chosen_patch(self.options.patch.as_deref()).unwrap_or_default();
        let earlier = layout.patches.iter().take(patch);
        let first_taxel: usize = earlier.map(|patch| patch.taxels.len()).sum();
        let mut online = OnlineClassifier::new(classifier, layout, &self.options)?;
        let (mut starts, mut taxels, mut codes) = (vec![0], Vec::new(), Vec::new());
        let (mut samples, mut scores) = (Vec::new(), Vec::new());
        for frame in &recording.frames {
            for taxel in online.update(frame)? {
                let code = verdicts.iter().position(|name| name == taxel.verdict.name());
                taxels.push((first_taxel + taxel.taxel) as u32);
                codes.push(code.unwrap_or_default() as u8);
                samples.push(taxel.samples as u32);
                scores.extend(&taxel.scores);
            }
            starts.push(taxels.len() as u32);
        }
        sections.add("verdict_start", starts);
        sections.add("verdict_taxel", taxels);
        sections.add("verdict_code", codes);
        sections.add("verdict_samples", samples);
        sections.add_single("verdict_score", scores);
        let columns = classifier.features().columns();
        Ok(VerdictHeader {
            model: self.name.clone(),
            classifier: classifier.name(),
            features: columns.into_iter().map(|column| column.to_string()).collect(),
            patch,
            threshold_n: self.options.threshold_n,
            categories,
            verdicts,
        })
    }
}
