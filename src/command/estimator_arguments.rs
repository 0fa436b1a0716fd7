//! Options that choose a classifier and how it is fitted; for every command that fits one.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;
use underbrush_classifier::feature::{FEATURES, FeatureSet};
use underbrush_classifier::fit_options::FitOptions;
use underbrush_classifier::hmm::{InitialDistribution, Topology, TrainingOptions};
use underbrush_classifier::recipe::{ITERATIONS, SAMPLES, STATES, TOLERANCE, VARIANCE_FLOOR};
use underbrush_classifier::registry::{self, CLASSIFIERS};
use underbrush_classifier::{ClassifierKind, Estimator, Recipe};

use crate::Failure;
use crate::options::{self, whole_within, within};

/// Which classifier is fitted, and how.
#[derive(Args, Clone, Debug)]
pub struct EstimatorArguments {
    /// Classifier to fit [default: hmm]
    #[arg(long, value_name = "NAME", value_parser = classifier())]
    classifier: Option<String>,
    #[arg(long, value_name = "LIST", help = features_help())]
    pub features: Option<FeatureSet>,
    #[command(flatten, next_help_heading = "Hidden Markov models (--classifier hmm) only")]
    recipe: RecipeArguments,
}

/// Name of the classifier of frames.
const TOUCH: &str = "touch";

/// The names in the list of classifiers, each with one line of help, and the name of the classifier of frames.
fn classifier() -> PossibleValuesParser {
    let touch = "Networks and trees over the course of contacts and objects: nothing, a category, uncertain or unknown in \
                 every frame. It is fitted to whole frames of data sets and recordings";
    let values = CLASSIFIERS.iter().map(|kind| PossibleValue::new(kind.name).aliases(kind.aliases).help(kind.summary));
    PossibleValuesParser::new(values.chain([PossibleValue::new(TOUCH).help(touch)]))
}

fn features_help() -> String {
    let list = FEATURES.map(|feature| format!("{} ({})", feature.name, feature.description)).join(", ");
    format!(
        "Features of each sample, joined by commas [default: force for hmm, each other classifier its own]: {list}, column:NAME \
         (any column of numbers in a table of trials)"
    )
}

impl EstimatorArguments {
    /// The classifier, not fitted yet.
    ///
    /// # Errors
    /// If an option does not apply to the classifier.
    pub fn estimator(&self) -> Result<Box<dyn Estimator>, Failure> {
        let kind = self.of_trials().ok_or_else(|| {
            Failure::usage(
                "--classifier touch is fitted to whole frames, not to trials; use train or evaluate with data sets or recordings",
            )
        })?;
        Ok(self.options()?.estimator(kind)?)
    }

    /// How it is fitted.
    ///
    /// # Errors
    /// If an option of hidden Markov models is given for another classifier.
    fn options(&self) -> Result<FitOptions, Failure> {
        if self.classifier_name() != "hmm" {
            let reason = "does not apply to this --classifier: it is about hidden Markov models";
            options::refuse(options::given(&self.recipe), reason)?;
        }
        let recipe = serde_json::to_value(&self.recipe).and_then(serde_json::from_value);
        let recipe = recipe.map_err(|error| Failure::usage(error.to_string()))?;
        Ok(FitOptions { features: self.features, ..recipe })
    }

    /// Whether the classifier of frames is chosen.
    ///
    /// # Errors
    /// If an option is given that does not apply to it.
    pub fn is_touch(&self) -> Result<bool, Failure> {
        if self.of_trials().is_some() {
            return Ok(false);
        }
        let reason = "does not apply to --classifier touch, whose features and networks are fixed";
        options::refuse(self.given(), reason).map(|()| true)
    }

    /// The recipe, if the classifier is hidden Markov models.
    ///
    /// # Errors
    /// If an option of hidden Markov models is given for another classifier.
    pub fn hmm(&self) -> Result<Option<Recipe>, Failure> {
        let Some(kind) = self.of_trials() else { return Ok(None) };
        Ok(self.options()?.recipe_of(kind)?)
    }

    /// The classifier of trials, the first of the list unless another is named; `None` for the classifier of frames.
    fn of_trials(&self) -> Option<&'static ClassifierKind> {
        self.classifier.as_ref().map_or(Some(CLASSIFIERS[0]), |name| registry::find(name))
    }

    /// Whether neither a classifier is chosen nor how hidden Markov models are fitted.
    pub fn is_open(&self) -> bool {
        self.classifier.is_none() && options::given(&self.recipe).is_empty()
    }

    /// Name of the classifier.
    pub fn classifier_name(&self) -> &'static str {
        self.of_trials().map_or(TOUCH, |kind| kind.name)
    }

    /// The given options about fitting.
    pub fn given(&self) -> Vec<String> {
        options::given(&self.recipe).into_iter().chain(self.features.map(|_| "--features".to_owned())).collect()
    }

    /// The options of Baum-Welch training.
    pub fn training(&self) -> Result<TrainingOptions, Failure> {
        Ok(self.options()?.recipe()?.training)
    }
}

