//! Verdicts of a model on every taxel in contact, frame by frame, as sections.

use serde::Serialize;
use underbrush_classifier::any_model::OnlineModel;
use underbrush_classifier::online::TaxelVerdict;
use underbrush_classifier::touch::{
    REGION_FEATURE_COUNT, REGION_FEATURES, RegionTouch, SkinTracker, TaxelTouch, TouchClassifier, TouchDecision,
};
use underbrush_recording::SkinLayout;

use crate::container::{Sections, first_taxels, starts};

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
    /// What the scores are: `nats`, log-likelihoods or log-posteriors, or `probability`, which sum to 1.
    score_kind: &'static str,
    /// The names of the verdicts.
    verdicts: Vec<String>,
    /// How a touch model decides; `None` for classifiers of trials.
    touch: Option<TouchDecision>,
}

impl VerdictHeader {
    /// What the page needs to know of the verdicts of a model of this name on this skin.
    fn of(name: &str, by: &OnlineModel, layout: &SkinLayout) -> Self {
        let categories = by.categories();
        let around = |before: &[&str], after: &[&str]| -> Vec<String> {
            let after = after.iter().filter(|other| !categories.iter().any(|own| own == *other));
            let names = before.iter().copied().chain(categories.iter().map(String::as_str));
            names.chain(after.copied()).map(str::to_owned).collect()
        };
        match by {
            OnlineModel::OfTrials(model, options) => VerdictHeader {
                model: name.into(),
                classifier: model.classifier.name(),
                features: model.classifier.features().columns().iter().map(ToString::to_string).collect(),
                patches: vec![layout.chosen_patch(by.patch()).unwrap_or_default()],
                threshold_n: options.threshold_n,
                scores: categories.clone(),
                score_kind: "nats",
                verdicts: around(&[], &["uncertain", "outlier"]),
                categories,
                touch: None,
            },
            OnlineModel::Touch(model) => VerdictHeader {
                model: name.into(),
                classifier: "touch",
                features: REGION_FEATURES.iter().map(ToString::to_string).collect(),
                patches: model.options().judged_patches(layout),
                threshold_n: model.options().threshold_n,
                scores: around(&["nothing"], &[]),
                score_kind: "probability",
                verdicts: around(&["nothing"], &["uncertain", "unknown"]),
                categories,
                touch: Some(model.decision),
            },
        }
    }

    fn code(&self, verdict: &str) -> u8 {
        self.verdicts.iter().position(|name| name == verdict).unwrap_or_default() as u8
    }
}

/// Verdicts on every taxel in contact, and the contact regions of a touch model, frame by frame.
#[derive(Clone, Debug)]
pub struct Verdicts {
    /// What the page needs to know to read them.
    pub(crate) header: VerdictHeader,
    /// The number of each patch's first taxel.
    first_taxels: Vec<u32>,
    frames: Vec<JudgedFrame>,
}

/// The verdicts on a frame.
#[derive(Clone, Debug, Default)]
struct JudgedFrame {
    /// The taxels in contact, in the order of their numbers.
    taxels: Vec<JudgedTaxel>,
    /// For each taxel, one number for each of the header's scores.
    scores: Vec<f64>,
    regions: Vec<JudgedRegion>,
}

/// The verdict on a taxel.
#[derive(Clone, Debug)]
struct JudgedTaxel {
    number: u32,
    samples: u32,
    code: u8,
    /// The index of its region among those of the frame.
    region: u16,
}

/// The verdict on a contact region.
#[derive(Clone, Debug)]
struct JudgedRegion {
    touch: RegionTouch,
    code: u8,
    features: [f64; REGION_FEATURE_COUNT],
}

impl Verdicts {
    /// The verdicts of a model of this name on this skin, without frames so far.
    pub(crate) fn new(name: &str, by: &OnlineModel, layout: &SkinLayout) -> Self {
        let header = VerdictHeader::of(name, by, layout);
        Verdicts { header, first_taxels: first_taxels(layout), frames: Vec::new() }
    }

