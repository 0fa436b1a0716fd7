//! From log-likelihoods to verdicts: priors, and thresholds on the margin of the best category.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a taxel, or a trial, is taken for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// This category.
    Category(String),
    /// Too little margin to tell.
    Uncertain,
    /// Foreign to all categories (paper, section V-D).
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
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How the margin of the best category over the second, in nats of log-posterior, becomes a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Rule {
    /// The best category (eq. 2); uncertain only in a tie.
    Argmax,
    /// The best category, uncertain where its margin is below a threshold (section V-B).
    UncertainBelow {
        /// The smallest margin that gives a category, nats.
        #[serde(alias = "lead")]
        margin: f64,
    },
    /// Section V-D: uncertain below one threshold, the best category above another, an outlier between them.
    OutlierBand {
        /// Uncertain where the margin is below this, nats.
        uncertain_below: f64,
        /// The best category where the margin is above this, nats.
        category_above: f64,
    },
}

/// What makes a decision impossible.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DecisionError {
    /// A prior that is no probability.
    #[error("the prior of {category} is {found}; allowed: finite numbers above 0 (they need not sum to 1)")]
    BadPrior {
        /// The category.
        category: String,
        /// The number found.
        found: f64,
    },
    /// Priors whose categories are not the models'.
    #[error("priors are given for {found:?}, models for {expected:?}; give a prior for each model, or none at all")]
    PriorCategories {
        /// The categories with a prior.
        found: Vec<String>,
        /// The categories with a model.
        expected: Vec<String>,
    },
    /// Thresholds that leave no sense.
    #[error("thresholds {found:?}; allowed: finite, from 0, category_above not under uncertain_below")]
    BadThreshold {
        /// The rule found.
        found: Rule,
    },
    /// Scores in another number than categories.
    #[error("{found} scores for {expected} categories; give one score per category")]
    ScoreCount {
        /// Scores given.
        found: usize,
        /// Categories.
        expected: usize,
    },
}

/// Priors and rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decision {
    /// P(λ_c) of eq. 3 by category, in any common unit; empty: all alike, as in eq. 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub prior: BTreeMap<String, f64>,
    /// From the margin to a verdict.
    pub rule: Rule,
}

impl Decision {
    /// Equal priors and this rule.
    pub fn new(rule: Rule) -> Self {
        Decision {
            prior: BTreeMap::new(),
            rule,
        }
    }

    /// The best category, equal priors: the rule of Table I.
    pub fn argmax() -> Self {
        Self::new(Rule::Argmax)
    }

    /// The paper's outlier experiment (section V-D): over 80 nats a category, 15 to 80 an outlier, under 15 uncertain.
    /// These thresholds belong to Viterbi scores of unscaled force.
    pub fn paper() -> Self {
        Self::new(Rule::OutlierBand {
            uncertain_below: 15.0,
            category_above: 80.0,
        })
    }

    /// Checks the decision for models of these categories and prepares it.
    ///
    /// # Errors
    /// [`DecisionError`] where priors or thresholds make no sense.
    pub fn prepare(&self, categories: &[String]) -> Result<Judge, DecisionError> {
        if !self.prior.is_empty() && !self.prior.keys().eq(categories) {
            let found = self.prior.keys().cloned().collect();
            return Err(DecisionError::PriorCategories {
                found,
                expected: categories.to_vec(),
            });
        }
        if let Some((category, &found)) = self
            .prior
            .iter()
            .find(|(_, prior)| !(prior.is_finite() && **prior > 0.0))
        {
            return Err(DecisionError::BadPrior {
                category: category.clone(),
                found,
            });
        }
        let (low, high) = match self.rule {
            Rule::Argmax => (0.0, 0.0),
            Rule::UncertainBelow { margin } => (margin, margin),
            Rule::OutlierBand {
                uncertain_below,
                category_above,
            } => (uncertain_below, category_above),
        };
        if !(low >= 0.0 && high >= low && high.is_finite()) {
            return Err(DecisionError::BadThreshold { found: self.rule });
        }
        let total: f64 = self.prior.values().sum();
        let log_prior = match self.prior.is_empty() {
            true => vec![0.0; categories.len()],
            false => self.prior.values().map(|prior| (prior / total).ln()).collect(),
        };
        Ok(Judge {
            categories: categories.to_vec(),
            log_prior,
            rule: self.rule,
        })
    }
}

