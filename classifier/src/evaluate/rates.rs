//! How often verdicts are right, wrong, uncertain or outliers.

use std::collections::BTreeMap;

use serde::Serialize;

use super::confusion::ConfusionMatrix;

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

/// The rates of verdicts that were counted.
pub(super) fn rates(confusion: &ConfusionMatrix) -> Rates {
    let categories = confusion.verdict.len() - 2;
    let share = |column: usize, counts: &dyn Fn(&str) -> bool| {
        let rows = confusion.truth.iter().zip(&confusion.count).filter(|(truth, _)| counts(truth));
        let taken: usize = rows.clone().map(|(_, row)| row[column]).sum();
        let all: usize = rows.flat_map(|(_, row)| row).sum();
        taken as f64 / all.max(1) as f64
    };
    let by_category = |own: bool| {
        let names = confusion.verdict[..categories].iter().enumerate();
        names.map(|(column, name)| (name.clone(), share(column, &|truth| (truth == name) == own))).collect()
    };
    Rates {
        verdicts: confusion.count.iter().flatten().sum(),
        false_positive_rate: by_category(false),
        true_positive_rate: by_category(true),
        uncertain: share(categories, &|_| true),
        outlier: share(categories + 1, &|_| true),
    }
}
