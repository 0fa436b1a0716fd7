//! How readings become contacts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::trial::TrialOptions;

/// The patch, and the force above which a taxel is in contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TouchOptions {
    /// Name of the patch; the skin's first if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch: Option<String>,
    /// A taxel is in contact while its sensed force is above this, N.
    #[schemars(range(min = 0.0))]
    pub threshold_n: f64,
}

impl Default for TouchOptions {
    /// The patch and threshold of [`TrialOptions::default`].
    fn default() -> Self {
        let trials = TrialOptions::default();
        TouchOptions { patch: trials.patch, threshold_n: trials.threshold_n }
    }
}
