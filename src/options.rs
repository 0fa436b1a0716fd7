//! What the options of several commands have in common: how names, numbers and pairs are read, which options are given, and
//! the options for extracting trials from a data set or a recording.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use serde::Serialize;
use serde::de::value::Error as Unread;
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde_json::{Value, json};
use underbrush_classifier::ValueFault;
use underbrush_classifier::touch::TouchOptions;
use underbrush_classifier::trial::{Labels, TrialOptions, Unit};
use underbrush_recording::Limits;

use crate::Failure;

/// Reads one of these names, each with a line of help.
pub fn named<T>(names: &'static [(&'static str, &'static str)]) -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names.iter().map(|(name, help)| PossibleValue::new(*name).help(*help)))
        .try_map(|name| T::deserialize(IntoDeserializer::<Unread>::into_deserializer(name)))
}

/// Reads a whole number of a range.
pub fn whole<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text: &str| {
        let number = text.parse::<T>().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("must be a whole number from {} to {}", range.start(), range.end()))
    }
}

/// Reads a number that is allowed; the text says which numbers are.
pub fn number<T: FromStr + 'static>(
    is_allowed: fn(&T) -> bool,
    allowed: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| text.parse().ok().filter(is_allowed).ok_or_else(|| allowed.to_owned())
}

/// Reads a number within limits of a library.
pub fn within(limits: Limits) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.parse().ok().filter(|number| limits.hold(*number));
        number.ok_or_else(|| format!("must be a number: {limits}"))
    }
}

/// Reads a whole number within limits of a library.
pub fn whole_within(limits: Limits) -> impl Fn(&str) -> Result<u32, String> + Clone + Send + Sync + 'static {
    whole(limits.min as u32..=limits.max as u32)
}

/// Reads a number that a library checks. What is no number is refused as NaN is.
pub fn checked(
    check: fn(f64) -> Result<(), ValueFault>,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.parse().unwrap_or(f64::NAN);
        check(number).map(|()| number).map_err(|fault| format!("must be {}", fault.allowed))
    }
}

/// Two values with a sign between them, such as leaf=0.7; `None` if a text is anything else. A name is not empty.
pub fn pair<A: FromStr, B: FromStr>(text: &str, sign: char) -> Option<(A, B)> {
    let (first, second) = text.split_once(sign).filter(|(first, _)| !first.is_empty())?;
    Some((first.parse().ok()?, second.parse().ok()?))
}

/// The options that are given, as they are written. Each field is an option of its name; what is not given is
/// `None`, `false` or empty.
pub fn given(options: &impl Serialize) -> Vec<String> {
    let options = serde_json::to_value(options).unwrap_or_default();
    let is_given = |value: &Value| !matches!(value, Value::Null | Value::Bool(false)) && *value != json!([]);
    let given = options.as_object().into_iter().flatten().filter(|(_, value)| is_given(value));
    given.map(|(name, _)| format!("--{}", name.replace('_', "-"))).collect()
}

/// Refuses the first of these options, for this reason.
///
/// # Errors
/// If there is one.
pub fn refuse(options: impl IntoIterator<Item = String>, reason: &str) -> Result<(), Failure> {
    let refused = |option| Err(Failure::usage(format!("{option} {reason}; leave it out")));
    options.into_iter().next().map_or(Ok(()), refused)
}