/// How hidden Markov models are trained: the fields of [`FitOptions`] that the command line has. Each option is `None`
/// if it is not given, so that a command can refuse what it would ignore.
#[derive(Args, Clone, Debug, Default, Serialize)]
struct RecipeArguments {
    /// Preset; other options override it: the authors' recipe, or a modern one (forward score, z-scored features)
    /// [default: authors]
    #[arg(long, value_parser = names(&Recipe::PRESETS))]
    recipe: Option<String>,
    /// Hidden states of each model [default: 10]
    #[arg(long, value_name = "N", value_parser = whole_within(STATES))]
    states: Option<u32>,
    /// Allowed transitions between states [default: left-right]
    #[arg(long, value_parser = names(&Topology::NAMED))]
    topology: Option<String>,
    /// Distribution of the first state [default: uniform]
    #[arg(long, value_parser = names(&InitialDistribution::NAMED))]
    initial: Option<String>,
    /// Maximum number of iterations of Baum-Welch [default: 500]
    #[arg(long, value_name = "N", value_parser = whole_within(ITERATIONS))]
    iterations: Option<u32>,
    /// Stop when the log-likelihood rises by less than this fraction; 0 runs all iterations [default: 0.0001]
    #[arg(long, value_name = "X", value_parser = within(TOLERANCE))]
    tolerance: Option<f64>,
    /// Minimum variance of an emission; 0 for none [default: 0.0001]
    #[arg(long, value_name = "X", value_parser = within(VARIANCE_FLOOR))]
    variance_floor: Option<f64>,
    /// Use only the first N samples of each trial
    #[arg(long, value_name = "N", value_parser = whole_within(SAMPLES))]
    max_samples: Option<u32>,
}

/// The names of a list.
fn names<T>(known: &'static [(&'static str, T)]) -> PossibleValuesParser {
    PossibleValuesParser::new(known.iter().map(|(name, _)| *name))
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    fn parse(words: &[&str]) -> EstimatorArguments {
        let command = EstimatorArguments::augment_args(Command::new("train"));
        let matches = command.get_matches_from(std::iter::once(&"train").chain(words));
        EstimatorArguments::from_arg_matches(&matches).unwrap()
    }

    /// Tests that every classifier of the list has its name and aliases on the command line, and every feature is in
    /// the help.
    #[test]
    fn the_lists_are_the_options() {
        for kind in CLASSIFIERS {
            for name in kind.aliases.iter().chain([&kind.name]) {
                assert_eq!(parse(&["--classifier", name]).classifier_name(), kind.name);
            }
        }
        let mut command = EstimatorArguments::augment_args(Command::new("train"));
        let help = command.render_long_help().to_string();
        for feature in FEATURES {
            assert!(help.contains(feature.name), "{} in:\n{help}", feature.name);
        }
    }

    /// Tests that features are a list for every classifier, and that the old way to write them still works.
    #[test]
    fn features_are_a_list() {
        let recipe = |words: &[&str]| parse(words).hmm().unwrap().unwrap();
        assert_eq!(recipe(&["--features", "force,motion"]).features, FeatureSet::FORCE_AND_MOTION);
        assert_eq!(recipe(&["--features", "force+motion"]).features, FeatureSet::FORCE_AND_MOTION);
        assert_eq!(recipe(&["--features", "force"]).features, FeatureSet::FORCE);
        let area = recipe(&["--features", "force,area", "--recipe", "modern"]);
        assert_eq!(area.features.columns(), ["force_n", "region_taxels"]);
    }

    /// Tests that the defaults in the help are those of the authors' recipe.
    #[test]
    fn the_help_states_the_defaults() {
        let mut command = EstimatorArguments::augment_args(Command::new("train"));
        let help = command.render_long_help().to_string();
        let recipe = parse(&[]).hmm().unwrap().unwrap();
        assert_eq!(recipe, Recipe::authors());
        let TrainingOptions { iterations, tolerance, variance_floor } = recipe.training;
        for number in
            [recipe.states.to_string(), iterations.to_string(), tolerance.to_string(), variance_floor.to_string()]
        {
            assert!(help.contains(&format!("[default: {number}]")), "{number} in:\n{help}");
        }
    }
}
