//! The classifier `touch`, which judges frames instead of trials: options and work of the commands that use it. Here are the options
//! for turning probabilities into verdicts, and for how many bad ones a fitted model may give.

mod fit;
mod text;

use clap::Args;
use clap::builder::TypedValueParser;
use serde::Serialize;
use underbrush_classifier::touch::TouchDecision;

use crate::Failure;
use crate::options::{self, number};

pub use fit::{Judge, SimulatedArguments, evaluate, train};

/// How probabilities become verdicts. Options that are not given stay as in the model.
#[derive(Args, Clone, Debug, Serialize)]
pub struct TouchDecisionArguments {
    /// Call a reading nothing if the probability that nothing presses on the taxel is above this [default: as chosen in
    /// training, so that few true contacts are lost]
    #[arg(long, value_name = "P", value_parser = share())]
    nothing_above: Option<f64>,
    /// Call an object unknown if at most this share of the objects of each known category is as unlike what is known as the
    /// object is (in its first 0.6 s: a fifth of this share). This is the share of false alarms. Shares below 0.001 are not
    /// distinguished. A model that was trained without --auxiliary calls nothing unknown [default: as in the model, 0.05
    /// after training]
    #[arg(long, value_name = "P", value_parser = share())]
    unknown_share: Option<f64>,
    /// Cost of an uncertain verdict relative to that of a wrong category: a category is named if its probability is
    /// above 1 minus this [default: as in the model, 0.3 after training]
    #[arg(long, value_name = "COST", value_parser = share())]
    pub cost_of_uncertain: Option<f64>,
}

fn share() -> impl TypedValueParser<Value = f64> {
    number(|value: &f64| (0.0..=1.0).contains(value), "must be a number from 0 to 1")
}

impl TouchDecisionArguments {
    /// Refuses options that would be ignored, because verdicts come from a classifier of trials.
    pub fn refuse_for_trials(&self) -> Result<(), Failure> {
        let reason =
            "applies to the classifier touch only, and this is a classifier of trials, which --decision is for";
        options::refuse(options::given(self), reason)
    }

    /// The decision with the options that are given.
    pub fn over(&self, own: TouchDecision) -> TouchDecision {
        TouchDecision {
            nothing_above: self.nothing_above.unwrap_or(own.nothing_above),
            unknown_share: self.unknown_share.unwrap_or(own.unknown_share),
            cost_of_uncertain: self.cost_of_uncertain.unwrap_or(own.cost_of_uncertain),
        }
    }
}

/// Limits on the bad verdicts in new reaches. Options that are not given stay at their defaults.
#[derive(Args, Clone, Copy, Debug, Default, Serialize)]
pub struct RiskArguments {
    /// Choose the cost of an uncertain verdict so that at most this share of the taxel frames of a new reach is called
    /// another category, on average over reaches. A share of 0.05 needs 19 reaches or more, 0.01 needs 99
    #[arg(long, value_name = "SHARE", value_parser = number(|share: &f64| *share > 0.0 && *share < 1.0, "must be a number above 0 and below 1"))]
    pub limit_wrong: Option<f64>,
}

impl RiskArguments {
    /// Refuses options that would be ignored, for the reason given.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        options::refuse(options::given(self), reason)
    }
}
