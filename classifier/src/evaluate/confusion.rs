//! Confusion matrices, accuracies and figures by category.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::interval::{Interval, wilson};
use super::prediction::{Prediction, Record, is_right};
use super::tally::{mean, share};
use crate::decision::Verdict;

/// Counts of true category against verdict.
///
/// ```
/// use underbrush_classifier::evaluate::{ConfusionMatrix, Record};
///
/// let categories = ["leaf".to_string(), "trunk".to_string()];
/// let record = |truth, verdict| Record { truth, verdict, scores: &[], reach: Some(0) };
/// // Three leaves are called leaf and one trunk uncertain.
/// let records = [record("leaf", 0), record("leaf", 0), record("leaf", 0), record("trunk", 2)];
/// let accuracy = ConfusionMatrix::of(records, &categories).accuracy();
/// let accuracy = accuracy.map(|own| (own.accuracy, own.balanced_accuracy, own.majority_baseline));
/// assert_eq!(accuracy, Some((0.75, Some(0.5), 0.75)));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ConfusionMatrix {
    /// True categories, one per row, in alphabetical order.
    pub truth: Vec<String>,
    /// Verdicts, one per column: the classifier's categories in alphabetical order, then uncertain and outlier.
    pub verdict: Vec<String>,
    /// Trials by row and column.
    pub count: Vec<Vec<usize>>,
}

/// An accuracy, with the two figures needed to judge it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Number of trials.
    pub trials: usize,
    /// Fraction of trials with the right verdict; see [`Record::is_right`]. Uncertain counts as wrong, and so does outlier
    /// if the classifier knows the trial's category. No verdict is right for a trial of category block.
    pub accuracy: f64,
    /// The best accuracy of always giving the same verdict: the fraction of trials of the most frequent category, or of
    /// all categories that the classifier does not know together. Blocks are left out, because no verdict is right for them.
    pub majority_baseline: f64,
    /// The unweighted mean recall over the classifier's categories. Always giving the same verdict reaches
    /// 1 / (number of categories), however the trials are distributed. Categories without trials, and those that the
    /// classifier does not know (blocks, outliers, other names), are left out; `None` if no category remains.
    pub balanced_accuracy: Option<f64>,
}

/// Accuracy by whether an object truly pressed during at least one sample of a trial
/// ([`underbrush_recording::Trial::touched`]). A sensor also reports forces where nothing touches it; such a trial
/// contains nothing to recognize, whatever its label.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyByTouch {
    /// Trials that an object touched; `None` if there are none, as in the other fields.
    pub touched: Option<Accuracy>,
    /// Trials that nothing touched.
    pub untouched: Option<Accuracy>,
    /// Trials for which this is unknown.
    pub unknown: Option<Accuracy>,
}

impl AccuracyByTouch {
    /// Divides predictions of a classifier with the categories `models`; `None` if all of them are unknown.
    pub(super) fn of(predictions: &[Prediction], models: &[String]) -> Option<Self> {
        let accuracy = |touched: Option<bool>| {
            let part = predictions.iter().filter(|own| own.touched == touched);
            ConfusionMatrix::of(part.map(|own| own.record(models)), models).accuracy()
        };
        predictions.iter().any(|own| own.touched.is_some()).then(|| AccuracyByTouch {
            touched: accuracy(Some(true)),
            untouched: accuracy(Some(false)),
            unknown: accuracy(None),
        })
    }
}

/// The figures of one true category.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CategoryFigures {
    /// The true category.
    pub category: String,
    /// Number of its trials.
    pub trials: usize,
    /// Number of them with the right verdict.
    pub correct: usize,
    /// Fraction of its trials with the right verdict.
    pub recall: f64,
    /// Wilson's 95 % interval of the recall.
    pub recall_interval: Interval,
    /// Fraction of right verdicts among all trials classified as this category; `None` if there are none.
    pub precision: Option<f64>,
    /// Harmonic mean of recall and precision; 0 if nothing is correct.
    pub f1: f64,
    /// Number of its trials called uncertain.
    pub uncertain: usize,
    /// Number of its trials called outliers.
    pub outlier: usize,
}

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

