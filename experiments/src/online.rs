//! The online experiments: verdicts frame by frame against ground truth (paper, sections V-B and V-D, Figs. 8 to 11, 15).

use std::collections::BTreeSet;

use rayon::prelude::*;
use serde::Serialize;
use underbrush_classifier::HmmClassifier;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::{Stream, StreamTruth, Tally, classify_stream};
use underbrush_classifier::online::OnlineOptions;
use underbrush_recording::{Category, Recording};

use crate::data;
use crate::error::ExperimentError;
use crate::reaches::{Found, TestReaches};

/// A reach classified online.
pub struct Classified {
    pub scene: String,
    pub reach_index: u64,
    pub stream: Stream,
}

/// Shares of the taxels with truth, per cent, over all frames.
#[derive(Clone, Debug, Serialize)]
pub struct Shares {
    pub correct_percent: f64,
    pub misclassified_percent: f64,
    pub uncertain_percent: f64,
    /// Taxels in contact with truth, summed over frames.
    pub taxel_frames: usize,
    /// Taxels in contact that nothing presses on, summed over frames; in no share.
    pub without_truth: usize,
}

/// One engineered reach (Fig. 11).
#[derive(Clone, Debug, Serialize)]
pub struct Engineered {
    pub scene: String,
    pub category: &'static str,
    /// Which draw of the scene it is, from 0; those before touched something else, or nothing.
    pub reach_index: Option<u64>,
    pub drawn: u64,
    /// By the environment's category. `None` where no draw did what it should, or the skin felt nothing.
    pub shares: Option<Shares>,
    /// Taxel frames among these in which nothing presses on the taxel (strays, creep, crosstalk), per cent.
    pub untouched_percent: Option<f64>,
    pub mean_samples_used: Option<f64>,
}

/// What one decision rule makes of the taxels that truly touch something (section V-D).
#[derive(Clone, Debug, Serialize)]
pub struct Detection {
    pub rule: String,
    pub truth: &'static str,
    /// Taxels in contact, summed over frames.
    pub taxel_frames: usize,
    /// Per cent by verdict.
    pub leaf_percent: f64,
    pub trunk_percent: f64,
    pub uncertain_percent: f64,
    pub outlier_percent: f64,
}

/// All of it.
pub struct Online {
    pub engineered: Vec<Engineered>,
    pub mixed: Vec<Classified>,
    pub mixed_drawn: u64,
    pub outlier: Vec<Classified>,
    pub outlier_drawn: u64,
    pub detection: Vec<Detection>,
}

/// Section V-B's rule.
pub fn uncertain_rule() -> Rule {
    Rule::UncertainBelow {
        margin: data::UNCERTAIN_BELOW_NATS,
    }
}

pub fn options(rule: Rule) -> OnlineOptions {
    let cut = data::trial_options();
    OnlineOptions {
        patch: cut.patch,
        threshold_n: cut.threshold_n,
        decision: Decision::new(rule),
    }
}

impl Shares {
    /// Shares of a tally; `None` where nothing was judged.
    pub fn of(tally: &Tally) -> Option<Self> {
        let judged = tally.judged();
        let percent = |count: usize| 100.0 * count as f64 / judged as f64;
        (judged > 0).then(|| Shares {
            correct_percent: percent(tally.correct),
            misclassified_percent: percent(tally.misclassified),
            uncertain_percent: percent(tally.uncertain),
            taxel_frames: judged,
            without_truth: tally.unknown,
        })
    }
}

/// Taxel frames in which nothing presses on the taxel, per cent of all; `None` without any.
fn untouched_percent(tally: &Tally) -> Option<f64> {
    let all = tally.judged() + tally.unknown;
    (all > 0).then(|| 100.0 * tally.unknown as f64 / all as f64)
}

/// Classifies the reaches of a scene. One after the other: the time per frame is measured.
fn classify(
    models: &HmmClassifier,
    found: &Found,
    rule: Rule,
    truth: StreamTruth,
) -> Result<Vec<Classified>, ExperimentError> {
    let options = options(rule);
    let one = |recording: &Recording| {
        Ok(Classified {
            scene: found.scene.clone(),
            reach_index: recording.reach_index,
            stream: classify_stream(models, recording, &options, truth)?,
        })
    };
    found.reaches.iter().map(one).collect()
}

