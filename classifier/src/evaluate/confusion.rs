//! Confusion matrices and the figures that follow from them.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use underbrush_recording::Category;

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

/// An accuracy and the two figures without which it says little.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Trials judged.
    pub trials: usize,
    /// Fraction of trials whose verdict is the truth. Uncertain counts as wrong, and so does outlier, except for trials
    /// of the category outlier. No verdict is right for a trial of the category block.
    pub accuracy: f64,
    /// What one would reach by giving every trial the same verdict: the fraction of trials that belong to the most
    /// frequent true category. Blocks do not count as such a category, because no verdict is right for them.
    pub majority_baseline: f64,
    /// The mean of the recalls of the classifier's categories, each with the same weight: giving every trial the same
    /// verdict reaches 1 / (number of categories), however the trials are distributed. Categories that the classifier
    /// does not know (blocks, outliers, foreign names) and categories without trials have no part in it; `None` where
    /// no trial is of a category that the classifier knows.
    pub balanced_accuracy: Option<f64>,
}

/// An accuracy split by whether an object truly pressed during at least one sample of a trial
/// ([`underbrush_recording::Trial::touched`]). A sensor also reports forces where nothing touches it; in such a trial
/// there is nothing to be recognized, whatever its label says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyByTouch {
    /// Of trials that an object touched; `None` where there are none, as in the other fields.
    pub touched: Option<Accuracy>,
    /// Of trials that nothing touched.
    pub untouched: Option<Accuracy>,
    /// Of trials of which this is not known.
    pub unknown: Option<Accuracy>,
}

impl AccuracyByTouch {
    /// Splits predictions made with models of these categories; `None` where it is known of none whether it was touched.
    pub(super) fn of<'a>(predictions: impl IntoIterator<Item = &'a Prediction>, models: &[String]) -> Option<Self> {
        let (mut touched, mut untouched, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
        for prediction in predictions {
            match prediction.touched {
                Some(true) => touched.push(prediction),
                Some(false) => untouched.push(prediction),
                None => unknown.push(prediction),
            }
        }
        let accuracy = |part: Vec<&Prediction>| ConfusionMatrix::of(part, models).accuracy();
        (touched.len() + untouched.len() > 0).then(|| AccuracyByTouch {
            touched: accuracy(touched),
            untouched: accuracy(untouched),
            unknown: accuracy(unknown),
        })
    }
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
    pub(super) fn of<'a>(predictions: impl IntoIterator<Item = &'a Prediction>, models: &[String]) -> Self {
        let predictions: Vec<&Prediction> = predictions.into_iter().collect();
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

    /// The accuracy with its majority baseline and the balanced accuracy; `None` without trials.
    pub fn accuracy(&self) -> Option<Accuracy> {
        let figures = self.figures();
        let trials: usize = figures.iter().map(|own| own.trials).sum();
        if trials == 0 {
            return None;
        }
        let fraction = |count: usize| count as f64 / trials as f64;
        let majority = figures
            .iter()
            .filter(|own| own.category != Category::BLOCK.name())
            .map(|own| own.trials)
            .max();
        let known = &self.verdict[..self.verdict.len() - 2];
        let recalls: Vec<f64> = figures
            .iter()
            .filter(|own| known.contains(&own.category) && own.trials > 0)
            .map(|own| own.recall)
            .collect();
        Some(Accuracy {
            trials,
            accuracy: fraction(figures.iter().map(|own| own.correct).sum()),
            majority_baseline: fraction(majority.unwrap_or(0)),
            balanced_accuracy: (!recalls.is_empty()).then(|| recalls.iter().sum::<f64>() / recalls.len() as f64),
        })
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

#[cfg(test)]
mod tests;