impl ConfusionMatrix {
    /// Counts verdicts of a classifier with these categories.
    pub fn of<'a>(records: impl IntoIterator<Item = Record<'a>>, categories: &[String]) -> Self {
        let mut verdict = categories.to_vec();
        verdict.extend([Verdict::Uncertain.name().to_owned(), Verdict::Outlier.name().to_owned()]);
        let mut rows: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for record in records {
            rows.entry(record.truth).or_insert_with(|| vec![0; verdict.len()])[record.verdict] += 1;
        }
        let (truth, count) = rows.into_iter().map(|(truth, row)| (truth.to_owned(), row)).unzip();
        ConfusionMatrix { truth, verdict, count }
    }

    /// The accuracy with its majority baseline and balanced accuracy; `None` without trials.
    pub fn accuracy(&self) -> Option<Accuracy> {
        let figures = self.figures();
        let trials: usize = figures.iter().map(|own| own.trials).sum();
        if trials == 0 {
            return None;
        }
        let fraction = |count: usize| count as f64 / trials as f64;
        let always = |verdict: usize| {
            let right = figures.iter().filter(|own| self.right_verdict(&own.category) == Some(verdict));
            right.map(|own| own.trials).sum()
        };
        let known = self.known();
        let of_known = figures.iter().filter(|own| known.contains(&own.category) && own.trials > 0);
        Some(Accuracy {
            trials,
            accuracy: fraction(figures.iter().map(|own| own.correct).sum()),
            majority_baseline: fraction((0..self.verdict.len()).map(always).max().unwrap_or(0)),
            balanced_accuracy: mean(of_known.map(|own| own.recall)),
        })
    }

    /// The rates of verdicts that were counted.
    pub(super) fn rates(&self) -> Rates {
        let categories = self.known().len();
        let share = |column: usize, counts: &dyn Fn(&str) -> bool| {
            let rows = self.truth.iter().zip(&self.count).filter(|(truth, _)| counts(truth));
            let taken: usize = rows.clone().map(|(_, row)| row[column]).sum();
            let all: usize = rows.flat_map(|(_, row)| row).sum();
            taken as f64 / all.max(1) as f64
        };
        let by_category = |own: bool| {
            let names = self.verdict[..categories].iter().enumerate();
            names.map(|(column, name)| (name.clone(), share(column, &|truth| (truth == name) == own))).collect()
        };
        Rates {
            verdicts: self.count.iter().flatten().sum(),
            false_positive_rate: by_category(false),
            true_positive_rate: by_category(true),
            uncertain: share(categories, &|_| true),
            outlier: share(categories + 1, &|_| true),
        }
    }

    /// The classifier's categories. The last two verdicts are uncertain and outlier.
    pub(super) fn known(&self) -> &[String] {
        &self.verdict[..self.verdict.len() - 2]
    }

    /// The verdict that is right for a category, if there is one.
    fn right_verdict(&self, category: &str) -> Option<usize> {
        (0..self.verdict.len()).find(|verdict| is_right(category, *verdict, self.known()))
    }

    /// Figures of each true category, in the order of the rows.
    pub fn figures(&self) -> Vec<CategoryFigures> {
        let models = self.known().len();
        let figures = self.truth.iter().zip(&self.count).map(|(category, row)| {
            let own = self.right_verdict(category);
            let trials = row.iter().sum();
            let correct = own.map_or(0, |column| row[column]);
            let taken: usize = own.map_or(0, |column| self.count.iter().map(|row| row[column]).sum());
            CategoryFigures {
                category: category.clone(),
                trials,
                correct,
                recall: correct as f64 / trials as f64,
                recall_interval: wilson(correct, trials),
                precision: share(correct, taken),
                f1: 2.0 * correct as f64 / (trials + taken) as f64,
                uncertain: row[models],
                outlier: row[models + 1],
            }
        });
        figures.collect()
    }
}

#[cfg(test)]
mod tests;
