//! Options for how many bad verdicts a fitted touch model may give.

use clap::Args;
use serde::Serialize;
use underbrush_classifier::touch::RiskLimits;

use crate::failure::Failure;
use crate::options;

/// Limits on the bad verdicts in new reaches. Options that are not given stay at their defaults.
#[derive(Args, Clone, Copy, Debug, Default, Serialize)]
pub struct RiskArguments {
    /// Choose the cost of an uncertain verdict so that at most this share of the taxel frames of a new reach is called
    /// another category, on average over reaches. A share of 0.05 needs 19 reaches or more, 0.01 needs 99
    #[arg(long, value_name = "SHARE", value_parser = share)]
    limit_wrong: Option<f64>,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("must be a number above 0 and below 1".into()),
    }
}

impl RiskArguments {
    /// Refuses options that would be ignored, for the reason given.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        options::refuse(options::given(self), reason)
    }

    /// The limits that are given.
    pub fn limits(&self) -> RiskLimits {
        RiskLimits { wrong: self.limit_wrong }
    }
}