/// How trials are extracted from a data set or a recording. A table of trials is used as it is; of these options only
/// --min-samples applies to it, and of the preset everything but the labels. Options that are not given are `None`, so
/// that a command can refuse those that it would ignore.
#[derive(Args, Clone, Debug, Default, Serialize)]
pub struct TrialArguments {
    /// Preset; other options override it
    #[arg(long, value_name = "NAME", value_parser = named::<String>(&[
        ("paper", "As in the paper's Table I: --labels environment, --min-samples 20, and evaluate --group position"),
    ]))]
    preset: Option<String>,
    /// What a trial is made of [default: taxel]
    #[arg(long, value_name = "UNIT", value_parser = named::<Unit>(&[
        ("taxel", "One taxel from contact to break (paper, section IV-D)"),
        ("component", "One connected component of taxels (paper, section IV-C)"),
    ]))]
    by: Option<Unit>,
    /// Patch of skin [default: the first one; of the classifier touch all]
    #[arg(long, value_name = "NAME")]
    pub patch: Option<String>,
    /// A taxel is in contact while it senses more than this, N [default: 0.03]
    #[arg(long, value_name = "N", value_parser = number(|_: &f64| true, "must be a force in N"))]
    threshold_n: Option<f64>,
    /// Leave out trials with fewer samples [default: 1]
    #[arg(long, value_name = "N", value_parser = number(|_: &usize| true, "must be a whole number, 0 or more"))]
    min_samples: Option<usize>,
    /// How a trial gets its category [default: contact]
    #[arg(long, value_name = "BY", value_parser = named::<Labels>(&[
        ("contact", "The object that pressed on the skin"),
        ("environment",
         "The single category of the clutter, even where nothing pressed, as the paper's models were trained; in a clutter of \
          several categories, the object that pressed"),
    ]))]
    labels: Option<Labels>,
    /// Do not connect components across the seam of a closed patch, as in the authors' code
    #[arg(long)]
    no_wrap: bool,
}

impl TrialArguments {
    /// Whether the paper's preset is chosen.
    pub fn is_paper(&self) -> bool {
        self.preset.is_some()
    }

    /// The same options for trials of any length.
    #[must_use]
    pub fn of_any_length(&self) -> Self {
        TrialArguments { min_samples: Some(1), ..self.clone() }
    }

    /// The force above which a taxel is in contact, N.
    pub fn threshold_n(&self) -> f64 {
        self.threshold_n.unwrap_or(TrialOptions::default().threshold_n)
    }

    /// The values of the options that are not given.
    fn preset(&self) -> TrialOptions {
        if self.is_paper() { TrialOptions::paper() } else { TrialOptions::default() }
    }

    /// The minimum number of samples of a trial. Trials with fewer samples are left out.
    pub fn min_samples(&self) -> usize {
        self.min_samples.unwrap_or(self.preset().min_samples)
    }

    /// The options for extracting trials.
    ///
    /// # Errors
    /// If `--no-wrap` is given for taxels.
    pub fn options(&self) -> Result<TrialOptions, Failure> {
        let preset = self.preset();
        let by = self.by.unwrap_or(preset.by);
        if self.no_wrap && by == Unit::Taxel {
            let text = "--no-wrap applies to components only; add --by component, or leave --no-wrap out";
            return Err(Failure::usage(text));
        }
        Ok(TrialOptions {
            by,
            patch: self.patch.clone(),
            threshold_n: self.threshold_n(),
            min_samples: self.min_samples(),
            labels: self.labels.unwrap_or(preset.labels),
            wrap: self.no_wrap.then_some(false),
            ..preset
        })
    }

    /// How readings become contacts, for the classifier `touch`.
    ///
    /// # Errors
    /// If an option is given that is about trials.
    pub fn touch(&self) -> Result<TouchOptions, Failure> {
        let what = "the classifier touch, which learns from whole frames and their ground truth";
        self.refuse_but(&Self::OF_CONTACTS, what)?;
        Ok(TouchOptions::of(self.patch.clone(), self.threshold_n))
    }

    /// Refuses all options, because a touch model knows its patch and threshold and judges frames.
    pub fn refuse_for_touch_model(&self) -> Result<(), Failure> {
        let what = "a touch model, which judges frames, not trials, and has a patch and a threshold of its own";
        self.refuse_but(&[], what)
    }

    /// The options that are not about trials only.
    pub const OF_CONTACTS: [&str; 2] = ["--patch", "--threshold-n"];

    /// Refuses options that do not apply to something, which are all but these.
    pub fn refuse_but(&self, allowed: &[&str], what: &str) -> Result<(), Failure> {
        let given = given(self).into_iter().filter(|option| !allowed.contains(&option.as_str()));
        refuse(given, &format!("does not apply to {what}"))
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
        assert_eq!(parse(&[]).options().unwrap(), TrialOptions::default());
        assert_eq!(parse(&["--preset", "paper"]).options().unwrap(), TrialOptions::paper());
        let mixed = parse(&["--preset", "paper", "--min-samples", "3", "--labels", "contact"]).options().unwrap();
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
