//! Outliers: verdicts in the outlier reaches by the paper's thresholds, by chosen thresholds, and for any threshold
//! (Fig. 15).

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use serde::Serialize;
use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::ChosenThresholds;
use underbrush_recording::{Category, Fault};

use crate::frame_verdicts::{self, Classified, Online};
use crate::online_models::{self, Thresholds};
use crate::session::Session;

/// The effect of the thresholds.
#[derive(Serialize)]
pub struct OutlierThresholds {
    /// Verdicts in the outlier reaches.
    pub figure_15: Outliers,
    /// Thresholds chosen from the training data; `None` if none meet the requested rates.
    pub thresholds: Option<ChosenThresholds>,
    /// Areas under the receiver operating characteristics.
    pub roc: Areas,
    /// The ROC curves, and the reason if there are no thresholds.
    #[serde(skip)]
    pub curves: Rc<Thresholds>,
    /// All reaches.
    #[serde(skip)]
    pub online: Rc<Online>,
}

/// Verdicts in the outlier reaches.
#[derive(Serialize)]
pub struct Outliers {
    /// Reaches drawn.
    pub drawn: u64,
    /// Reaches that meet the requirement.
    pub reaches: usize,
    /// By rule and by category of the object that truly presses.
    pub detection: Vec<Detection>,
}

/// Verdicts of one decision rule on the taxels that truly touch something (section V-D).
#[derive(Clone, Debug, Serialize)]
pub struct Detection {
    /// The rule.
    pub rule: String,
    /// Category of the object that presses.
    pub truth: &'static str,
    /// Taxels in contact, summed over frames.
    pub taxel_frames: usize,
    /// Per cent by verdict: `leaf_percent`, `uncertain_percent`, and so on.
    #[serde(flatten)]
    pub percent: BTreeMap<String, f64>,
}

/// Areas under the curves; 0.5 is chance.
#[derive(Serialize)]
pub struct Areas {
    /// Outliers against known categories.
    pub outlier_area: Option<f64>,
}

impl Detection {
    /// The share of a verdict, per cent.
    pub fn percent_of(&self, verdict: &str) -> f64 {
        self.percent.get(&format!("{verdict}_percent")).copied().unwrap_or(0.0)
    }
}

/// Prefix of the names of the chosen thresholds.
pub const CHOSEN: &str = "chosen";

/// Counts verdicts by both rules.
pub fn run(session: &Session) -> Result<OutlierThresholds, Fault> {
    let (online, curves) = (session.once(frame_verdicts::run)?, session.once(online_models::thresholds)?);
    let mut found = detection(&rule_name("the paper's", &Decision::paper()), &online.outlier);
    if let Some((decision, reaches)) = &online.outlier_by_chosen {
        found.extend(detection(&rule_name(CHOSEN, decision), reaches));
    }
    Ok(OutlierThresholds {
        figure_15: Outliers { drawn: online.outlier_drawn, reaches: online.outlier.len(), detection: found },
        thresholds: curves.chosen.as_ref().ok().cloned(),
        roc: Areas { outlier_area: curves.outlier_roc.as_ref().map(|curve| curve.area) },
        curves,
        online,
    })
}

fn rule_name(whose: &str, decision: &Decision) -> String {
    match decision.rule {
        Rule::OutlierBand { uncertain_below, category_above } => {
            format!("{whose}: {uncertain_below:.1} and {category_above:.1}")
        }
        Rule::UncertainBelow { margin } => format!("{whose}: {margin:.1}"),
        Rule::Argmax => whose.to_owned(),
    }
}

/// One row for each category that presses on a taxel, over all reaches of a rule.
fn detection(rule: &str, reaches: &[Classified]) -> Vec<Detection> {
    let of = |category: Category| {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for reach in reaches {
            let row = reach.stream.truths.iter().position(|truth| *truth == category);
            let counted = row.and_then(|row| reach.stream.taxel_frames.get(row)).into_iter().flatten();
            for (verdict, count) in reach.stream.verdicts.iter().zip(counted) {
                *counts.entry(verdict).or_default() += count;
            }
        }
        let taxel_frames: usize = counts.values().sum();
        let percent = |count: usize| 100.0 * count as f64 / taxel_frames as f64;
        (taxel_frames > 0).then(|| Detection {
            rule: rule.into(),
            truth: category.name(),
            taxel_frames,
            percent: counts.iter().map(|(verdict, count)| (format!("{verdict}_percent"), percent(*count))).collect(),
        })
    };
    let truths: BTreeSet<Category> = reaches.iter().flat_map(|reach| &reach.stream.truths).copied().collect();
    truths.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::evaluate::Stream;

    use super::*;

    const REED: Category = Category::new("reed", 4).unwrap();

    /// Tests that taxels under an object of a further category are counted in a row of their own, even if only one of
    /// the reaches has such an object.
    #[test]
    fn a_further_category_has_a_row_of_its_own() {
        let reach = |truths: Vec<Category>, taxel_frames: Vec<Vec<usize>>| Classified {
            reach_index: 0,
            stream: Stream { truths, verdicts: vec!["reed".into(), "trunk".into()], taxel_frames, ..Stream::default() },
        };
        let reaches = [
            reach(vec![Category::TRUNK], vec![vec![1, 3], vec![9, 9]]),
            reach(vec![Category::TRUNK, REED], vec![vec![0, 4], vec![6, 2], vec![9, 9]]),
        ];
        let found = detection("any rule", &reaches);
        let row = |own: &Detection| (own.truth, own.taxel_frames, own.percent_of("reed"), own.percent_of("trunk"));
        let rows: Vec<_> = found.iter().map(row).collect();
        assert_eq!(rows, [("trunk", 8, 12.5, 87.5), ("reed", 8, 75.0, 25.0)]);
    }
}
