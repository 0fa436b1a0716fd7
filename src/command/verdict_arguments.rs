//! Options about verdicts: how scores become verdicts, and which verdicts a controller is told.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::{Decision, Rule, Scores};
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_sim::scene::limits::ALLOWED_FORCE_N;

use crate::{Failure, options};

/// How scores become verdicts.
#[derive(Args, Serialize)]
pub struct DecisionArguments {
    /// How scores become verdicts [default: the model's own rule (train --false-positive-rate), or argmax if it has
    /// none]
    #[arg(long, value_enum)]
    decision: Option<DecisionName>,
    /// With `--decision uncertain`: margin of the best category below which a verdict is uncertain, nats [default: 15]
    #[arg(
        long,
        alias = "lead",
        value_name = "NATS",
        value_parser = options::number(|_: &f64| true, "must be a number of nats")
    )]
    margin: Option<f64>,
    /// Prior of a category, such as leaf=0.7 [default: the model's own priors, or equal ones if it has none]
    #[arg(long, value_name = "CATEGORY=P", value_parser = prior)]
    prior: Vec<(String, f64)>,
}

#[derive(Clone, Copy, PartialEq, Serialize, ValueEnum)]
enum DecisionName {
    /// The best category
    Argmax,
    /// The best category, or uncertain below a margin
    Uncertain,
    /// The paper's thresholds: a category if the margin is above 80, an outlier from 15 to 80, uncertain below 15. Only
    /// for Viterbi scores of hidden Markov models of unscaled force
    Paper,
}

fn prior(text: &str) -> Result<(String, f64), String> {
    options::pair(text, '=').ok_or_else(|| "must be CATEGORY=P, such as leaf=0.7".into())
}

impl DecisionArguments {
    /// Refuses options that a touch model would ignore: these, and another one if it is given.
    pub fn refuse_for_touch_model(&self, other: Option<String>) -> Result<(), Failure> {
        let reason = "does not apply to a touch model, whose verdicts rest on probabilities; use --nothing-above, \
                      --unknown-share and --cost-of-uncertain";
        options::refuse(options::given(self).into_iter().chain(other), reason)
    }

    /// The decision for these scores.
    ///
    /// # Errors
    /// If an option does not apply to these scores.
    pub fn decision(&self, scores: &Scores) -> Result<Decision, Failure> {
        if self.margin.is_some() && self.decision != Some(DecisionName::Uncertain) {
            let text = "--margin applies to --decision uncertain only; add that, or leave --margin out";
            return Err(Failure::usage(text));
        }
        let rule = match self.decision {
            None => None,
            Some(DecisionName::Argmax) => Some(Rule::Argmax),
            Some(DecisionName::Uncertain) => Some(Rule::UncertainBelow { margin: self.margin.unwrap_or(15.0) }),
            Some(DecisionName::Paper) => {
                let refused = |error| Failure::usage(format!("--decision paper does not apply: {error}"));
                Some(scores.paper().map_err(refused)?)
            }
        };
        let decision = scores.decision(rule)?;
        let prior = self.prior.iter().cloned().collect();
        Ok(if self.prior.is_empty() { decision } else { Decision { prior, ..decision } })
    }
}

/// What tells the controller what the skin touches.
#[derive(Args)]
pub struct VerdictArguments {
    /// Tell the controller what the skin touches: the verdicts of this touch model, or the true categories (`truth`), which
    /// no robot knows. `none` tells it nothing
    #[arg(long, value_name = "MODEL|truth|none")]
    pub verdicts: Option<PathBuf>,
    /// With --verdicts: force with which the arm may press on objects of a category, or on `unknown` ones, N. It replaces
    /// the force in the scene
    #[arg(long, value_name = "CATEGORY=N", requires = "verdicts", value_parser = allowed)]
    pub allow: Vec<(String, f64)>,
}

fn allowed(text: &str) -> Result<(String, f64), String> {
    let read = options::pair(text, '=').filter(|(_, force_n)| ALLOWED_FORCE_N.hold(*force_n));
    read.ok_or_else(|| format!("must be a category and a force of {ALLOWED_FORCE_N}, such as leaf=6"))
}

impl VerdictArguments {
    /// The verdicts that the options ask for.
    ///
    /// # Errors
    /// If the model cannot be read, or `--allow` names something that no verdict says.
    pub fn control(&self) -> Result<Option<VerdictControl>, Failure> {
        match self.verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten() {
            Some(control) => Ok(Some(control.with_asked(self.allow.iter().cloned())?)),
            None if self.allow.is_empty() => Ok(None),
            None => Err(Failure::usage("--allow needs verdicts; give --verdicts a touch model or `truth`")),
        }
    }

    /// The file of the touch model, if there is one.
    pub fn model(&self) -> Option<PathBuf> {
        self.verdicts.clone().filter(|path| !["truth", "none"].map(PathBuf::from).contains(path))
    }
}
