//! The keys of a suite file.

use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_classifier::decision::Rule;
use underbrush_sim::controller::ControllerKind;

use super::bound::Bounds;

/// The keys of a suite file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteFile {
    /// One sentence on what the suite checks.
    pub summary: String,
    /// Seed of all reaches.
    #[serde(default)]
    pub seed: u64,
    /// Controller to use instead of each scene's.
    pub controller: Option<ControllerKind>,
    /// The classifier whose verdicts are bounded.
    pub model: Option<ModelSection>,
    /// How `--bless` computes bounds.
    #[serde(default)]
    pub bless: BlessSection,
    /// The scenes.
    pub scenes: Vec<SceneEntry>,
}

/// A classifier, used online on every reach.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelSection {
    /// Model file of any classifier, relative to the suite file. A touch model has its own patch, threshold and
    /// decision.
    pub file: String,
    /// Patch of skin that is classified; the first if not given.
    pub patch: Option<String>,
    /// A taxel is in contact where its sensed force is above this, N; as for `underbrush train` and `classify` if not
    /// given.
    pub threshold_n: Option<f64>,
    /// Rule to use instead of the model's own: `"argmax"`, `{ uncertain_below = { margin = NATS } }` or
    /// `{ outlier_band = { uncertain_below = NATS, category_above = NATS } }`. A model without one uses `argmax`.
    pub rule: Option<Rule>,
}

/// How `--bless` computes bounds.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BlessSection {
    /// The probability that reaches of another seed break any of the suite's bounds on means and shares.
    pub false_alarm: f64,
    /// A bound on the largest value of all reaches is this many times what was found.
    pub largest_factor: f64,
}

impl Default for BlessSection {
    /// Choices: a program that only draws other random numbers is refused once in a hundred times. A largest value, for
    /// which there is no such theory, may grow by half.
    fn default() -> Self {
        BlessSection { false_alarm: 0.01, largest_factor: 1.5 }
    }
}

/// A scene with its bounds.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneEntry {
    /// Scene file, relative to the suite file.
    pub scene: String,
    /// Number of reaches: indices 0, 1, … of the suite's seed, each a draw of its own.
    pub reaches: u64,
    /// The bounds, by metric.
    #[serde(default)]
    pub bounds: Bounds,
}
