//! The keys of an experiment file.

use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use underbrush_classifier::registry::{self, CLASSIFIERS};
use underbrush_classifier::trial::Unit;
use underbrush_classifier::{ClassifierKind, Estimator, FeatureSet, Recipe, ThresholdTargets};
use underbrush_sim::controller::ControllerKind;
use underbrush_sim::scene::RobotSection;

/// An experiment: which scenes to train and test on, which classifiers, and what to compare the results with.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExperimentFile {
    /// Title of the report.
    pub title: String,
    /// First paragraph of the report: what the experiment is about.
    #[serde(default)]
    pub introduction: String,
    /// Seed, unless `--seed` gives another.
    #[serde(default)]
    pub seed: u64,
    /// Arm file for all scenes, relative to this file. By default each scene uses its own.
    pub arm: Option<String>,
    /// Controller for all scenes. By default each scene uses its own.
    pub controller: Option<ControllerKind>,
    /// How contact trials are cut from the reaches.
    #[serde(default)]
    pub trials: TrialSection,
    /// Scenes that classifiers are trained on and cross-validated with: at least two, with different labels.
    pub training: Vec<TrainingScene>,
    /// Numbers of hidden states in the cross-validation table.
    #[serde(default = "default_states")]
    pub states: Vec<usize>,
    /// Recipes of the hidden Markov models in the cross-validation table. The first is used everywhere else, and alone in
    /// quick runs.
    #[serde(default = "default_recipes")]
    pub recipes: Vec<RecipeName>,
    /// Classifiers to compare; none if not given. Quick runs compare them on whole trials only.
    #[serde(default)]
    pub classifiers: Vec<ClassifierEntry>,
    /// Lengths to which trials are truncated, in samples, to see how much accuracy that costs.
    #[serde(default)]
    pub truncations: Vec<usize>,
    /// Decision thresholds.
    #[serde(default)]
    pub thresholds: ThresholdSection,
    /// Scenes that hold one category alone. Online verdicts are tested on one reach of each.
    #[serde(default)]
    pub engineered: Vec<EngineeredScene>,
    /// A scene in which the arm touches every category.
    pub general: Option<TestScene>,
    /// A scene in which the arm touches an outlier first and then a known category.
    pub outlier: Option<TestScene>,
    /// A scene with another outlier, on which nothing was chosen. Verdicts on what touches the skin are tested on it. Left
    /// out of quick runs.
    pub second_outlier: Option<TestScene>,
    /// Verdicts on what touches each taxel, frame by frame; left out if not given.
    pub verdicts: Option<VerdictSection>,
    /// Reaches on which controllers are compared. Left out of quick runs, and if not given.
    pub controllers: Option<ControllerSection>,
    /// Arm stiffnesses and hand speeds to train and test at, in addition to the scenes' own. Left out of quick runs.
    #[serde(default)]
    pub settings: Vec<Setting>,
    /// Classifiers that are trained and tested at each of these settings.
    #[serde(default)]
    pub setting_classifiers: Vec<ClassifierEntry>,
    /// Changes to make one at a time, each with its own cross-validation table. Left out of quick runs.
    #[serde(default)]
    pub ablation: Vec<AblationName>,
    /// Seeds on which parameters were chosen, so that the report can say whether a run used them.
    #[serde(default)]
    pub chosen_on: Vec<ChosenOn>,
    /// Published figures to compare with. Without them, the report leaves the comparison out.
    pub published: Option<Published>,
}

fn default_states() -> Vec<usize> {
    vec![10]
}

fn default_recipes() -> Vec<RecipeName> {
    vec![RecipeName::Authors]
}

/// How trials are cut.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrialSection {
    /// Patch of skin; the first if not given.
    pub patch: Option<String>,
    /// A taxel is in contact where its sensed force is above this, N.
    pub threshold_n: f64,
    /// Trials of fewer samples are left out of training and of the tables.
    pub min_samples: usize,
}

impl Default for TrialSection {
    fn default() -> Self {
        let paper = underbrush_classifier::trial::TrialOptions::paper();
        TrialSection { patch: paper.patch, threshold_n: paper.threshold_n, min_samples: paper.min_samples }
    }
}

/// A scene that classifiers are trained on.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrainingScene {
    /// Scene: the name of one that ships, such as mixed, or a scene file, relative to this file.
    pub scene: String,
    /// Category of every trial from this scene.
    pub label: String,
    /// Number of reaches.
    pub reaches: u64,
    /// Number of reaches with `--quick`; if not given a third, rounded up, and at least two.
    pub quick_reaches: Option<u64>,
    /// Number of reaches at each of `settings`; half if not given.
    pub setting_reaches: Option<u64>,
}

