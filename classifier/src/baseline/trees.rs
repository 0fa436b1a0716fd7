//! Gradient-boosted trees over stream features.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Sample, math};

use super::fitted::{self, Baseline, TrialsByCategory};
use super::table::Table;
use crate::boosted::{Boosted, Loss, Row};
use crate::error::{ModelError, ValueFault};
use crate::stream_feature::{Selection, StreamFeatures, TAXEL_AND_REGION};
use crate::{ClassifierKind, FeatureSet, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<Trees>(
    &[],
    "Gradient-boosted trees on the same statistics as logistic; no assumption about their shape",
    |features| Box::new(Trees { features: features.unwrap_or(TAXEL_AND_REGION) }),
);

/// Gradient-boosted trees: for each category, trees give the probability that a contact with these stream features belongs to
/// it and not to another. The probabilities are normalized.
///
/// Each training contact is used at several times ([`crate::stream_feature::SAMPLE_COUNTS`]), so that scores are meaningful at
/// any time.
///
/// ```
/// use underbrush_classifier::baseline::Trees;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_classifier::feature::FeatureSet;
/// use underbrush_recording::{Sample, Trial};
///
/// // Leaves are between two kinds of trunk, so no line divides them.
/// let press = |category: &str, newtons: f64| Trial {
///     trial: 0,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: vec![Sample { time_s: 0.01, force_n: newtons, ..Sample::default() }],
/// };
/// let of = |k: u32| {
///     let force_n = 0.1 * f64::from(k);
///     press(if (10..20).contains(&k) { "leaf" } else { "trunk" }, force_n)
/// };
/// let trials: Vec<Trial> = (0..30).map(of).collect();
///
/// let classifier = Trees { features: FeatureSet::FORCE }.fit(&trials.iter().collect::<Vec<_>>())?;
/// for (newtons, is_leaf) in [(0.3, false), (1.45, true), (2.5, false)] {
///     let scores = &classifier.scores_after(&press("leaf", newtons), &[1])?[0];
///     assert_eq!(scores[0] > scores[1], is_leaf, "{newtons} N");
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trees {
    /// The features of each sample that stream features are computed from.
    pub features: FeatureSet,
}

/// Trees for each category, in their order.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "TreesParameters")]
pub(super) struct Parameters {
    trees: Vec<Boosted>,
}

impl Baseline for Trees {
    const NAME: &'static str = "trees";
    type Parameters = Parameters;
    type Contact = StreamFeatures;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let selection = Selection::of(self.features);
        let table = Table::of(trials, &selection)?;
        let features: Vec<Vec<f32>> = table.rows.iter().map(|row| single(&row.features)).collect();
        let trees = |category: usize| {
            // The category weighs as much as all others together.
            let share = 1.0 / table.categories as f64;
            let rows = table.rows.iter().zip(&features).map(|(row, features)| {
                let is_family = row.category == category;
                let weight = row.weight / if is_family { share } else { (1.0 - share).max(share) };
                Row { features, target: f64::from(is_family), weight }
            });
            let rows: Vec<Row<'_>> = rows.collect();
            Boosted::fit(Loss::Logistic, &rows, selection.dimension())
        };
        let trees = (0..table.categories).into_par_iter().map(trees).collect();
        Ok(Parameters { trees })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let dimension = Selection::of(self.features).dimension();
        let fits = |own: &Boosted| own.features() == dimension;
        if parameters.trees.len() != categories || !parameters.trees.iter().all(fits) {
            let found = format!("trees of {} categories", parameters.trees.len());
            let allowed = format!("trees of {categories} categories over {dimension} stream features");
            return Err(ValueFault::new("trees", found, allowed));
        }
        Ok(())
    }

    fn push(&self, _: &Parameters, contact: &mut StreamFeatures, sample: &Sample) -> Result<bool, SampleFault> {
        Selection::of(self.features).push(contact, sample).map(|()| true)
    }

    fn scores(&self, parameters: &Parameters, contact: &StreamFeatures, scores: &mut [f64]) {
        let features = single(&Selection::of(self.features).values(contact));
        for (score, trees) in scores.iter_mut().zip(&parameters.trees) {
            *score = 1.0 / (1.0 + math::exp(-trees.score(&features)));
        }
        let total: f64 = scores.iter().sum();
        scores.iter_mut().for_each(|score| *score = math::ln(*score / total));
    }
}

/// In the precision of the trees' cuts. Numbers beyond its range stay at its ends.
fn single(features: &[f64]) -> Vec<f32> {
    let most = f64::from(f32::MAX);
    features.iter().map(|feature| feature.clamp(-most, most) as f32).collect()
}
