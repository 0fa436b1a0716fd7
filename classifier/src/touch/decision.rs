//! From probabilities to a verdict.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::limits::SHARE;

use super::object::stage;
use crate::error::{ValueFault, check_limits};
use crate::frequency::largest;

/// The cost of an uncertain verdict, relative to that of a wrong one, and two limits.
///
/// ```
/// use underbrush_classifier::touch::{TouchDecision, TouchVerdict};
///
/// let decision = TouchDecision::default();
/// // A category needs a probability above 0.7.
/// assert_eq!(decision.of_region(&[0.2, 0.8], 0.5, 300), TouchVerdict::Category(1));
/// assert_eq!(decision.of_region(&[0.4, 0.6], 0.5, 300), TouchVerdict::Uncertain);
/// // Fewer than one known object in twenty is as unlike what is known.
/// assert_eq!(decision.of_region(&[0.1, 0.9], 0.03, 300), TouchVerdict::Unknown);
/// // In the first 0.6 s fewer than one in a hundred must be.
/// assert_eq!(decision.of_region(&[0.1, 0.9], 0.03, 30), TouchVerdict::Category(1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TouchDecision {
    /// A reading is called nothing if the probability that nothing presses on the taxel is above this.
    #[schemars(range(min = SHARE.min, max = SHARE.max))]
    pub nothing_above: f64,
    /// An object is called unknown if at most this share of the objects of each known category is as unlike what is known.
    /// This is therefore also the share of false alarms. Until the object was felt for 0.6 s, a fifth of it is the limit. Without
    /// auxiliary sets in training nothing is called unknown.
    #[schemars(range(min = SHARE.min, max = SHARE.max))]
    pub unknown_share: f64,
    /// The cost of an uncertain verdict, relative to the cost of a wrong category. A category is named if its
    /// probability is above 1 minus this.
    #[schemars(range(min = SHARE.min, max = SHARE.max))]
    pub cost_of_uncertain: f64,
}

impl Default for TouchDecision {
    /// Choices: one false alarm in twenty objects, and a wrong category is more than three times as bad as none. If it were
    /// five times as bad, up to 4 points fewer of the known objects would be called what they are at their end, and up to 1.2
    /// points fewer something else; after 0.3 s up to 8 and 3 points (development seed 6000). `nothing_above` is chosen in
    /// training.
    fn default() -> Self {
        TouchDecision { nothing_above: 0.5, unknown_share: 0.05, cost_of_uncertain: 0.3 }
    }
}

/// In an object's first stage the share of known objects that are as unlike is multiplied by this: little is known of the object by then,
/// and most objects that were called unknown were known ones. Choice, on development seed 6000: of the verdicts on known objects after 0.3 s, 2.2 instead
/// of 4.2 % are wrong, and at the end up to three points fewer unknown objects are found.
pub(super) const EARLY: f64 = 5.0;

/// The verdict on a taxel or a region: what touches it.
///
/// ```
/// use underbrush_classifier::touch::TouchVerdict;
///
/// let categories = ["leaf".to_owned(), "trunk".to_owned()];
/// let verdicts = [TouchVerdict::Category(1), TouchVerdict::Nothing];
/// assert_eq!(verdicts.map(|verdict| verdict.name(&categories)), ["trunk", "nothing"]);
/// assert_eq!(["trunk", "nothing"].map(|name| TouchVerdict::named(name, &categories)), verdicts);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum TouchVerdict {
    /// Nothing: a spurious reading.
    #[default]
    Nothing,
    /// The known category with this index.
    Category(usize),
    /// One of the known categories, but it is not yet certain which one.
    Uncertain,
    /// Something unlike all known categories.
    Unknown,
}

impl TouchVerdict {
    /// The name of the verdict, for a model with these categories: `nothing`, a category, `uncertain` or `unknown`.
    ///
    /// # Panics
    /// If there is no category with the verdict's index.
    pub fn name<'a>(&self, categories: &'a [String]) -> &'a str {
        match self {
            TouchVerdict::Nothing => "nothing",
            TouchVerdict::Category(index) => &categories[*index],
            TouchVerdict::Uncertain => "uncertain",
            TouchVerdict::Unknown => "unknown",
        }
    }

    /// The verdict of this name, for a model with these categories. Other names, such as `outlier`, stand for something
    /// unknown.
    pub fn named(name: &str, categories: &[impl AsRef<str>]) -> Self {
        if let Some(index) = categories.iter().position(|own| own.as_ref() == name) {
            return TouchVerdict::Category(index);
        }
        match name {
            "nothing" => TouchVerdict::Nothing,
            "uncertain" => TouchVerdict::Uncertain,
            _ => TouchVerdict::Unknown,
        }
    }

    /// Its place in a list that begins with nothing, continues with this many categories, and ends with everything else.
    pub fn row(self, categories: usize) -> usize {
        match self {
            TouchVerdict::Nothing => 0,
            TouchVerdict::Category(index) => index + 1,
            TouchVerdict::Uncertain | TouchVerdict::Unknown => categories + 1,
        }
    }
}

impl TouchDecision {
    /// The verdict on a region that something touches, from the `probabilities` of the known categories, the share of known
    /// objects that are as unlike as its object, and the number of samples in which this object was felt well enough.
    pub fn of_region(&self, probabilities: &[f64], share_beyond: f64, samples: usize) -> TouchVerdict {
        let best = largest(probabilities.iter().copied().enumerate());
        best.map_or(TouchVerdict::Uncertain, |(index, probability)| self.of(index, probability, share_beyond, samples))
    }

    /// The verdict, from the likeliest known category and its probability.
    pub(super) fn of(&self, likeliest: usize, probability: f64, share_beyond: f64, samples: usize) -> TouchVerdict {
        let share = if stage(samples) == 0 { f64::min(EARLY * share_beyond, 1.0) } else { share_beyond };
        match share <= self.unknown_share {
            true => TouchVerdict::Unknown,
            false if probability > 1.0 - self.cost_of_uncertain => TouchVerdict::Category(likeliest),
            false => TouchVerdict::Uncertain,
        }
    }

    pub(super) fn check(&self) -> Result<(), ValueFault> {
        check_limits("nothing_above", self.nothing_above, SHARE)?;
        check_limits("unknown_share", self.unknown_share, SHARE)?;
        check_limits("cost_of_uncertain", self.cost_of_uncertain, SHARE)
    }
}