impl TrainingScene {
    /// Number of reaches at each setting, at least two and at most as many as in the run itself.
    pub fn setting_reaches(&self) -> u64 {
        self.setting_reaches.unwrap_or(self.reaches.div_ceil(2).max(2)).min(self.reaches)
    }
}

/// A scene with one category, for online tests.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineeredScene {
    /// Scene, as in `training`. Its objects, or its `stream`, differ from those of the training scenes.
    pub scene: String,
    /// Category that the skin must touch, and nothing else: a label of the training scenes.
    pub label: String,
    /// Reaches are drawn until one does what it should, but no more than this many; only one with `--quick`.
    #[serde(default = "default_draws")]
    pub max_draws: u64,
}

fn default_draws() -> u64 {
    8
}

/// A scene for online tests.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestScene {
    /// Scene, as in `training`. Its objects, or its `stream`, differ from those of the training scenes.
    pub scene: String,
    /// Number of reaches to test on; one with `--quick`.
    pub reaches: usize,
    /// Reaches are drawn until enough of them do what they should, but no more than this many, nor than two with `--quick`.
    #[serde(default = "default_draws")]
    pub max_draws: u64,
}

/// What verdicts on each taxel are learned from, in addition to the training scenes.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VerdictSection {
    /// A scene in which the arm touches every category. Its reaches differ from those of `general`.
    pub scene: String,
    /// Scenes of unknown objects to train on, with as many reaches each. Left out of quick runs: without them nothing is
    /// called unknown.
    #[serde(default)]
    pub auxiliary: Vec<String>,
    /// Number of reaches.
    pub reaches: u64,
    /// Number of reaches with `--quick`; a third, rounded up, if not given.
    pub quick_reaches: Option<u64>,
}

/// Reaches on which the published controller is compared with the one that maps what it touches.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerSection {
    /// A scene, as in `training`.
    pub scene: String,
    /// Number of reaches.
    pub reaches: u64,
}

/// A recipe for hidden Markov models, in the order of [`Recipe::PRESETS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RecipeName {
    /// The authors' nearest published code: score by the Viterbi path, unscaled features.
    Authors,
    /// What one would choose today: forward likelihood, z-scored features.
    Modern,
}

impl RecipeName {
    /// Its name in files and tables.
    pub fn name(self) -> &'static str {
        Recipe::PRESETS[self as usize].0
    }

    /// The recipe with this name.
    pub fn recipe(self) -> Recipe {
        Recipe::PRESETS[self as usize].1()
    }
}

/// A classifier to compare.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClassifierEntry {
    /// Name in tables and charts.
    pub name: String,
    /// Name of the classifier, as for `train --classifier`.
    #[serde(deserialize_with = "classifier")]
    #[schemars(with = "String", extend("enum" = CLASSIFIERS.map(|kind| kind.name)))]
    pub method: &'static ClassifierKind,
    /// Features of each sample, as for `train --features`; the classifier's own if not given.
    #[serde(default, deserialize_with = "some_features")]
    #[schemars(with = "Option<Vec<String>>")]
    pub features: Option<FeatureSet>,
    /// Number of hidden states, for `hmm`; 10 if not given.
    pub states: Option<usize>,
}

impl ClassifierEntry {
    /// Whether it is of hidden Markov models.
    pub fn is_hmm(&self) -> bool {
        self.method.name == "hmm"
    }

    /// The classifier that it describes; `recipe` is for hidden Markov models.
    pub fn estimator(&self, recipe: &Recipe) -> Box<dyn Estimator> {
        if !self.is_hmm() {
            return (self.method.estimator)(self.features);
        }
        Box::new(Recipe {
            states: self.states.unwrap_or(recipe.states),
            features: self.features.unwrap_or(recipe.features),
            ..recipe.clone()
        })
    }
}

/// Reads the name of a classifier.
fn classifier<'de, D: Deserializer<'de>>(deserializer: D) -> Result<&'static ClassifierKind, D::Error> {
    let name = String::deserialize(deserializer)?;
    registry::find(&name).ok_or_else(|| {
        let names = CLASSIFIERS.map(|kind| kind.name).join(", ");
        D::Error::custom(format!("unknown classifier `{name}`, expected one of {names}"))
    })
}

/// Reads a list of features that simulated trials have.
fn features<'de, D: Deserializer<'de>>(deserializer: D) -> Result<FeatureSet, D::Error> {
    let names = Vec::<String>::deserialize(deserializer)?;
    let features = FeatureSet::from_names(&names).map_err(D::Error::custom)?;
    match features.channels().next() {
        Some(channel) => Err(D::Error::custom(format!(
            "the feature {} is of tables; simulated trials have no such column",
            channel.name
        ))),
        None => Ok(features),
    }
}