    /// Adds the verdicts of a classifier of trials on a frame.
    pub(crate) fn push_of_trials<'a>(&mut self, verdicts: impl IntoIterator<Item = &'a TaxelVerdict>) {
        let mut frame = JudgedFrame::default();
        for own in verdicts {
            let place = (self.header.patches[0], own.taxel);
            frame.taxels.push(self.taxel(place, own.samples, own.verdict.name(), 0));
            frame.scores.extend(&own.scores);
        }
        self.frames.push(frame);
    }

    /// Adds the verdicts of a touch model on the frame that it has judged last.
    pub(crate) fn push_of_touch(&mut self, judged: &TouchClassifier) {
        let categories = judged.model().categories();
        // The classifier lists the taxels region by region.
        let mut verdicts: Vec<&TaxelTouch> = judged.taxels().iter().collect();
        verdicts.sort_unstable_by_key(|own| (own.patch, own.taxel));
        let mut frame = JudgedFrame::default();
        for own in verdicts {
            let place = (own.patch, own.taxel);
            frame.taxels.push(self.taxel(place, own.samples, own.touch.name(categories), own.region));
            let probabilities = judged.probabilities(own.region).iter();
            frame.scores.push(own.nothing);
            frame.scores.extend(probabilities.map(|share| (1.0 - own.nothing) * share));
        }
        let courses = judged.patches().iter().flat_map(SkinTracker::regions).map(|region| &region.course);
        frame.regions.extend(judged.regions().iter().zip(courses).map(|(own, course)| JudgedRegion {
            touch: *own,
            code: self.header.code(own.touch.name(categories)),
            features: course.features(),
        }));
        self.frames.push(frame);
    }

    fn taxel(&self, (patch, taxel): (usize, usize), samples: usize, verdict: &str, region: usize) -> JudgedTaxel {
        JudgedTaxel {
            number: self.first_taxels[patch] + taxel as u32,
            samples: samples as u32,
            code: self.header.code(verdict),
            region: region as u16,
        }
    }

    /// Adds the verdicts on the frames from number `from` on as the sections `verdict_*`, and the regions of a touch model as
    /// the sections `touch_*`. Those of a frame are the rows from its number in `verdict_start` or `touch_start` to the next
    /// one; rows are counted from the first of these frames. `verdict_score` has one number for each of the header's scores.
    pub(crate) fn add(&self, from: usize, sections: &mut Sections) {
        let frames = self.frames.get(from..).unwrap_or_default();
        let taxels = || frames.iter().flat_map(|frame| &frame.taxels);
        sections.add("verdict_start", starts(frames.iter().map(|frame| frame.taxels.len())));
        sections.add("verdict_taxel", taxels().map(|own| own.number));
        sections.add("verdict_code", taxels().map(|own| own.code));
        sections.add("verdict_samples", taxels().map(|own| own.samples));
        sections.add_single("verdict_score", frames.iter().flat_map(|frame| frame.scores.iter().copied()));
        if self.header.touch.is_none() {
            return;
        }
        let regions = || frames.iter().flat_map(|frame| &frame.regions);
        sections.add("verdict_region", taxels().map(|own| own.region));
        sections.add("touch_start", starts(frames.iter().map(|frame| frame.regions.len())));
        sections.add("touch_contact", regions().map(|own| own.touch.contact as u32));
        sections.add("touch_samples", regions().map(|own| own.touch.samples as u32));
        sections.add("touch_taxels", regions().map(|own| own.touch.taxels[0] as u16));
        sections.add("touch_touched_taxels", regions().map(|own| own.touch.taxels[1] as u16));
        sections.add("touch_code", regions().map(|own| own.code));
        sections.add_single("touch_share_beyond", regions().map(|own| own.touch.share_beyond));
        sections.add_single("touch_feature", regions().flat_map(|own| own.features));
    }
}
