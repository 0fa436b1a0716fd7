//! The answers to frames, one line of JSON each.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::online::OnlineClassifier;
use underbrush_classifier::touch::{ObjectReport, TouchClassifier};
use underbrush_recording::{Frame, SkinLayout};

use crate::{Failure, output};

/// Verdicts on the contact of each taxel, by a classifier of trials.
#[derive(Serialize)]
struct ContactsLine<'a> {
    time_s: f64,
    taxels: Vec<ContactLine<'a>>,
}

#[derive(Serialize)]
struct ContactLine<'a> {
    taxel: usize,
    samples: usize,
    verdict: &'a str,
    scores: BTreeMap<&'a str, f64>,
}

/// The answer of a classifier of trials to the next frame.
pub fn of_contacts(classifier: &mut OnlineClassifier, categories: &[String], frame: &Frame) -> Result<String, Failure> {
    let taxels = classifier.update(frame)?.map(|taxel| ContactLine {
        taxel: taxel.taxel,
        samples: taxel.samples,
        verdict: taxel.verdict.name(),
        scores: categories.iter().map(String::as_str).zip(taxel.scores.iter().copied()).collect(),
    });
    output::json_line(&ContactsLine { time_s: frame.time_s, taxels: taxels.collect() })
}

/// Verdicts on taxels and contact regions, by a touch model.
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

/// The answer of a touch model to the next frame.
pub fn of_touch(classifier: &mut TouchClassifier, layout: &SkinLayout, frame: &Frame) -> Result<String, Failure> {
    classifier.update(frame)?;
    let categories = classifier.model().categories();
    let probabilities = |region: usize, factor: f64| -> BTreeMap<&str, f64> {
        let own = classifier.probabilities(region).iter().map(|own| factor * own);
        categories.iter().map(String::as_str).zip(own).collect()
    };
    let taxels = classifier.taxels().iter().map(|own| TaxelLine {
        patch: &layout.patches[own.patch].name,
        taxel: own.taxel,
        samples: own.samples,
        contact: classifier.regions()[own.region].contact,
        verdict: own.touch.name(categories),
        nothing: own.nothing,
        probabilities: probabilities(own.region, 1.0 - own.nothing),
    });
    let regions = classifier.regions().iter().enumerate().map(|(index, own)| RegionLine {
        patch: &layout.patches[own.patch].name,
        contact: own.contact,
        object: own.object,
        samples: own.samples,
        taxels: own.taxels[0],
        touched_taxels: own.taxels[1],
        verdict: own.touch.name(categories),
        probabilities: probabilities(index, 1.0),
        share_beyond: own.share_beyond,
    });
    output::json_line(&FrameLine {
        time_s: frame.time_s,
        taxels: taxels.collect(),
        regions: regions.collect(),
        objects: classifier.object_reports().collect(),
    })
}