/// Reads a list of features that may be left out.
fn some_features<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<FeatureSet>, D::Error> {
    features(deserializer).map(Some)
}

/// Decision thresholds.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ThresholdSection {
    /// Margin below which a taxel is uncertain online, nats.
    pub uncertain_below_nats: f64,
    /// Thresholds are chosen so that at most this share of the other categories' trials is taken for a category.
    pub false_positive_rate: f64,
    /// Share of contacts expected to be outliers.
    pub outlier_prior: f64,
}

impl Default for ThresholdSection {
    /// The margin is the paper's for outliers (section V-D). The two rates are choices: one in twenty each.
    fn default() -> Self {
        ThresholdSection {
            uncertain_below_nats: 15.0,
            false_positive_rate: 0.05,
            outlier_prior: ThresholdTargets::OUTLIER_PRIOR,
        }
    }
}

/// An arm stiffness and hand speed.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Name in tables.
    pub name: String,
    /// What replaces the `[robot]` section of the training scenes.
    pub robot: RobotSection,
}

impl Setting {
    /// Name of the setting with the scenes' own arm and speed.
    pub const NOMINAL: &str = "nominal";
}

/// A change to the training reaches, or to how trials are cut from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AblationName {
    /// A trial's category is that of the object that touches the taxel, not the scene's label.
    LabelsByContact,
    /// Trials of any length are kept.
    TrialsOfAnyLength,
    /// No spurious readings.
    NoSpuriousReadings,
    /// No creep.
    NoCreep,
    /// The sensed force is the true force.
    PerfectSensor,
    /// The controller's own rule ends a goal, and each goal is retried once.
    NoPatience,
}

/// Seeds on which something was chosen.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChosenOn {
    /// First seed.
    pub first: u64,
    /// Last seed.
    pub last: u64,
    /// What was chosen.
    pub what: String,
}

/// Published figures.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Published {
    /// Trials per reach.
    pub trials: Vec<PublishedTrials>,
    /// Cells of the cross-validation table.
    pub accuracy: Vec<PublishedAccuracy>,
    /// Statements on the cells that the report checks.
    pub orderings: Vec<OrderingName>,
    /// The best published accuracy, per cent.
    pub best_accuracy_percent: Option<f64>,
    /// Mean number of samples that an online verdict used.
    pub samples_used: Option<f64>,
    /// Computation time of an online sample for 100 taxels in contact, s.
    pub seconds_per_100_taxels: Option<f64>,
    /// What is published on the subject of each section of the report, by the section's name.
    pub sections: std::collections::BTreeMap<String, PublishedSection>,
}

impl Published {
    /// The published number of trials per reach.
    pub fn trials_per_reach(&self, by: Unit, label: &str) -> Option<f64> {
        let own = self.trials.iter().find(|own| own.by == by && own.label == label);
        own.map(|own| own.trials / own.reaches)
    }

    /// The published accuracy of a cell, per cent.
    pub fn accuracy_percent(&self, by: Unit, features: FeatureSet, states: usize) -> Option<f64> {
        let own = |own: &&PublishedAccuracy| own.by == by && own.features == features && own.states == states;
        self.accuracy.iter().find(own).map(|own| own.percent)
    }
}

/// Published number of trials.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedTrials {
    /// What a trial is made of.
    pub by: Unit,
    /// Label of the training scene.
    pub label: String,
    /// Trials in all reaches.
    pub trials: f64,
    /// Reaches.
    pub reaches: f64,
}

/// A published cell of the cross-validation table.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedAccuracy {
    /// What a trial is made of.
    pub by: Unit,
    /// The features, such as `["force", "motion"]`.
    #[serde(deserialize_with = "features")]
    #[schemars(with = "Vec<String>")]
    pub features: FeatureSet,
    /// Number of hidden states.
    pub states: usize,
    /// Accuracy, per cent.
    pub percent: f64,
}

/// A statement on how the cells of the cross-validation table compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OrderingName {
    /// Taxels are told apart better than components.
    TaxelsOverComponents,
    /// Force alone is at least as good as force and motion.
    ForceOverForceAndMotion,
    /// More states are better than the fewest.
    MoreStates,
}

/// What is published on the subject of a section.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedSection {
    /// Number of the published figure or table, such as `Fig. 13`.
    pub figure: Option<String>,
    /// What it shows.
    pub statement: String,
}
