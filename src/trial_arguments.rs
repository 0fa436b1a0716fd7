//! Options for extracting trials from a data set or a recording.

use std::path::Path;

use clap::{Args, ValueEnum};
use underbrush_classifier::touch::TouchOptions;
use underbrush_classifier::trial::{Labels, TrialOptions};
use underbrush_experiments::contact_trials;

use crate::failure::Failure;

/// What a trial is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Unit {
    /// One taxel from contact to break (paper, section IV-D)
    Taxel,
    /// One connected component of taxels (paper, section IV-C)
    Component,
}

/// How a trial gets its category.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LabelName {
    /// The object that pressed on the skin
    Contact,
    /// The single category of the clutter, even where nothing pressed, as the paper's models were trained
    Environment,
}

/// A named set of choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// As in the paper's Table I: --labels environment, --min-samples 20, and evaluate --group position
    Paper,
}

/// How trials are extracted from a data set or a recording. A table of trials is used as it is; of these options only
/// --min-samples applies to it, and of the preset everything but the labels. Options that are not given are `None`, so
/// that a command can refuse those that it would ignore.
#[derive(Args, Clone, Debug, Default)]
pub struct TrialArguments {
    /// Preset; other options override it
    #[arg(long, value_enum, value_name = "NAME")]
    preset: Option<Preset>,
    /// What a trial is made of [default: taxel]
    #[arg(long, value_enum, value_name = "UNIT")]
    by: Option<Unit>,
    /// Patch of skin; the first one if not given
    #[arg(long, value_name = "NAME")]
    patch: Option<String>,
    /// A taxel is in contact while it senses more than this, N [default: 0.03]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    threshold_n: Option<f64>,
    /// Leave out trials with fewer samples [default: 1]
    #[arg(long, value_name = "N")]
    min_samples: Option<usize>,
    /// How a trial gets its category [default: contact]
    #[arg(long, value_enum, value_name = "BY")]
    labels: Option<LabelName>,
    /// Do not connect components across the seam of a closed patch, as in the authors' code
    #[arg(long)]
    no_wrap: bool,
}

impl TrialArguments {
    /// Whether the paper's preset is chosen.
    pub fn is_paper(&self) -> bool {
        self.preset == Some(Preset::Paper)
    }

    /// The same options for trials of any length.
    #[must_use]
    pub fn of_any_length(&self) -> Self {
        TrialArguments { min_samples: Some(1), ..self.clone() }
    }

    /// Name of the patch; `None` for the first one.
    pub fn patch(&self) -> Option<String> {
        self.patch.clone()
    }

    /// The force above which a taxel is in contact, N.
    pub fn threshold_n(&self) -> f64 {
        self.threshold_n.unwrap_or(TrialOptions::default().threshold_n)
    }

    /// The minimum number of samples of a trial. Trials with fewer samples are left out.
    pub fn min_samples(&self) -> usize {
        let paper = self.is_paper().then(|| TrialOptions::paper().min_samples);
        self.min_samples.or(paper).unwrap_or(1)
    }

    /// The options for extracting trials.
    pub fn options(&self) -> TrialOptions {
        let labels = match (self.labels, self.is_paper()) {
            (Some(LabelName::Contact), _) => Labels::Contact,
            (Some(LabelName::Environment), _) => Labels::Environment,
            (None, true) => TrialOptions::paper().labels,
            (None, false) => TrialOptions::default().labels,
        };
        TrialOptions {
            patch: self.patch(),
            threshold_n: self.threshold_n(),
            min_samples: self.min_samples(),
            labels,
            wrap: self.no_wrap.then_some(false),
            ..TrialOptions::default()
        }
    }

    /// What a trial is made of.
    ///
    /// # Errors
    /// If `--no-wrap` is given for taxels.
    pub fn unit(&self) -> Result<contact_trials::Unit, Failure> {
        match self.by.unwrap_or(Unit::Taxel) {
            Unit::Taxel if self.no_wrap => {
                Err(Failure::usage("--no-wrap applies to components only; add --by component, or leave --no-wrap out"))
            }
            Unit::Taxel => Ok(contact_trials::Unit::Taxel),
            Unit::Component => Ok(contact_trials::Unit::Component),
        }
    }

    /// Refuses options that do not apply to a table of trials.
    pub fn refuse_for_table(&self, path: &Path) -> Result<(), Failure> {
        self.refuse(
            &[
                ("--by", self.by.is_some()),
                ("--patch", self.patch.is_some()),
                ("--threshold-n", self.threshold_n.is_some()),
                ("--labels", self.labels.is_some()),
                ("--no-wrap", self.no_wrap),
            ],
            &format!("a table of trials such as {}, whose trials are already extracted and labelled", path.display()),
        )
    }

    /// How readings become contacts, for the classifier `touch`.
    ///
    /// # Errors
    /// If an option is given that is about trials.
    pub fn touch(&self) -> Result<TouchOptions, Failure> {
        self.refuse(
            &self.about_trials(),
            "the classifier touch, which learns from whole frames and their ground truth",
        )?;
        Ok(TouchOptions { patch: self.patch(), threshold_n: self.threshold_n() })
    }

    /// Refuses all options, because a touch model knows its patch and threshold and judges frames.
    pub fn refuse_for_touch_model(&self) -> Result<(), Failure> {
        let own = [("--patch", self.patch.is_some()), ("--threshold-n", self.threshold_n.is_some())];
        self.refuse(&own, "a touch model, which has a patch and a threshold of its own")?;
        self.refuse(&self.about_trials(), "a touch model, which judges frames, not trials")
    }

    /// Refuses options that do not apply to verdicts frame by frame.
    pub fn refuse_online(&self) -> Result<(), Failure> {
        self.refuse(&self.about_trials(), "online verdicts, which are given for each taxel from its first sample on")
    }

    /// The options that are about trials only, and whether they are given.
    fn about_trials(&self) -> [(&'static str, bool); 5] {
        [
            ("--preset", self.preset.is_some()),
            ("--by", self.by.is_some()),
            ("--min-samples", self.min_samples.is_some()),
            ("--labels", self.labels.is_some()),
            ("--no-wrap", self.no_wrap),
        ]
    }

    fn refuse(&self, options: &[(&str, bool)], what: &str) -> Result<(), Failure> {
        match options.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((option, _)) => Err(Failure::usage(format!("{option} does not apply to {what}; leave it out"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    fn parse(words: &[&str]) -> TrialArguments {
        let command = TrialArguments::augment_args(Command::new("trials"));
        let words = std::iter::once(&"trials").chain(words);
        TrialArguments::from_arg_matches(&command.get_matches_from(words)).unwrap()
    }

    /// Tests the defaults, the preset, and that other options override the preset.
    #[test]
    fn the_preset_is_the_papers_and_gives_way() {
        assert_eq!(parse(&[]).options(), TrialOptions::default());
        assert_eq!(parse(&["--preset", "paper"]).options(), TrialOptions::paper());
        let mixed = parse(&["--preset", "paper", "--min-samples", "3", "--labels", "contact"]).options();
        let expected = TrialOptions { min_samples: 3, ..TrialOptions::default() };
        assert_eq!(mixed, expected);
    }

    /// Tests that the help states the default threshold.
    #[test]
    fn the_help_states_the_threshold() {
        let mut command = TrialArguments::augment_args(Command::new("trials"));
        let help = command.render_long_help().to_string();
        let number = TrialOptions::default().threshold_n;
        assert!(help.contains(&format!("N [default: {number}]")), "{help}");
    }
}
