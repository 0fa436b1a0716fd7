//! Options for turning scores into verdicts, for every command that gives verdicts.

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::{Decision, Rule, Scores};

use crate::{Failure, options};

/// How scores become verdicts.
#[derive(Args, Serialize)]
pub struct DecisionArguments {
    /// How scores become verdicts [default: the model's own rule (train --false-positive-rate), or argmax if it has
    /// none]
    #[arg(long, value_enum)]
    decision: Option<DecisionName>,
    /// With `--decision uncertain`: margin of the best category below which a verdict is uncertain, nats [default: 15]
    #[arg(long, alias = "lead", value_name = "NATS")]
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
            return Err(Failure::usage(
                "--margin applies to --decision uncertain only; add that, or leave --margin out",
            ));
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
        let mut decision = scores.decision(rule)?;
        let mut prior = BTreeMap::new();
        for (category, own) in self.prior.clone() {
            if prior.insert(category.clone(), own).is_some() {
                let text = format!("--prior is given twice for {category}; give it once for each category");
                return Err(Failure::usage(text));
            }
        }
        if !prior.is_empty() {
            decision.prior = prior;
        }
        Ok(decision)
    }
}
