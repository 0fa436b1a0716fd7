//! How readings become contacts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::SkinLayout;

use crate::trial::TrialOptions;

/// The patch, and the force above which a taxel is in contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TouchOptions {
    /// Name of the only patch that is judged. If left out, `all_patches` decides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch: Option<String>,
    /// Whether all patches are judged if none is named; else the skin's first is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub all_patches: bool,
    /// A taxel is in contact while its sensed force is above this, N.
    #[schemars(range(min = 0.0))]
    pub threshold_n: f64,
}

impl Default for TouchOptions {
    /// All patches, and the threshold of [`TrialOptions::default`].
    fn default() -> Self {
        TouchOptions::of(None, TrialOptions::default().threshold_n)
    }
}

impl TouchOptions {
    /// The named patch, or all patches; and the force above which a taxel is in contact, N.
    pub fn of(patch: Option<String>, threshold_n: f64) -> Self {
        TouchOptions { all_patches: patch.is_none(), patch, threshold_n }
    }

    /// The indices of the patches that are judged; empty if the skin lacks the named one.
    pub fn judged_patches(&self, layout: &SkinLayout) -> Vec<usize> {
        match &self.patch {
            None if self.all_patches => (0..layout.patches.len()).collect(),
            patch => layout.chosen_patch(patch.as_deref()).into_iter().collect(),
        }
    }
}
