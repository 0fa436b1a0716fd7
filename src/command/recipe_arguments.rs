//! Options that choose how hidden Markov models are made; for every command that trains some.

use clap::{Args, ValueEnum};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::hmm::{InitialDistribution, Topology, TrainingOptions};
use underbrush_classifier::recipe::Recipe;

/// The choices that make a model. Each is `None` where it is not given, so that a command can refuse what it would
/// ignore.
#[derive(Args, Clone, Debug, Default)]
pub struct RecipeArguments {
    /// Choices that the other options change: the authors' own, or what one would choose today (forward score,
    /// z-scored features) [default: authors]
    #[arg(long, value_enum)]
    recipe: Option<RecipeName>,
    /// Hidden states of each model [default: 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=500))]
    states: Option<u16>,
    /// Features of each sample, joined by commas: force, motion, area, region-max-force, region-force-sum
    /// [default: force]
    #[arg(long, value_name = "LIST")]
    features: Option<FeatureSet>,
    /// Transitions that exist [default: left-right]
    #[arg(long, value_enum)]
    topology: Option<TopologyName>,
    /// Where models start [default: uniform]
    #[arg(long, value_enum)]
    initial: Option<Initial>,
    /// Iterations of Baum-Welch at most [default: 500]
    #[arg(long, value_name = "N")]
    iterations: Option<usize>,
    /// Stop where the log-likelihood rises by less than this fraction; 0 runs all iterations [default: 0.0001]
    #[arg(long, value_name = "X", value_parser = not_negative)]
    tolerance: Option<f64>,
    /// Least variance of an emission; 0 for none [default: 0.0001]
    #[arg(long, value_name = "X", value_parser = not_negative)]
    variance_floor: Option<f64>,
    /// Use only the first N samples of each trial
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_samples: Option<u32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RecipeName {
    Authors,
    Modern,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TopologyName {
    LeftRight,
    Ergodic,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Initial {
    Uniform,
    FirstState,
}

fn not_negative(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err("must be zero or more".into())
    }
}

impl RecipeArguments {
    /// The options that are given, by name.
    pub fn given(&self) -> Vec<&'static str> {
        let options = [
            ("--recipe", self.recipe.is_some()),
            ("--states", self.states.is_some()),
            ("--features", self.features.is_some()),
            ("--topology", self.topology.is_some()),
            ("--initial", self.initial.is_some()),
            ("--iterations", self.iterations.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--variance-floor", self.variance_floor.is_some()),
            ("--max-samples", self.max_samples.is_some()),
        ];
        options
            .into_iter()
            .filter(|(_, given)| *given)
            .map(|(name, _)| name)
            .collect()
    }

    /// The recipe.
    pub fn recipe(&self) -> Recipe {
        let base = match self.recipe {
            None | Some(RecipeName::Authors) => Recipe::authors(),
            Some(RecipeName::Modern) => Recipe::modern(),
        };
        Recipe {
            states: self.states.map_or(base.states, usize::from),
            features: self.features.unwrap_or(base.features),
            topology: self.topology.map_or(base.topology, |topology| match topology {
                TopologyName::LeftRight => Topology::LeftToRight,
                TopologyName::Ergodic => Topology::Ergodic,
            }),
            initial: self.initial.map_or(base.initial, |initial| match initial {
                Initial::Uniform => InitialDistribution::Uniform,
                Initial::FirstState => InitialDistribution::FirstState,
            }),
            max_samples: self.max_samples.map(|samples| samples as usize),
            training: self.training(),
            ..base
        }
    }

    /// Baum-Welch's bounds.
    pub fn training(&self) -> TrainingOptions {
        let default = TrainingOptions::default();
        TrainingOptions {
            iterations: self.iterations.unwrap_or(default.iterations),
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            variance_floor: self.variance_floor.unwrap_or(default.variance_floor),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    /// Pins the defaults that the help states: each equals that of the authors' recipe.
    #[test]
    fn the_help_states_the_defaults() {
        let mut command = RecipeArguments::augment_args(Command::new("train"));
        let help = command.render_long_help().to_string();
        let matches = command.clone().get_matches_from(["train"]);
        let recipe = RecipeArguments::from_arg_matches(&matches).unwrap().recipe();
        assert_eq!(recipe, Recipe::authors());
        let TrainingOptions {
            iterations,
            tolerance,
            variance_floor,
        } = recipe.training;
        for number in [
            recipe.states.to_string(),
            iterations.to_string(),
            tolerance.to_string(),
            variance_floor.to_string(),
        ] {
            assert!(help.contains(&format!("[default: {number}]")), "{number} in:\n{help}");
        }
    }
}
