//! `underbrush classify`: a verdict for each trial, or for each taxel in contact as frames come in.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::ModelSet;
use underbrush_classifier::decision::{Decision, Rule, Verdict};
use underbrush_classifier::hmm::ScoreKind;
use underbrush_classifier::online::{OnlineClassifier, OnlineOptions};
use underbrush_recording::disk::{Dataset, read_recording};
use underbrush_recording::{Frame, InputError, SkinLayout};
use underbrush_sim::arm::Arm;

use super::score::Score;
use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// What `underbrush classify --help` says of the stream.
const PROTOCOL: &str = "\
With `-`, one frame a line on stdin, as a JSON object with the fields of a recording's frame (recording/src/frame.rs), \
for the skin of Cody; each line is answered by one line on stdout before the next is read:

  in   {\"time_s\":0.01,…,\"patch_pose_world\":[…],\"taxels\":[{\"patch\":0,\"taxel\":18,\"sensed_force_n\":0.4,…}]}
  out  {\"time_s\":0.01,\"taxels\":[{\"taxel\":18,\"samples\":1,\"verdict\":\"leaf\",\"scores\":{\"leaf\":3.0,\"trunk\":1.3}}]}

Taxels that are not in contact are not answered; a contact begins where a taxel first senses more than --threshold-n and \
ends where it does not. How long answers took stands on stderr at the end.";

/// Options of `underbrush classify`.
#[derive(Args)]
#[command(after_help = PROTOCOL)]
pub struct Options {
    /// Model file
    model: PathBuf,
    /// Data set (folder), recording, table of trials, or `-`: frames as JSON lines on stdin, each answered before the
    /// next is read
    input: PathBuf,
    /// Give a verdict for each taxel in contact in each frame, as JSON lines
    #[arg(long)]
    online: bool,
    #[command(flatten)]
    decision: DecisionArguments,
    /// Score; the model's own if not given
    #[arg(long, value_enum)]
    score: Option<Score>,
    #[command(flatten)]
    cut: TrialArguments,
}

/// How scores become verdicts.
#[derive(Args)]
pub struct DecisionArguments {
    /// From log-likelihoods to verdicts; the model's own if not given (train --false-positive-rate), argmax if it has none
    #[arg(long, value_enum)]
    decision: Option<DecisionName>,
    /// With `--decision uncertain`: least lead of the best category, nats
    #[arg(long, value_name = "NATS", default_value_t = 15.0)]
    lead: f64,
    /// Prior of a category, such as leaf=0.7; the model's own if none is given, all alike if it has none
    #[arg(long, value_name = "CATEGORY=P", value_parser = prior)]
    prior: Vec<(String, f64)>,
}

#[derive(Clone, Copy, ValueEnum)]
enum DecisionName {
    /// The best category
    Argmax,
    /// The best category, uncertain below a lead
    Uncertain,
    /// The paper's thresholds: lead over 80 a category, 15 to 80 an outlier, under 15 uncertain
    Paper,
}

fn prior(text: &str) -> Result<(String, f64), String> {
    let parse = || {
        let (category, value) = text.split_once('=')?;
        Some((category.to_string(), value.parse::<f64>().ok()?))
    };
    parse().ok_or_else(|| "must be CATEGORY=P, such as leaf=0.7".into())
}

impl DecisionArguments {
    /// The decision for models that come with this one.
    pub fn decision(&self, own: Option<&Decision>) -> Decision {
        let own = own.cloned().unwrap_or(Decision::argmax());
        let rule = match self.decision {
            None => own.rule,
            Some(DecisionName::Argmax) => Decision::argmax().rule,
            Some(DecisionName::Uncertain) => Rule::UncertainBelow { lead: self.lead },
            Some(DecisionName::Paper) => Decision::paper().rule,
        };
        let prior = match self.prior.is_empty() {
            true => own.prior,
            false => self.prior.iter().cloned().collect(),
        };
        Decision { prior, rule }
    }
}

#[derive(Serialize)]
struct TrialVerdict {
    trial: u64,
    verdict: Verdict,
    truth: Option<String>,
    scores: BTreeMap<String, f64>,
}

/// Classifies.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let models = ModelSet::load(&options.model)?;
    let kind = options.score.map_or(models.score_kind(), ScoreKind::from);
    if options.online || options.input == Path::new("-") {
        return online(&options, models, kind);
    }
    let judge = options
        .decision
        .decision(models.decision.as_ref())
        .prepare(&models.categories())?;
    let trials = input::trials(&options.input, &options.cut)?;
    let scores = models
        .score_all(&trials.iter().collect::<Vec<_>>(), kind)
        .map_err(|error| Failure::from(error).about(&options.input))?;
    let categories = models.categories();
    let verdicts = trials.iter().zip(scores).map(|(trial, scores)| TrialVerdict {
        trial: trial.trial,
        verdict: judge.verdict(judge.choose(&scores)),
        truth: trial.category.clone(),
        scores: categories.iter().cloned().zip(scores).collect(),
    });
    let verdicts: Vec<TrialVerdict> = verdicts.collect();
    if json {
        return output::result(true, &serde_json::json!({ "verdicts": verdicts }), String::new);
    }
    let header = std::iter::once("trial,verdict,truth".to_string());
    let rows = verdicts
        .iter()
        .map(|row| format!("{},{},{}", row.trial, row.verdict, row.truth.as_deref().unwrap_or("")));
    output::lines(header.chain(rows))
}

#[derive(Serialize)]
struct FrameVerdicts<'a> {
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

/// One line of JSON out for each frame in.
fn online(options: &Options, models: ModelSet, kind: ScoreKind) -> Result<(), Failure> {
    let categories = models.categories();
    let settings = OnlineOptions {
        patch: options.cut.patch.clone(),
        threshold_n: options.cut.threshold_n,
        score: kind,
        decision: options.decision.decision(models.decision.as_ref()),
    };
    let start = |layout: &SkinLayout| OnlineClassifier::new(models.clone(), layout, &settings);
    let mut latency = Latency::default();
    let mut answer = |classifier: &mut OnlineClassifier, frame: &Frame, since: Instant| -> Result<(), Failure> {
        let taxels = classifier
            .update(frame)?
            .map(|taxel| TaxelLine {
                taxel: taxel.taxel,
                samples: taxel.samples,
                verdict: taxel.verdict.name(),
                scores: categories
                    .iter()
                    .map(String::as_str)
                    .zip(taxel.log_likelihood.iter().copied())
                    .collect(),
            })
            .collect();
        let line = serde_json::to_string(&FrameVerdicts {
            time_s: frame.time_s,
            taxels,
        });
        output::lines([line.map_err(|error| Failure::run(error.to_string()))?])?;
        latency.add(since);
        Ok(())
    };
    if options.input == Path::new("-") {
        let mut classifier = start(&Arm::cody()?.skin.layout)?;
        for (number, line) in std::io::stdin().lock().lines().enumerate() {
            let line = line.map_err(|error| Failure::run(format!("cannot read standard input: {error}")))?;
            let arrived = Instant::now();
            let frame: Frame = serde_json::from_str(&line).map_err(|error| {
                let allowed = "one frame as a JSON object a line, with the fields of a recording's frame";
                InputError::new("-", "frame", error.to_string(), allowed, "mend the line").at_line(number + 1)
            })?;
            answer(&mut classifier, &frame, arrived)?;
        }
    } else if options.input.is_dir() {
        let dataset = Dataset::open(&options.input)?;
        for episode in 0..dataset.episodes().len() {
            let recording = dataset.read_reach(episode)?;
            let mut classifier = start(&recording.layout)?;
            recording
                .frames
                .iter()
                .try_for_each(|frame| answer(&mut classifier, frame, Instant::now()))?;
        }
    } else {
        let allowed = "with --online, frames: a data set, a recording or `-`";
        input::check_exists(&options.input, allowed)?;
        if options.input.extension().is_some_and(|extension| extension == "csv") {
            let found = "a table of trials";
            return Err(InputError::new(&options.input, "input", found, allowed, "leave --online out").into());
        }
        let recording = read_recording(&options.input)?;
        let mut classifier = start(&recording.layout)?;
        recording
            .frames
            .iter()
            .try_for_each(|frame| answer(&mut classifier, frame, Instant::now()))?;
    }
    latency.report();
    Ok(())
}

/// How long answers took: from the frame's line, or from the frame where it is read from a file, until the answer is
/// written.
#[derive(Default)]
struct Latency {
    microseconds: Vec<f64>,
}

impl Latency {
    fn add(&mut self, since: Instant) {
        self.microseconds.push(1e6 * since.elapsed().as_secs_f64());
    }

    /// On stderr, where times of day belong: they are no result.
    fn report(mut self) {
        self.microseconds.sort_by(f64::total_cmp);
        let quantile = |q: f64| {
            let last = self.microseconds.len().checked_sub(1)?;
            self.microseconds.get((q * last as f64).round() as usize)
        };
        if let (Some(median), Some(high), Some(most)) = (quantile(0.5), quantile(0.99), quantile(1.0)) {
            output::remark(format!(
                "{} frames answered: median {median:.0} µs, 99 % within {high:.0} µs, at most {most:.0} µs",
                self.microseconds.len()
            ));
        }
    }
}