/// A verdict by index: what [`Judge::choose`] gives without touching a string.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The category of this index.
    Category(usize),
    /// See [`Verdict::Uncertain`].
    Uncertain,
    /// See [`Verdict::Outlier`].
    Outlier,
}

/// A checked [`Decision`] for the categories of a set of models.
#[derive(Clone, Debug, PartialEq)]
pub struct Judge {
    categories: Vec<String>,
    log_prior: Vec<f64>,
    rule: Rule,
}

impl Judge {
    /// The best category's index and its margin over the second, nats of log-posterior, from 0 and infinite where no other
    /// category admits the data; `None` where none does (all −inf). Scores beyond the categories are not looked at.
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

    /// The choice for log-likelihoods in the order of the categories.
    ///
    /// Where no model admits the data (all −inf) or two categories tie, the choice is uncertain.
    /// A single category always wins. Scores beyond the categories are not looked at.
    pub fn choose(&self, log_likelihood: &[f64]) -> Choice {
        let Some((index, margin)) = self.margin(log_likelihood) else {
            return Choice::Uncertain;
        };
        match self.rule {
            _ if margin == 0.0 => Choice::Uncertain,
            Rule::Argmax => Choice::Category(index),
            Rule::UncertainBelow { margin: min } if margin < min => Choice::Uncertain,
            Rule::OutlierBand { uncertain_below, .. } if margin < uncertain_below => Choice::Uncertain,
            Rule::OutlierBand { category_above, .. } if margin <= category_above => Choice::Outlier,
            _ => Choice::Category(index),
        }
    }

    /// The name of a choice made by this judge.
    pub fn verdict(&self, choice: Choice) -> Verdict {
        match choice {
            Choice::Category(index) => match self.categories.get(index) {
                Some(name) => Verdict::Category(name.clone()),
                None => Verdict::Uncertain,
            },
            Choice::Uncertain => Verdict::Uncertain,
            Choice::Outlier => Verdict::Outlier,
        }
    }

