//! From log-likelihoods to verdicts: priors, and thresholds on the margin between the best two categories.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use underbrush_recording::{Limits, math, short};

/// Priors in a common unit. If one is a thousand million times another, hardly anything is left to decide.
pub(crate) const PRIOR: Limits = Limits::new(1e-9, 1e9, "");

/// What a taxel or a trial is classified as.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// This category.
    Category(Arc<str>),
    /// The margin is too small to decide.
    Uncertain,
    /// Belongs to none of the known categories (paper, section V-D).
    Outlier,
}

impl Verdict {
    /// The category's name, `uncertain` or `outlier`.
    pub fn name(&self) -> &str {
        match self {
            Verdict::Category(name) => name,
            Verdict::Uncertain => "uncertain",
            Verdict::Outlier => "outlier",
        }
    }

    /// Its index among the verdicts of a classifier with these categories: the categories, then uncertain, then outlier.
    /// `None` for a category that is not one of them.
    pub fn index(&self, categories: &[String]) -> Option<usize> {
        match self {
            Verdict::Category(name) => categories.iter().position(|own| **own == **name),
            Verdict::Uncertain => Some(categories.len()),
            Verdict::Outlier => Some(categories.len() + 1),
        }
    }
}

/// How the margin becomes a verdict. The margin is the log-posterior of the best category minus that of the second
/// best, in nats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rule {
    /// The best category (eq. 2); uncertain only in a tie.
    Argmax,
    /// The best category, or uncertain if its margin is below a threshold (section V-B).
    UncertainBelow {
        /// The smallest margin that yields a category, in nats.
        #[serde(alias = "lead")]
        margin: f64,
    },
    /// Uncertain below one threshold, the best category above another, and an outlier in between (section V-D). If both are the
    /// same, nothing is an outlier.
    OutlierBand {
        /// Uncertain if the margin is below this, in nats.
        uncertain_below: f64,
        /// The best category if the margin is above this, in nats.
        category_above: f64,
    },
}

/// Why a decision cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DecisionError {
    /// A prior outside its range.
    #[error(
        "the prior of {category} is {}; allowed: {} (they need not sum to 1)",
        short(*found),
        PRIOR
    )]
    BadPrior {
        /// The category.
        category: String,
        /// The number found.
        found: f64,
    },
    /// Priors for categories other than those of the models.
    #[error(
        "priors are given for {}, models for {}; give one prior per model, or none at all",
        found.join(", "),
        expected.join(", ")
    )]
    PriorCategories {
        /// The categories with a prior.
        found: Vec<String>,
        /// The categories with a model.
        expected: Vec<String>,
    },
    /// Thresholds that contradict each other or are out of range.
    #[error("thresholds of {} and {} nats; allowed: finite numbers from 0, the first no larger than the second", found[0], found[1])]
    BadThreshold {
        /// Margins from which a verdict is not uncertain, and above which it is a category, nats.
        found: [f64; 2],
    },
    /// The paper's thresholds belong to other scores, for this reason.
    #[error(
        "the paper's thresholds of 15 and 80 nats belong to Viterbi scores of hidden Markov models of unscaled force, and \
         {0}; give a margin (--decision uncertain), or fit with a false positive rate"
    )]
    NotThePapers(String),
    /// The model's own thresholds belong to its other kind of score.
    #[error(
        "the model's own thresholds were chosen on the other kind of score; give a decision, or leave the kind of score as \
         it is"
    )]
    NotItsOwn,
}

/// Priors and the rule that turns scores into verdicts.
///
/// ```
/// use underbrush_classifier::decision::{Decision, Rule, Verdict};
///
/// // Uncertain if the best category leads by less than 3 nats.
/// let decision = Decision::new(Rule::UncertainBelow { margin: 3.0 });
/// let judge = decision.prepare(&["leaf".into(), "trunk".into()])?;
/// let verdict = |leaf: f64, trunk: f64| judge.choose(&[leaf, trunk]);
/// assert_eq!(verdict(-10.0, -20.0), Verdict::Category("leaf".into()));
/// assert_eq!(verdict(-10.0, -11.0), Verdict::Uncertain);
/// # Ok::<(), underbrush_classifier::decision::DecisionError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Decision {
    /// P(λ_c) of eq. 3 by category, in any common unit, from 1e-9 to 1e9. Empty means equal priors, as in eq. 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub prior: BTreeMap<String, f64>,
    /// How the margin becomes a verdict.
    pub rule: Rule,
}

