//! Verdicts of a model on every taxel in contact, frame by frame, as sections.

use serde::Serialize;
use underbrush_classifier::Model;
use underbrush_classifier::online::{OnlineOptions, TaxelVerdict};
use underbrush_classifier::touch::{REGION_FEATURES, TaxelTouch, TouchClassifier, TouchDecision, TouchModel};
use underbrush_recording::SkinLayout;

use crate::container::Sections;
use crate::touch_regions::TouchRegions;

/// What the page needs to know to read the verdicts.
#[derive(Clone, Debug, Serialize)]
pub struct VerdictHeader {
    /// Name of the model.
    model: String,
    /// Name of its kind of classifier.
    classifier: &'static str,
    /// The columns of its features; for a touch model, the features of a contact region.
    features: Vec<String>,
    /// The patches that it judges, in ascending order.
    patches: Vec<usize>,
    /// A taxel is judged where it senses more than this, N.
    pub(crate) threshold_n: f64,
    /// The categories that it knows.
    categories: Vec<String>,
    /// What each score of a taxel is about: the categories; for a touch model, `nothing` comes before them.
    scores: Vec<String>,
    /// What the scores are.
    score_kind: ScoreKind,
    /// The names of the verdicts.
    verdicts: Vec<String>,
    /// How a touch model decides; `None` for classifiers of trials.
    touch: Option<TouchDecision>,
}

/// What the scores of a taxel are.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum ScoreKind {
    /// Log-likelihoods or log-posteriors, nats.
    Nats,
    /// Probabilities, which sum to 1.
    Probability,
}

impl VerdictHeader {
    pub(crate) fn of_trials(name: &str, model: &Model, options: &OnlineOptions, patch: usize) -> Self {
        let classifier = model.classifier.as_ref();
        let categories = classifier.categories();
        let mut verdicts = categories.clone();
        for other in ["uncertain", "outlier"] {
            if !categories.iter().any(|category| category == other) {
                verdicts.push(other.into());
            }
        }
        let columns = classifier.features().columns().into_iter();
        VerdictHeader {
            model: name.into(),
            classifier: classifier.name(),
            features: columns.map(|column| column.to_string()).collect(),
            patches: vec![patch],
            threshold_n: options.threshold_n,
            scores: categories.clone(),
            score_kind: ScoreKind::Nats,
            categories,
            verdicts,
            touch: None,
        }
    }

    pub(crate) fn of_touch(name: &str, model: &TouchModel, patches: Vec<usize>) -> Self {
        let categories = model.categories().to_vec();
        let around = |before: &[&str], after: &[&str]| -> Vec<String> {
            let names = before.iter().copied().chain(categories.iter().map(String::as_str));
            names.chain(after.iter().copied()).map(str::to_owned).collect()
        };
        VerdictHeader {
            model: name.into(),
            classifier: "touch",
            features: REGION_FEATURES.iter().map(|feature| (*feature).to_owned()).collect(),
            patches,
            threshold_n: model.options().threshold_n,
            scores: around(&["nothing"], &[]),
            score_kind: ScoreKind::Probability,
            verdicts: around(&["nothing"], &["uncertain", "unknown"]),
            categories,
            touch: Some(model.decision),
        }
    }

    fn code(&self, verdict: &str) -> u8 {
        let place = self.verdicts.iter().position(|name| name == verdict);
        place.unwrap_or_default() as u8
    }
}

/// Verdicts on every taxel in contact. The verdicts of frame f are the rows `starts[f]` to `starts[f + 1]`, sorted by
/// taxel.
#[derive(Clone, Debug)]
pub struct Verdicts {
    /// What the page needs to know to read them.
    pub(crate) header: VerdictHeader,
    /// The number of each patch's first taxel.
    first_taxels: Vec<usize>,
    starts: Vec<u32>,
    taxels: Vec<u32>,
    codes: Vec<u8>,
    samples: Vec<u32>,
    scores: Vec<f64>,
    /// The contact regions of a touch model.
    regions: Option<TouchRegions>,
}

impl Verdicts {
    /// Verdicts without frames so far, on this skin.
    pub(crate) fn new(header: VerdictHeader, layout: &SkinLayout) -> Self {
        let first_taxels = layout.patches.iter().scan(0, |end, patch| {
            *end += patch.taxels.len();
            Some(*end - patch.taxels.len())
        });
        Verdicts {
            first_taxels: first_taxels.collect(),
            starts: vec![0],
            taxels: Vec::new(),
            codes: Vec::new(),
            samples: Vec::new(),
            scores: Vec::new(),
            regions: header.touch.map(|_| TouchRegions::new()),
            header,
        }
    }

    /// Adds the verdicts of a classifier of trials on a frame.
    pub(crate) fn push_of_trials<'a>(&mut self, frame: impl IntoIterator<Item = &'a TaxelVerdict>) {
        for taxel in frame {
            self.push(self.header.patches[0], taxel.taxel, taxel.samples, self.header.code(taxel.verdict.name()));
            self.scores.extend(&taxel.scores);
        }
        self.starts.push(self.taxels.len() as u32);
    }

    /// Adds the verdicts of a touch model on the frame that it has judged last.
    pub(crate) fn push_of_touch(&mut self, judged: &TouchClassifier) {
        let categories = judged.model().categories();
        // The classifier lists the taxels region by region.
        let mut frame: Vec<&TaxelTouch> = judged.taxels().iter().collect();
        frame.sort_unstable_by_key(|own| (own.patch, own.taxel));
        for own in &frame {
            self.push(own.patch, own.taxel, own.samples, self.header.code(own.touch.name(categories)));
            let probabilities = judged.probabilities(own.region).iter();
            self.scores.push(own.nothing);
            self.scores.extend(probabilities.map(|share| (1.0 - own.nothing) * share));
        }
        let code = |name: &str| self.header.code(name);
        if let Some(regions) = &mut self.regions {
            regions.push(judged, &frame, code);
        }
        self.starts.push(self.taxels.len() as u32);
    }

    fn push(&mut self, patch: usize, taxel: usize, samples: usize, code: u8) {
        self.taxels.push((self.first_taxels[patch] + taxel) as u32);
        self.codes.push(code);
        self.samples.push(samples as u32);
    }

    /// Adds the verdicts on the frames from number `from` on as the sections `verdict_*`. Rows are counted from the
    /// first of these verdicts, and `verdict_score` has one number for each of the header's scores.
    pub(crate) fn add(&self, from: usize, sections: &mut Sections) {
        let starts = self.starts.get(from..).unwrap_or_default();
        let first = starts.first().copied().unwrap_or_default() as usize;
        let rows = first..self.taxels.len();
        sections.add("verdict_start", starts.iter().map(|start| start - first as u32));
        sections.add("verdict_taxel", self.taxels[rows.clone()].iter().copied());
        sections.add("verdict_code", self.codes[rows.clone()].iter().copied());
        sections.add("verdict_samples", self.samples[rows.clone()].iter().copied());
        let scores = &self.scores[first * self.header.scores.len()..];
        sections.add_single("verdict_score", scores.iter().copied());
        if let Some(regions) = &self.regions {
            regions.add(from, rows, sections);
        }
    }
}