    /// The verdict for scores as [`crate::ModelSet::score`] gives them.
    ///
    /// # Errors
    /// [`DecisionError::ScoreCount`] where they are not one per category.
    pub fn judge(&self, scores: &[(String, f64)]) -> Result<Verdict, DecisionError> {
        if scores.len() != self.categories.len() {
            return Err(DecisionError::ScoreCount {
                found: scores.len(),
                expected: self.categories.len(),
            });
        }
        let log_likelihood: Vec<f64> = scores.iter().map(|(_, score)| *score).collect();
        Ok(self.verdict(self.choose(&log_likelihood)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn categories() -> Vec<String> {
        vec!["leaf".into(), "trunk".into()]
    }

    #[test]
    fn the_papers_thresholds_cut_where_it_says() {
        // Pins section V-D: > 80 category, 15 … 80 outlier, < 15 uncertain, whichever category is best.
        let judge = Decision::paper().prepare(&categories()).unwrap();
        for (margin, expected) in [
            (80.001, Choice::Category(1)),
            (80.0, Choice::Outlier),
            (15.0, Choice::Outlier),
            (14.999, Choice::Uncertain),
            (0.0, Choice::Uncertain),
            (-14.0, Choice::Uncertain),
            (-40.0, Choice::Outlier),
            (-200.0, Choice::Category(0)),
            (f64::INFINITY, Choice::Category(1)),
        ] {
            assert_eq!(judge.choose(&[0.0, margin]), expected, "margin {margin}");
        }
    }

    #[test]
    fn priors_shift_the_lead() {
        // Pins eq. 3: a prior of 0.9 against 0.1 is worth ln 9 = 2.197 nats, and its unit does not matter.
        for unit in [1.0, 50.0] {
            let prior = BTreeMap::from([("leaf".to_owned(), 0.9 * unit), ("trunk".to_owned(), 0.1 * unit)]);
            let judge = Decision {
                prior,
                rule: Rule::Argmax,
            }
            .prepare(&categories())
            .unwrap();
            assert_eq!(judge.choose(&[-10.0, -7.81]), Choice::Category(0));
            assert_eq!(judge.choose(&[-10.0, -7.79]), Choice::Category(1));
        }
    }

    #[test]
    fn impossible_data_are_uncertain() {
        // Pins that −inf everywhere and ties give no category, and a single model always wins.
        let judge = Decision::argmax().prepare(&categories()).unwrap();
        assert_eq!(judge.choose(&[f64::NEG_INFINITY; 2]), Choice::Uncertain);
        assert_eq!(judge.choose(&[-3.0, -3.0]), Choice::Uncertain);
        assert_eq!(judge.choose(&[f64::NEG_INFINITY, -1e5]), Choice::Category(1));
        let alone = Decision::paper().prepare(&["leaf".into()]).unwrap();
        assert_eq!(
            alone.judge(&[("leaf".into(), -5.0)]),
            Ok(Verdict::Category("leaf".into()))
        );
    }

    #[test]
    fn plain_threshold() {
        // Pins the rule of section V-B at its border.
        let judge = Decision::new(Rule::UncertainBelow { margin: 2.0 })
            .prepare(&categories())
            .unwrap();
        assert_eq!(judge.choose(&[2.0, 0.0]), Choice::Category(0));
        assert_eq!(judge.choose(&[1.999, 0.0]), Choice::Uncertain);
    }

    #[test]
    fn senseless_decisions_are_refused() {
        // Pins the checks of priors and thresholds.
        let with_prior = |prior: &[(&str, f64)]| Decision {
            prior: prior.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
            rule: Rule::Argmax,
        };
        let refused = [
            with_prior(&[("leaf", 1.0)]),
            with_prior(&[("leaf", 1.0), ("foam", 1.0)]),
            with_prior(&[("leaf", 1.0), ("trunk", 0.0)]),
            with_prior(&[("leaf", f64::NAN), ("trunk", 1.0)]),
            Decision::new(Rule::OutlierBand {
                uncertain_below: 80.0,
                category_above: 15.0,
            }),
            Decision::new(Rule::UncertainBelow { margin: f64::NAN }),
            Decision::new(Rule::UncertainBelow { margin: -1.0 }),
        ];
        for decision in refused {
            assert!(decision.prepare(&categories()).is_err(), "{decision:?}");
        }
    }

    #[test]
    fn verdicts_are_written_in_words() {
        // Pins the JSON of verdicts and of the paper's decision.
        let json = |verdict: &Verdict| serde_json::to_string(verdict).unwrap();
        assert_eq!(json(&Verdict::Category("leaf".into())), r#"{"category":"leaf"}"#);
        assert_eq!(json(&Verdict::Outlier), r#""outlier""#);
        let text = serde_json::to_string(&Decision::paper()).unwrap();
        assert_eq!(
            text,
            r#"{"rule":{"outlier_band":{"uncertain_below":15.0,"category_above":80.0}}}"#
        );
        assert_eq!(serde_json::from_str::<Decision>(&text).unwrap(), Decision::paper());
    }

    /// Pins that model files written before `lead` was renamed to `margin` still load, and that new files say `margin`.
    #[test]
    fn the_old_key_of_the_margin_still_loads() {
        let rule = Rule::UncertainBelow { margin: 3.5 };
        for key in ["lead", "margin"] {
            let text = format!(r#"{{"uncertain_below":{{"{key}":3.5}}}}"#);
            assert_eq!(serde_json::from_str::<Rule>(&text).unwrap(), rule);
        }
        let written = serde_json::to_string(&rule).unwrap();
        assert_eq!(written, r#"{"uncertain_below":{"margin":3.5}}"#);
    }
}
