//! Verdicts on the contact of each taxel, by a classifier of trials.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::online::OnlineClassifier;
use underbrush_recording::Frame;

use crate::{Failure, output};

#[derive(Serialize)]
struct FrameLine<'a> {
    time_s: f64,
    taxels: Vec<TaxelLine<'a>>,
}

#[derive(Serialize)]
struct TaxelLine<'a> {
    taxel: usize,
    samples: usize,
    verdict: &'a str,
    scores: BTreeMap<&'a str, f64>,
}

/// The answer to the next frame: one line of JSON.
pub(super) fn answer(
    classifier: &mut OnlineClassifier,
    categories: &[String],
    frame: &Frame,
) -> Result<String, Failure> {
    let taxels = classifier.update(frame)?.map(|taxel| TaxelLine {
        taxel: taxel.taxel,
        samples: taxel.samples,
        verdict: taxel.verdict.name(),
        scores: categories.iter().map(String::as_str).zip(taxel.scores.iter().copied()).collect(),
    });
    output::json_line(&FrameLine { time_s: frame.time_s, taxels: taxels.collect() })
}