impl Decision {
    /// This rule with equal priors.
    pub fn new(rule: Rule) -> Self {
        Decision { prior: BTreeMap::new(), rule }
    }

    /// The best category with equal priors: the rule of Table I.
    pub fn argmax() -> Self {
        Self::new(Rule::Argmax)
    }

    /// The rule of the paper's outlier experiment (section V-D): a category above 80 nats, an outlier from 15 to 80,
    /// uncertain below 15. These thresholds apply to Viterbi scores of unscaled force.
    pub fn paper() -> Self {
        Self::new(Rule::OutlierBand { uncertain_below: 15.0, category_above: 80.0 })
    }

    /// Checks the decision against the models' categories and prepares it.
    ///
    /// # Errors
    /// [`DecisionError`] if priors or thresholds are out of range or do not fit the categories.
    pub fn prepare(&self, categories: &[String]) -> Result<Judge, DecisionError> {
        if !self.prior.is_empty() && !self.prior.keys().eq(categories) {
            let found = self.prior.keys().cloned().collect();
            return Err(DecisionError::PriorCategories { found, expected: categories.to_vec() });
        }
        if let Some((category, &found)) = self.prior.iter().find(|(_, prior)| !PRIOR.hold(**prior)) {
            return Err(DecisionError::BadPrior { category: category.clone(), found });
        }
        let (low, high) = match self.rule {
            Rule::Argmax => (0.0, 0.0),
            Rule::UncertainBelow { margin } => (margin, margin),
            Rule::OutlierBand { uncertain_below, category_above } => (uncertain_below, category_above),
        };
        if !(low >= 0.0 && high >= low && high.is_finite()) {
            return Err(DecisionError::BadThreshold { found: [low, high] });
        }
        let total: f64 = self.prior.values().sum();
        let log_prior = match self.prior.is_empty() {
            true => vec![0.0; categories.len()],
            false => self.prior.values().map(|prior| math::ln(prior / total)).collect(),
        };
        let categories = categories.iter().map(|name| name.as_str().into()).collect();
        Ok(Judge { categories, log_prior, rule: self.rule })
    }
}

/// A [`Decision`] that was checked for the categories of a set of models.
///
/// ```
/// use underbrush_classifier::decision::Decision;
///
/// let judge = Decision::argmax().prepare(&["leaf".into(), "trunk".into()])?;
/// let (best, margin) = judge.margin(&[-12.0, -9.5]).expect("both are possible");
/// assert_eq!((best, margin), (1, 2.5));
/// assert_eq!(judge.choose(&[-12.0, -9.5]).name(), "trunk");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Judge {
    categories: Vec<Arc<str>>,
    log_prior: Vec<f64>,
    rule: Rule,
}

impl Judge {
    /// The index of the best category and its margin over the second best, in nats of log-posterior.
    ///
    /// The margin is infinite if only one category admits the data. `None` if no category does (all scores are −inf).
    /// Scores beyond the number of categories are ignored.
    pub fn margin(&self, log_likelihood: &[f64]) -> Option<(usize, f64)> {
        let (mut best, mut index, mut second) = (f64::NEG_INFINITY, 0, f64::NEG_INFINITY);
        for (i, (likelihood, prior)) in log_likelihood.iter().zip(&self.log_prior).enumerate() {
            let posterior = likelihood + prior;
            if posterior > best {
                (best, index, second) = (posterior, i, best);
            } else if posterior > second {
                second = posterior;
            }
        }
        (best > f64::NEG_INFINITY).then_some((index, best - second))
    }

    /// The verdict on log-likelihoods given in the order of the categories. Nothing is allocated.
    ///
    /// It is uncertain if no model admits the data (all scores are −inf) or two categories tie. A single
    /// category always wins. Scores beyond the number of categories are ignored.
    pub fn choose(&self, log_likelihood: &[f64]) -> Verdict {
        let Some((index, margin)) = self.margin(log_likelihood) else { return Verdict::Uncertain };
        match self.rule {
            _ if margin == 0.0 => Verdict::Uncertain,
            Rule::UncertainBelow { margin: min } if margin < min => Verdict::Uncertain,
            Rule::OutlierBand { uncertain_below, category_above } if margin <= category_above => {
                if margin < uncertain_below || uncertain_below == category_above {
                    Verdict::Uncertain
                } else {
                    Verdict::Outlier
                }
            }
            _ => Verdict::Category(Arc::clone(&self.categories[index])),
        }
    }
}

#[cfg(test)]
mod tests;
