//! How often verdicts are right, wrong, uncertain or outliers.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::decision::Choice;

/// Rates of verdicts whose truth is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// Number of verdicts.
    pub verdicts: usize,
    /// By category: of the verdicts on other categories, the fraction that name this one.
    pub false_positive_rate: BTreeMap<String, f64>,
    /// By category: of the verdicts on this category, the fraction that name it.
    pub true_positive_rate: BTreeMap<String, f64>,
    /// Fraction of verdicts that are uncertain.
    pub uncertain: f64,
    /// Fraction of verdicts that are outlier.
    pub outlier: f64,
}

/// The rates of verdicts, each given with its true category.
pub(super) fn rates(choices: &[(&str, Choice)], categories: &[String]) -> Rates {
    let fraction = |choice: Choice, counts: &dyn Fn(&str) -> bool| {
        let pool = choices.iter().filter(|(truth, _)| counts(truth));
        let taken = pool.clone().filter(|(_, found)| *found == choice).count();
        taken as f64 / pool.count().max(1) as f64
    };
    let by_category = |own: bool| {
        let rates = categories.iter().enumerate().map(|(index, category)| {
            let rate = fraction(Choice::Category(index), &|truth| (truth == category) == own);
            (category.clone(), rate)
        });
        rates.collect()
    };
    Rates {
        verdicts: choices.len(),
        false_positive_rate: by_category(false),
        true_positive_rate: by_category(true),
        uncertain: fraction(Choice::Uncertain, &|_| true),
        outlier: fraction(Choice::Outlier, &|_| true),
    }
}
