//! Options for turning scores into verdicts, for every command that gives verdicts.

use clap::{Args, ValueEnum};
use underbrush_classifier::Model;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::paper_rule;
use underbrush_classifier::recipe::Recipe;

use crate::failure::Failure;

/// How scores become verdicts.
#[derive(Args, Default)]
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

#[derive(Clone, Copy, PartialEq, ValueEnum)]
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
    let parse = || {
        let (category, value) = text.split_once('=')?;
        Some((category.to_string(), value.parse::<f64>().ok()?))
    };
    parse().ok_or_else(|| "must be CATEGORY=P, such as leaf=0.7".into())
}

/// The scores to be judged. Thresholds on a margin are valid for one kind of score only.
pub struct Scores<'a> {
    /// The decision stored with the models, if any.
    own: Option<&'a Decision>,
    /// Whether the models' own thresholds were chosen on this kind of score.
    are_own: bool,
    /// Why the paper's thresholds do not apply; `None` if they do.
    misfit: Option<String>,
}

impl<'a> Scores<'a> {
    /// Scores by this model.
    pub fn of_model(model: &'a Model) -> Self {
        Scores {
            own: model.decision.as_ref(),
            are_own: model.as_hmm().is_none_or(|models| models.score_kind() == models.own_score_kind()),
            misfit: paper_rule::misfit_of_model(model),
        }
    }

    /// Scores of hidden Markov models by this recipe, or of another classifier.
    pub fn of_recipe(recipe: Option<&Recipe>) -> Self {
        Scores { own: None, are_own: true, misfit: paper_rule::misfit_of_recipe(recipe) }
    }
}

/// Refuses an option that a touch model would ignore, if it was given.
pub fn refuse_for_touch_model(option: Option<&'static str>) -> Result<(), Failure> {
    match option {
        None => Ok(()),
        Some(option) => Err(Failure::usage(format!(
            "{option} does not apply to a touch model, whose verdicts rest on probabilities; use --nothing-above, \
             --unknown-share and --cost-of-uncertain, or leave it out"
        ))),
    }
}

impl DecisionArguments {
    /// The first given option.
    pub fn given(&self) -> Option<&'static str> {
        let options = [
            ("--decision", self.decision.is_some()),
            ("--margin", self.margin.is_some()),
            ("--prior", !self.prior.is_empty()),
        ];
        options.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Refuses options that a touch model would ignore.
    pub fn refuse_for_touch_model(&self) -> Result<(), Failure> {
        refuse_for_touch_model(self.given())
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
        let own = scores.own.cloned().unwrap_or(Decision::argmax());
        let rule = match (self.decision, &scores.misfit) {
            (None, _) if !scores.are_own && own.rule != Rule::Argmax => {
                return Err(Failure::usage(
                    "--score does not fit the thresholds in the model, which were chosen on its own kind of score; leave \
                     --score out, or choose a --decision",
                ));
            }
            (None, _) => own.rule,
            (Some(DecisionName::Argmax), _) => Rule::Argmax,
            (Some(DecisionName::Uncertain), _) => Rule::UncertainBelow { margin: self.margin.unwrap_or(15.0) },
            (Some(DecisionName::Paper), Some(misfit)) => {
                return Err(Failure::usage(format!(
                    "--decision paper does not apply: its thresholds of 15 and 80 nats belong to Viterbi scores of hidden \
                     Markov models of unscaled force, and {misfit}; use --decision uncertain with a --margin, or train \
                     --false-positive-rate"
                )));
            }
            (Some(DecisionName::Paper), None) => Decision::paper().rule,
        };
        for (place, (category, _)) in self.prior.iter().enumerate() {
            if self.prior[..place].iter().any(|(earlier, _)| earlier == category) {
                return Err(Failure::usage(format!(
                    "--prior is given twice for {category}; give it once for each category"
                )));
            }
        }
        let prior = match self.prior.is_empty() {
            true => own.prior,
            false => self.prior.iter().cloned().collect(),
        };
        Ok(Decision { prior, rule })
    }
}
