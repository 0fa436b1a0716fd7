//! Frame-by-frame verdicts compared with ground truth (paper, sections V-B and V-D). Several figures are based on them.

use serde::Serialize;
use underbrush_classifier::evaluate::{ChosenThresholds, Stream, StreamTruth, classify_stream};
use underbrush_classifier::{Decision, OnlineOptions, Rule};
use underbrush_recording::{Category, Fault, Recording};

use crate::reaches::{self, Found};
use crate::{Experiment, Session, in_parallel, online_models};

/// A reach classified online.
pub struct Classified {
    /// Index of the reach in its scene.
    pub reach_index: u64,
    /// The verdicts.
    pub stream: Stream,
}

/// An engineered reach: its verdicts compared with the category of the scene, and with the object that presses.
pub struct EngineeredVerdicts {
    /// Compared with the category of the scene; `None` if no draw met the requirement.
    pub by_scene: Option<Classified>,
    /// Compared with the object that presses.
    pub by_object: Option<Classified>,
}

/// All reaches classified online.
pub struct Online {
    /// Engineered reaches, in the order of [`reaches::TestReaches::engineered`].
    pub engineered: Vec<EngineeredVerdicts>,
    /// General reaches.
    pub general: Vec<Classified>,
    /// General reaches drawn.
    pub general_drawn: u64,
    /// Outlier reaches by the rule of section V-D.
    pub outlier: Vec<Classified>,
    /// The outlier reaches by the chosen thresholds, if there are any.
    pub outlier_by_chosen: Option<(Decision, Vec<Classified>)>,
    /// Outlier reaches drawn.
    pub outlier_drawn: u64,
}

/// Fractions of the taxels with ground truth, per cent, over all frames.
///
/// ```
/// use underbrush_classifier::evaluate::Stream;
/// use underbrush_experiments::frame_verdicts::Shares;
/// use underbrush_recording::Category;
///
/// let verdicts = ["leaf", "trunk", "uncertain", "outlier"].map(String::from).into();
/// let taxel_frames = vec![vec![7, 1, 2, 0], vec![4, 1, 0, 0]];
/// let stream = Stream { truths: vec![Category::LEAF], verdicts, taxel_frames, ..Stream::default() };
/// let shares = Shares::of(&stream).expect("ten taxels were judged");
/// assert_eq!((shares.correct_percent, shares.taxel_frames, shares.without_truth), (70.0, 10, 5));
/// assert!(Shares::of(&Stream::default()).is_none());
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Shares {
    /// Correct verdicts.
    pub correct_percent: f64,
    /// Wrong verdicts.
    pub misclassified_percent: f64,
    /// No verdict yet.
    pub uncertain_percent: f64,
    /// Taxels in contact for which there is ground truth, summed over frames.
    pub taxel_frames: usize,
    /// Untouched taxels in contact (spurious readings), summed over frames. They are not in the fractions.
    pub without_truth: usize,
}

impl Shares {
    /// Fractions in a whole reach; `None` if nothing was judged.
    pub fn of(reach: &Stream) -> Option<Self> {
        let tally = reach.total();
        let taxel_frames = tally.total();
        let percent = |count: usize| 100.0 * count as f64 / taxel_frames as f64;
        (taxel_frames > 0).then(|| Shares {
            correct_percent: percent(tally.right),
            misclassified_percent: percent(tally.wrong),
            uncertain_percent: percent(tally.uncertain),
            taxel_frames,
            without_truth: reach.tally_of(None).total(),
        })
    }
}

impl Online {
    /// The general reach that figures show: the first found, as the paper shows "one of the reaching tasks".
    pub fn shown(&self) -> Option<&Classified> {
        self.general.first()
    }
}

/// Section V-B's rule: uncertain below a margin.
pub fn uncertain_rule(experiment: &Experiment) -> Rule {
    Rule::UncertainBelow { margin: experiment.file.thresholds.uncertain_below_nats }
}

/// Options for online classification in an experiment.
pub fn options(experiment: &Experiment, rule: Rule) -> OnlineOptions {
    let cut = experiment.trial_options();
    OnlineOptions { patch: cut.patch, threshold_n: cut.threshold_n, decision: Decision::new(rule) }
}

/// Classifies all test reaches online.
pub fn run(session: &Session) -> Result<Online, Fault> {
    let reaches = session.once(reaches::run)?;
    let (models, thresholds) = (session.once(online_models::run)?, session.once(online_models::thresholds)?);
    let (experiment, models) = (session.experiment, &*models);
    // One reach after the other, because the time per frame is measured.
    let classify = |found: Option<&Found>, rule: Rule, truth: StreamTruth| {
        let one = |recording: &Recording| {
            Ok(Classified {
                reach_index: recording.reach_index,
                stream: classify_stream(models, recording, &options(experiment, rule), truth)?,
            })
        };
        found.into_iter().flat_map(|found| &found.reaches).map(one).collect::<Result<Vec<_>, Fault>>()
    };
    let (general, outlier) = (reaches.general.as_ref(), reaches.outlier.as_ref());
    let drawn = |found: Option<&Found>| found.map_or(0, |found| found.drawn);
    session.stage("Online verdicts", || {
        let uncertain = uncertain_rule(experiment);
        // General reaches are classified first, and without other work on the machine, because their time is shown.
        let classified_general = classify(general, uncertain, StreamTruth::Object)?;
        let engineered = |(category, found): &(Category, Found)| {
            Ok(EngineeredVerdicts {
                by_scene: classify(Some(found), uncertain, StreamTruth::Environment(*category))?.pop(),
                by_object: classify(Some(found), uncertain, StreamTruth::Object)?.pop(),
            })
        };
        let engineered = in_parallel(&reaches.engineered, engineered);
        let outlier_by_chosen = match &thresholds.chosen {
            Ok(ChosenThresholds { decision, .. }) if outlier.is_some() => {
                Some((decision.clone(), classify(outlier, decision.rule, StreamTruth::Object)?))
            }
            _ => None,
        };
        Ok(Online {
            engineered: engineered?,
            general: classified_general,
            general_drawn: drawn(general),
            outlier: classify(outlier, Decision::paper().rule, StreamTruth::Object)?,
            outlier_by_chosen,
            outlier_drawn: drawn(outlier),
        })
    })
}
