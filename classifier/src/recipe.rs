//! Recipes: every choice that makes a set of models from trials.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use underbrush_recording::Limits;

use crate::error::{ValueFault, check_limits};
use crate::feature::FeatureSet;
use crate::hmm::{InitialDistribution, ScoreKind, Topology, TrainingOptions};

/// States of a model: the paper has up to 20, and the cost of a sample grows with the square of their number.
pub const STATES: Limits = Limits::new(1.0, 1000.0, "states");

/// Samples of a trial that are used: up to 16 weeks at 100 Hz.
pub const SAMPLES: Limits = Limits::new(1.0, 1e9, "samples");

/// Iterations of Baum-Welch, which usually converges within hundreds.
pub const ITERATIONS: Limits = Limits::new(0.0, 1e6, "iterations");

/// Relative gain at which training ends. With 1 it ends after the first iteration.
pub const TOLERANCE: Limits = Limits::new(0.0, 1.0, "");

/// Floor of variances: at least the smallest variance that a model file may hold, or 0 for no floor.
pub const VARIANCE_FLOOR: Limits = Limits::new(1e-30, 1e12, "").or_off_at(0.0);

/// Whether the models use features as measured or z-scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScalingKind {
    /// As measured, N and m.
    Unscaled,
    /// Zero mean and unit standard deviation over all training samples; see [`crate::feature::Scaling`].
    ZScore,
}

/// How models are started, trained and scored. Stored in the model file, so that results can be traced to it.
///
/// ```
/// use underbrush_classifier::feature::FeatureSet;
/// use underbrush_classifier::recipe::Recipe;
///
/// let recipe = Recipe { states: 5, features: FeatureSet::FORCE_AND_MOTION, ..Recipe::authors() };
/// assert_eq!(recipe.topology, Recipe::authors().topology);
/// assert_eq!(Recipe::PRESETS.map(|(name, _)| name), ["authors", "modern"]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    /// States of each model.
    #[schemars(range(min = STATES.min, max = STATES.max))]
    pub states: usize,
    /// Features of a sample that the models use.
    pub features: FeatureSet,
    /// Allowed transitions.
    pub topology: Topology,
    /// Distribution of the first state.
    pub initial: InitialDistribution,
    /// Kind of score of a trial.
    pub score: ScoreKind,
    /// Whether features are scaled.
    pub scaling: ScalingKind,
    /// Number of samples used at the start of each trial, in training and in scoring (paper, section V-C); `None` for
    /// all.
    #[schemars(range(min = SAMPLES.min, max = SAMPLES.max))]
    pub max_samples: Option<usize>,
    /// Options of Baum-Welch.
    pub training: TrainingOptions,
}

/// A function that makes one of the named recipes.
pub type Preset = fn() -> Recipe;

impl Recipe {
    /// The presets, with their names as options. The first is the default.
    pub const PRESETS: [(&'static str, Preset); 2] = [("authors", Recipe::authors), ("modern", Recipe::modern)];

    /// The recipe of the authors' nearest published code: left-to-right with skips, uniform start distribution,
    /// variance floor 1e-4, unscaled features, score by the Viterbi path; 10 states and force, as in the paper's online
    /// experiment (section V-B).
    ///
    /// Unscaled, the floor of 1e-4 is (0.01 N)² but also (1 cm)², so contact motion is blurred to about a centimetre.
    pub fn authors() -> Self {
        Recipe {
            states: 10,
            features: FeatureSet::FORCE,
            topology: Topology::LeftToRight,
            initial: InitialDistribution::Uniform,
            score: ScoreKind::Viterbi,
            scaling: ScalingKind::Unscaled,
            max_samples: None,
            training: TrainingOptions::default(),
        }
    }

    /// The recipe that one would choose today: the forward likelihood of eq. 2 as score, and z-scored features, so that
    /// the variance floor means the same (a hundredth of the data's deviation) for every feature.
    pub fn modern() -> Self {
        Recipe { score: ScoreKind::Forward, scaling: ScalingKind::ZScore, ..Recipe::authors() }
    }

    /// Checks that every number is within its range.
    pub(crate) fn check(&self) -> Result<(), ValueFault> {
        check_limits("states", self.states as f64, STATES)?;
        check_limits("max_samples", self.max_samples.map_or(1.0, |count| count as f64), SAMPLES)?;
        check_training(&self.training)
    }
}

/// Checks that every option of Baum-Welch is within its range.
pub(crate) fn check_training(training: &TrainingOptions) -> Result<(), ValueFault> {
    check_limits("training.iterations", training.iterations as f64, ITERATIONS)?;
    check_limits("training.tolerance", training.tolerance, TOLERANCE)?;
    check_limits("training.variance_floor", training.variance_floor, VARIANCE_FLOOR)
}
