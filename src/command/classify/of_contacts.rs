//! Verdicts on the contact of each taxel, by a classifier of trials.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_classifier::Model;
use underbrush_classifier::online::{OnlineClassifier, OnlineOptions};
use underbrush_classifier::paper_rule::Scores;
use underbrush_recording::{Frame, SkinLayout};

use super::ClassifyOptions;
use super::online::{Answers, Reach, json_line};
use crate::failure::Failure;

/// A classifier of trials that answers frames.
pub(super) struct OfContacts {
    model: Model,
    settings: OnlineOptions,
}

impl OfContacts {
    pub(super) fn new(options: &ClassifyOptions, model: Model) -> Result<Self, Failure> {
        options.cut.refuse_online()?;
        let decision = options.decision.decision(&Scores::of_model(&model))?;
        Ok(OfContacts {
            settings: OnlineOptions { patch: options.cut.patch(), threshold_n: options.cut.threshold_n(), decision },
            model,
        })
    }
}

impl Answers for OfContacts {
    fn start(&self, layout: &SkinLayout) -> Result<Box<dyn Reach>, Failure> {
        let classifier = self.model.classifier.as_ref();
        Ok(Box::new(Contacts {
            categories: classifier.categories(),
            classifier: OnlineClassifier::new(classifier, layout, &self.settings)?,
        }))
    }

    fn needs_poses_of(&self, layout: &SkinLayout) -> Vec<usize> {
        self.settings.needs_pose_of(self.model.classifier.as_ref(), layout).into_iter().collect()
    }
}

struct Contacts {
    categories: Vec<String>,
    classifier: OnlineClassifier,
}

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

impl Reach for Contacts {
    fn answer(&mut self, frame: &Frame) -> Result<String, Failure> {
        let categories = &self.categories;
        let taxels = self.classifier.update(frame)?.map(|taxel| TaxelLine {
            taxel: taxel.taxel,
            samples: taxel.samples,
            verdict: taxel.verdict.name(),
            scores: categories.iter().map(String::as_str).zip(taxel.scores.iter().copied()).collect(),
        });
        json_line(&FrameLine { time_s: frame.time_s, taxels: taxels.collect() })
    }
}
