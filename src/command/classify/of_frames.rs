//! Verdicts on taxels and contact regions, by a touch model.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use underbrush_classifier::touch::{ObjectReport, TouchClassifier, TouchModel};
use underbrush_recording::{Frame, SkinLayout};

use super::super::touch::TouchDecisionArguments;
use super::online::{Answers, Reach, json_line};
use crate::failure::Failure;

/// A touch model that answers frames.
pub(super) struct OfFrames {
    model: Arc<TouchModel>,
}

impl OfFrames {
    pub(super) fn new(mut model: TouchModel, decision: &TouchDecisionArguments) -> Self {
        model.decision = decision.over(model.decision);
        OfFrames { model: Arc::new(model) }
    }
}

impl Answers for OfFrames {
    fn start(&self, layout: &SkinLayout) -> Result<Box<dyn Reach>, Failure> {
        let patches = layout.patches.iter().map(|patch| patch.name.clone()).collect();
        Ok(Box::new(Frames { classifier: TouchClassifier::new(Arc::clone(&self.model), layout)?, patches }))
    }

    fn needs_poses_of(&self, layout: &SkinLayout) -> Vec<usize> {
        self.model.options().judged_patches(layout)
    }
}

struct Frames {
    classifier: TouchClassifier,
    /// The names of the skin's patches.
    patches: Vec<String>,
}

#[derive(Serialize)]
struct FrameLine<'a> {
    time_s: f64,
    taxels: Vec<TaxelLine<'a>>,
    regions: Vec<RegionLine<'a>>,
    objects: Vec<ObjectReport<'a>>,
}

#[derive(Serialize)]
struct TaxelLine<'a> {
    patch: &'a str,
    taxel: usize,
    samples: usize,
    /// Number of the region's contact.
    contact: u64,
    verdict: &'a str,
    /// Probability that nothing touches the taxel. It and the probabilities of the categories sum to 1.
    nothing: f64,
    probabilities: BTreeMap<&'a str, f64>,
}

#[derive(Serialize)]
struct RegionLine<'a> {
    patch: &'a str,
    contact: u64,
    /// Number of its object; left out while the contact is as weak as a spurious reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<u64>,
    samples: usize,
    taxels: usize,
    /// Number of taxels that are not called nothing.
    touched_taxels: usize,
    verdict: &'a str,
    /// Probability of each category if something of a known category touches the region; they sum to 1.
    probabilities: BTreeMap<&'a str, f64>,
    share_beyond: f64,
}

impl Reach for Frames {
    fn answer(&mut self, frame: &Frame) -> Result<String, Failure> {
        self.classifier.update(frame)?;
        let classifier = &self.classifier;
        let categories = classifier.model().categories();
        let probabilities = |region: usize, factor: f64| -> BTreeMap<&str, f64> {
            let own = classifier.probabilities(region).iter().map(|own| factor * own);
            categories.iter().map(String::as_str).zip(own).collect()
        };
        let patches = &self.patches;
        let taxels = classifier.taxels().iter().map(|own| TaxelLine {
            patch: &patches[own.patch],
            taxel: own.taxel,
            samples: own.samples,
            contact: classifier.regions()[own.region].contact,
            verdict: own.touch.name(categories),
            nothing: own.nothing,
            probabilities: probabilities(own.region, 1.0 - own.nothing),
        });
        let regions = classifier.regions().iter().enumerate().map(|(index, own)| RegionLine {
            patch: &patches[own.patch],
            contact: own.contact,
            object: own.object,
            samples: own.samples,
            taxels: own.taxels[0],
            touched_taxels: own.taxels[1],
            verdict: own.touch.name(categories),
            probabilities: probabilities(index, 1.0),
            share_beyond: own.share_beyond,
        });
        json_line(&FrameLine {
            time_s: frame.time_s,
            taxels: taxels.collect(),
            regions: regions.collect(),
            objects: classifier.object_reports().collect(),
        })
    }
}
