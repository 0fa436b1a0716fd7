//! `underbrush classify`: a verdict for each trial, or for each taxel in contact as frames come in.

mod answers;
mod online;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde::Serialize;
use underbrush_classifier::any_model::{self, AnyModel, OnlineModel};
use underbrush_classifier::decision::Verdict;
use underbrush_classifier::trial::Unit;
use underbrush_classifier::{OnlineOptions, ScoreKind, Scores};

use super::touch::TouchDecisionArguments;
use super::{DecisionArguments, score};
use crate::options::{TrialArguments, named};
use crate::{Failure, input, output};

/// Shown at the end of `underbrush classify --help`.
const PROTOCOL: &str = "\
The live stream: with `-` as input each line on stdin is one frame as a JSON object, and each is answered by one line on \
stdout before the next is read. docs/live-stream.md describes all of it.

  in   {\"time_s\":0.01,\"taxels\":[{\"patch\":\"forearm\",\"taxel\":18,\"sensed_force_n\":0.4}]}
  out  {\"time_s\":0.01,\"taxels\":[{\"taxel\":18,\"samples\":1,\"verdict\":\"leaf\",\"scores\":{\"leaf\":3.0,\"trunk\":1.3}}]}

A patch is named, or given by its index in the skin. Taxels that feel nothing may be left out. Models that use motion \
need the pose of the link under the patch, too:

  in   {…,\"patch_pose_world\":{\"forearm\":{\"position\":[0.3,-0.2,0.1],\"orientation\":[0,0,0,1]}}}

Other fields, such as those of a recording's frame, are ignored. A bad line is answered with its number and what is wrong, \
and otherwise ignored:

  out  {\"error\":{\"allowed\":\"a number from 0 to 10000 N\",\"field\":\"taxels[0].sensed_force_n\",\"found\":\"-5\"},\"line\":12}

A new reach begins with {\"reset\":true}: contacts end, and time may start again at 0.";

/// Options of `underbrush classify`.
#[derive(Args)]
#[command(after_help = PROTOCOL)]
pub struct ClassifyOptions {
    /// Model file
    model: PathBuf,
    /// Data set (folder), recording, folder of recordings, table of trials, or `-`: frames as JSON lines on stdin, each
    /// answered before the next is read
    input: PathBuf,
    /// Give a verdict for each taxel in contact in each frame, as JSON lines. A touch model always does
    #[arg(long)]
    online: bool,
    /// With `-`: the skin, from a data set, a recording, the file of an arm or a skin file; Cody's if not given
    #[arg(long, value_name = "PATH")]
    skin: Option<PathBuf>,
    /// With `-`: end with exit status 2 at the first bad line
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    decision: DecisionArguments,
    /// Kind of score of hidden Markov models [default: the model's own]
    #[arg(long, value_parser = named::<ScoreKind>(&score::KINDS))]
    score: Option<ScoreKind>,
    #[command(flatten)]
    cut: TrialArguments,
    #[command(flatten, next_help_heading = "Verdicts of touch models")]
    touch: TouchDecisionArguments,
}

#[derive(Serialize)]
struct TrialVerdict {
    trial: u64,
    verdict: Verdict,
    truth: Option<String>,
    scores: BTreeMap<String, f64>,
}

/// Classifies.
pub fn run(options: ClassifyOptions, json: bool) -> Result<(), Failure> {
    let model = any_model::load(&options.model)?;
    let is_stream = options.input == Path::new("-");
    if !is_stream && (options.skin.is_some() || options.strict) {
        let text = "--skin and --strict are for frames on standard input, `-`; leave them out: a file stores its skin";
        return Err(Failure::usage(text));
    }
    let model = match model {
        AnyModel::Touch(mut model) => {
            options.decision.refuse_for_touch_model(options.score.map(|_| "--score".to_owned()))?;
            options.cut.refuse_for_touch_model()?;
            model.decision = options.touch.over(model.decision);
            return online::run(&options, &OnlineModel::Touch(Arc::from(model)));
        }
        AnyModel::OfTrials(model) => score::by_kind(model, &options.model, options.score, "--score")?,
    };
    options.touch.refuse_for_trials()?;
    if options.online || is_stream {
        let online = "online verdicts, which are given for each taxel from its first sample on";
        options.cut.refuse_but(&TrialArguments::OF_CONTACTS, online)?;
        let decision = options.decision.decision(&Scores::of_model(&model))?;
        let settings = OnlineOptions::new(options.cut.patch.clone(), Some(options.cut.threshold_n()), decision);
        model.provenance.warn_of_unit("frame by frame", Some(Unit::Taxel));
        return online::run(&options, &OnlineModel::OfTrials(Box::new(model), settings));
    }
    let categories = model.classifier.categories();
    let judge = options.decision.decision(&Scores::of_model(&model))?.prepare(&categories)?;
    let read = input::any_trials(&options.input, &options.cut)?;
    let scores = score::of_trials(&model, &read, &options.input)?;
    let verdicts = read.trials.iter().zip(scores).map(|(trial, scores)| TrialVerdict {
        trial: trial.trial,
        verdict: judge.choose(&scores),
        truth: trial.category.clone(),
        scores: categories.iter().cloned().zip(scores).collect(),
    });
    let verdicts: Vec<TrialVerdict> = verdicts.collect();
    output::csv(json, "verdicts", &verdicts, |rows| {
        rows.column("trial", |row| row.trial.to_string())
            .column("verdict", |row| row.verdict.name())
            .column("truth", |row| row.truth.clone().unwrap_or_default())
    })
}