impl Online {
    /// Classifies all reaches; `chosen` is a rule to compare with the paper's on the outlier reaches.
    pub fn run(
        models: &HmmClassifier,
        reaches: &TestReaches,
        chosen: Option<&Decision>,
    ) -> Result<Self, ExperimentError> {
        // First, alone on the machine, what Fig. 8 shows the time of.
        let mixed = classify(models, &reaches.mixed, uncertain_rule(), StreamTruth::Object)?;
        let engineered = |(category, found): &(Category, Found)| {
            let truth = StreamTruth::Environment(*category);
            let classified = classify(models, found, uncertain_rule(), truth)?.pop();
            let by_object = classify(models, found, uncertain_rule(), StreamTruth::Object)?.pop();
            Ok(Engineered {
                scene: found.scene.clone(),
                category: category.name(),
                reach_index: classified.as_ref().map(|reach| reach.reach_index),
                drawn: found.drawn,
                shares: classified.as_ref().and_then(|reach| Shares::of(&reach.stream.total())),
                untouched_percent: by_object.and_then(|reach| untouched_percent(&reach.stream.total())),
                mean_samples_used: classified.as_ref().and_then(|reach| reach.stream.mean_samples_used()),
            })
        };
        let engineered: Vec<Result<Engineered, ExperimentError>> =
            reaches.engineered.par_iter().map(engineered).collect();
        let paper = Decision::paper();
        let outlier = classify(models, &reaches.outlier, paper.rule, StreamTruth::Object)?;
        let mut detection = detection(&rule_name("the paper's", &paper), &outlier);
        if let Some(chosen) = chosen {
            let outlier = classify(models, &reaches.outlier, chosen.rule, StreamTruth::Object)?;
            detection.extend(self::detection(&rule_name(CHOSEN, chosen), &outlier));
        }
        Ok(Online {
            engineered: engineered.into_iter().collect::<Result<_, _>>()?,
            mixed,
            mixed_drawn: reaches.mixed.drawn,
            outlier,
            outlier_drawn: reaches.outlier.drawn,
            detection,
        })
    }

    /// The general reach that Figs. 8 to 10 and 12 show: the first found, as the paper shows "one of the reaching tasks".
    pub fn shown(&self) -> Option<&Classified> {
        self.mixed.first()
    }
}

/// How the names of the chosen thresholds begin.
pub const CHOSEN: &str = "chosen";

fn rule_name(whose: &str, decision: &Decision) -> String {
    match decision.rule {
        Rule::OutlierBand {
            uncertain_below,
            category_above,
        } => format!("{whose}: {uncertain_below:.1} and {category_above:.1}"),
        Rule::UncertainBelow { margin } => format!("{whose}: {margin:.1}"),
        Rule::Argmax => whose.to_owned(),
    }
}

/// One row a truth that occurs, over all reaches of a rule.
fn detection(rule: &str, reaches: &[Classified]) -> Vec<Detection> {
    let of = |category: Category| {
        let count = |name: &str| -> usize {
            let own = |reach: &Classified| {
                let column = reach.stream.verdicts.iter().position(|verdict| verdict == name);
                let row = reach.stream.truths.iter().position(|truth| *truth == category);
                row.zip(column)
                    .map_or(0, |(row, column)| reach.stream.taxel_frames[row][column])
            };
            reaches.iter().map(own).sum()
        };
        let counts = ["leaf", "trunk", "uncertain", "outlier"].map(count);
        let taxel_frames: usize = counts.iter().sum();
        let [leaf_percent, trunk_percent, uncertain_percent, outlier_percent] =
            counts.map(|count| 100.0 * count as f64 / taxel_frames as f64);
        (taxel_frames > 0).then(|| Detection {
            rule: rule.into(),
            truth: category.name(),
            taxel_frames,
            leaf_percent,
            trunk_percent,
            uncertain_percent,
            outlier_percent,
        })
    };
    let truths: BTreeSet<Category> = reaches.iter().flat_map(|reach| &reach.stream.truths).copied().collect();
    truths.into_iter().filter_map(of).collect()
}
