//! Confusion matrices and the figures that follow from them.

use std::collections::BTreeSet;

use serde::Serialize;

use super::Prediction;
use super::interval::{Interval, wilson};
use crate::decision::Verdict;

/// Counts of true category against verdict.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ConfusionMatrix {
    /// True categories, one a row, in alphabetical order.
    pub truth: Vec<String>,
    /// Verdicts, one a column: the models' categories in alphabetical order, then uncertain and outlier.
    pub verdict: Vec<String>,
    /// Trials by row and column.
    pub count: Vec<Vec<usize>>,
}

/// How one category fares.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CategoryFigures {
    /// The true category.
    pub category: String,
    /// Its trials.
    pub trials: usize,
    /// Trials rightly taken for it.
    pub correct: usize,
    /// Correct ones among its trials.
    pub recall: f64,
    /// Wilson's 95 % interval of the recall.
    pub recall_interval: Interval,
    /// Correct ones among all trials taken for it; `None` where none was.
    pub precision: Option<f64>,
    /// Harmonic mean of recall and precision; 0 where nothing is correct.
    pub f1: f64,
    /// Its trials called uncertain.
    pub uncertain: usize,
    /// Its trials called outliers.
    pub outlier: usize,
}

impl ConfusionMatrix {
    /// Counts predictions made with models of these categories.
    pub(super) fn of(predictions: &[Prediction], models: &[String]) -> Self {
        let truth: BTreeSet<&str> = predictions
            .iter()
            .map(|prediction| prediction.category.as_str())
            .collect();
        let truth: Vec<String> = truth.into_iter().map(str::to_owned).collect();
        let mut verdict = models.to_vec();
        verdict.extend([Verdict::Uncertain.name().to_owned(), Verdict::Outlier.name().to_owned()]);
        let mut count = vec![vec![0; verdict.len()]; truth.len()];
        for prediction in predictions {
            let column = match &prediction.verdict {
                Verdict::Category(name) => models.iter().position(|model| model == name),
                Verdict::Uncertain => Some(models.len()),
                Verdict::Outlier => Some(models.len() + 1),
            };
            let row = truth.iter().position(|category| *category == prediction.category);
            if let (Some(row), Some(column)) = (row, column) {
                count[row][column] += 1;
            }
        }
        ConfusionMatrix { truth, verdict, count }
    }

    /// Figures of each true category, in the order of the rows.
    pub fn figures(&self) -> Vec<CategoryFigures> {
        let models = self.verdict.len() - 2;
        let outlier = Verdict::Outlier.name();
        let figures = self.truth.iter().zip(&self.count).map(|(category, row)| {
            let mut own = self.verdict[..models].iter().position(|name| name == category);
            if own.is_none() && category == outlier {
                own = Some(models + 1);
            }
            let trials = row.iter().sum();
            let correct = own.map_or(0, |column| row[column]);
            let taken: usize = own.map_or(0, |column| self.count.iter().map(|row| row[column]).sum());
            CategoryFigures {
                category: category.clone(),
                trials,
                correct,
                recall: correct as f64 / trials as f64,
                recall_interval: wilson(correct, trials),
                precision: (taken > 0).then(|| correct as f64 / taken as f64),
                f1: 2.0 * correct as f64 / (trials + taken) as f64,
                uncertain: row[models],
                outlier: row[models + 1],
            }
        });
        figures.collect()
    }
}
