//! The authors' earlier method: k nearest neighbours on principal components of a fixed window.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Limits, Sample, math};

use super::fitted::{self, Baseline, Columns, FITTED, TrialsByCategory, check_list, check_table, columns};
use crate::error::{ModelError, ValueFault, check_limits};
use crate::estimator::ClassifierKind;
use crate::feature::{AREA, FORCE, FeatureSet, MOTION, SampleFault};

/// The entry in the list of classifiers.
pub(crate) const KIND: ClassifierKind = fitted::kind::<NearestNeighbours>(
    &[],
    "The authors' earlier method: nearest neighbours on principal components of the first half second",
    |features| Box::new(NearestNeighbours { features: features.unwrap_or(DEFAULT.features), ..DEFAULT }),
);

/// Samples of a window. Choice: ten seconds at 100 Hz; the cost of a fit grows with the cube of the window.
const WINDOW: Limits = Limits::new(1.0, 1000.0, "samples");

/// Neighbours that vote. Choice: far more than any sensible number.
const NEIGHBOURS: Limits = Limits::new(1.0, 1e6, "neighbours");

/// Explained fraction of the variance; at 0 one component is kept.
const EXPLAINED: Limits = Limits::new(0.0, 1.0, "");

/// k nearest neighbours on principal components of force, contact area and contact motion over a window from the first
/// contact (Bhattacharjee, Rehg, Kemp, IROS 2012). Contact area is the number of taxels in the contact region.
///
/// The score of a category is the logarithm of its share of the votes, corrected for its number of training trials. The
/// method needs sequences of equal length: a trial shorter than the window, or not yet as long, is padded with its last
/// sample, and samples after the window are ignored. It assumes that trials of a category are close to each other in
/// Euclidean distance, sample by sample from the first contact.
///
/// ```
/// use underbrush_classifier::baseline::NearestNeighbours;
/// use underbrush_classifier::estimator::Estimator;
/// use underbrush_recording::{Region, Sample, Trial};
///
/// let press = |category: &str, newtons: f64, number: u64| Trial {
///     trial: number,
///     category: Some(category.into()),
///     reach: None,
///     patch: None,
///     taxel: None,
///     samples: (1..=20)
///         .map(|k| Sample {
///             time_s: 0.01 * f64::from(k),
///             force_n: newtons * f64::from(k) + 0.01 * number as f64,
///             motion_m: Some(0.001 * f64::from(k)),
///             region: Some(Region { taxels: 2, largest_force_n: newtons * 30.0, force_sum_n: newtons * 40.0 }),
///             ..Sample::default()
///         })
///         .collect(),
/// };
/// let trials: Vec<Trial> = (0..8).flat_map(|k| [press("leaf", 0.02, k), press("trunk", 0.3, k)]).collect();
///
/// let classifier = NearestNeighbours::default().fit(&trials.iter().collect::<Vec<_>>())?;
/// // After twenty samples of a new contact; after very few, a hard press looks like the plateau of a soft one.
/// let scores = &classifier.scores_after(&press("trunk", 0.25, 3), &[20])?[0];
/// assert!(scores[1] > scores[0], "trunk is more likely than leaf");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NearestNeighbours {
    /// The features of each sample of the window.
    pub features: FeatureSet,
    /// Samples of the window, at least 1.
    #[schemars(range(min = WINDOW.min, max = WINDOW.max))]
    pub window: usize,
    /// Neighbours that vote, at least 1.
    #[schemars(range(min = NEIGHBOURS.min, max = NEIGHBOURS.max))]
    pub neighbours: usize,
    /// Principal components are kept until they explain this fraction of the variance.
    #[schemars(range(min = EXPLAINED.min, max = EXPLAINED.max))]
    pub explained: f64,
}

/// The default options.
const DEFAULT: NearestNeighbours = NearestNeighbours {
    features: FeatureSet::new([&FORCE, &AREA, &MOTION]),
    window: 50,
    neighbours: 5,
    explained: 0.95,
};

impl Default for NearestNeighbours {
    /// Choice: half a second at 100 Hz, since most contacts are shorter, and padding them further adds nothing; five
    /// votes, and the components that explain 95 % of the variance.
    fn default() -> Self {
        DEFAULT
    }
}

impl NearestNeighbours {
    /// The first feature at each sample of the window, then the second, and so on. A window that is not full is padded
    /// with the last sample.
    fn channels(&self, samples: &[f64]) -> Vec<f64> {
        let dimension = self.features.dimension();
        let last = samples.len() / dimension - 1;
        let of_channel = |channel| (0..self.window).map(move |k| samples[k.min(last) * dimension + channel]);
        (0..dimension).flat_map(of_channel).collect()
    }
}

impl Baseline for NearestNeighbours {
    const NAME: &'static str = "nearest-neighbours";
    type Parameters = Parameters;
    /// The samples of the window so far, one after the other.
    type Contact = Vec<f64>;

    fn features(&self) -> FeatureSet {
        self.features
    }

    fn check(&self) -> Result<(), ValueFault> {
        check_limits("window", self.window as f64, WINDOW)?;
        check_limits("neighbours", self.neighbours as f64, NEIGHBOURS)?;
        check_limits("explained", self.explained, EXPLAINED)
    }

    fn learn(&self, trials: &TrialsByCategory) -> Result<Parameters, ModelError> {
        let (mut rows, mut category_of) = (Vec::new(), Vec::new());
        for (category, trials) in trials.values().enumerate() {
            for trial in trials {
                let observations = self.features.observations(trial, Some(self.window))?;
                let samples: Vec<f64> = observations.samples().flatten().copied().collect();
                rows.push(self.channels(&samples));
                category_of.push(category);
            }
        }
        let (mean, scale) = scaling(&rows, self.window);
        let mut matrix = DMatrix::from_fn(rows.len(), mean.len(), |row, d| rows[row][d]);
        for (d, mut column) in matrix.column_iter_mut().enumerate() {
            column.iter_mut().for_each(|value| *value = (*value - mean[d]) * scale[d / self.window]);
        }
        let components = principal_components(&matrix, self.explained);
        Ok(Parameters {
            mean,
            scale,
            // Not with `*`, for which nalgebra calls a library whose last digits depend on the processor.
            trials: Columns(components.tr_mul(&matrix.transpose())),
            components: Columns(components),
            category: category_of,
        })
    }

    fn check_parameters(&self, parameters: &mut Parameters, categories: usize) -> Result<(), ValueFault> {
        let Parameters { mean, scale, components, category, trials } = parameters;
        let (channels, count) = (self.features.dimension(), components.0.ncols());
        let length = channels * self.window;
        check_list("mean", mean, length, FITTED)?;
        check_list("scale", scale, channels, FITTED)?;
        check_table("components", &columns(&components.0), (count.max(1), length), FITTED)?;
        check_table("trials", &columns(&trials.0), (category.len(), count), FITTED)?;
        if let Some(missing) = (0..categories).find(|missing| !category.contains(missing)) {
            return Err(ValueFault::new("category", format!("no trial of category {missing}"), "a trial of each"));
        }
        if category.iter().any(|category| *category >= categories) {
            let found = format!("an index beyond {}", categories - 1);
            return Err(ValueFault::new("category", found, "indices of categories, from 0"));
        }
        Ok(())
    }

    fn push(&self, _: &Parameters, contact: &mut Vec<f64>, sample: &Sample) -> Result<bool, SampleFault> {
        self.features.push_within(self.window, contact, sample)
    }

    /// The logarithm of each category's votes divided by its number of training trials, because frequent categories
    /// have more neighbours. One additional vote is divided among the categories in proportion to these numbers, so that none is
    /// impossible, and categories without a neighbour have the same score.
    fn scores(&self, parameters: &Parameters, contact: &Vec<f64>, scores: &mut [f64]) {
        let Parameters { mean, scale, components, category, trials } = parameters;
        let mut channels = self.channels(contact);
        for (d, value) in channels.iter_mut().enumerate() {
            *value = (*value - mean[d]) * scale[d / self.window];
        }
        let query = components.0.tr_mul(&DVector::from_vec(channels));
        let distances = trials.0.column_iter().map(|known| (known - &query).norm_squared());
        let mut nearest: Vec<(f64, usize)> = distances.zip(category.iter().copied()).collect();
        let by_distance = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let votes = self.neighbours.min(nearest.len());
        if votes < nearest.len() {
            nearest.select_nth_unstable_by(votes, by_distance);
        }
        let mut count = vec![0_usize; scores.len()];
        for known in category {
            count[*known] += 1;
        }
        let mut share: Vec<f64> = count.iter().map(|count| *count as f64 / category.len() as f64).collect();
        for (_, category) in &nearest[..votes] {
            share[*category] += 1.0;
        }
        for ((score, share), count) in scores.iter_mut().zip(share).zip(count) {
            *score = math::ln(share / count as f64);
        }
    }
}

/// The mean of each column, and for each channel the reciprocal of its standard deviation, so that newtons, taxels and
/// metres have similar weight; 0 for a channel that never varies between rows.
fn scaling(rows: &[Vec<f64>], window: usize) -> (Vec<f64>, Vec<f64>) {
    let count = rows.len() as f64;
    let mean: Vec<f64> = (0..rows[0].len()).map(|d| rows.iter().map(|row| row[d]).sum::<f64>() / count).collect();
    let scale_of = |channel: usize| {
        let columns = channel * window..(channel + 1) * window;
        // Rounding accumulates in the mean of many rows, so whether a channel varies is not told by its variance alone.
        if columns.clone().all(|d| rows.iter().all(|row| row[d] == rows[0][d])) {
            return 0.0;
        }
        let largest = columns.clone().flat_map(|d| rows.iter().map(move |row| row[d].abs()));
        let largest = largest.fold(0.0, f64::max);
        let squares = |d: usize| rows.iter().map(|row| (row[d] - mean[d]).powi(2)).sum::<f64>();
        let variance = columns.map(squares).sum::<f64>() / count / window as f64;
        let deviation = variance.sqrt();
        // A deviation of the size of rounding means nothing.
        if deviation > 1e-14 * largest { deviation.recip() } else { 0.0 }
    };
    let scale = (0..mean.len() / window).map(scale_of).collect();
    (mean, scale)
}

/// The first principal components of centred rows, as columns: as many as are needed to explain the fraction, and at
/// least one.
fn principal_components(rows: &DMatrix<f64>, explained: f64) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(rows.tr_mul(rows));
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]).then(a.cmp(&b)));
    let total: f64 = eigen.eigenvalues.iter().map(|value| value.max(0.0)).sum();
    let mut so_far = 0.0;
    let kept = order.iter().take_while(|&&index| {
        let wanted = so_far < explained * total;
        so_far += eigen.eigenvalues[index].max(0.0);
        wanted
    });
    let kept = kept.count().max(1);
    eigen.eigenvectors.select_columns(&order[..kept])
}

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "NearestNeighboursParameters")]
pub(super) struct Parameters {
    /// Mean of each channel at each sample of the window.
    mean: Vec<f64>,
    /// Factor that each channel's deviation from the mean is multiplied by.
    scale: Vec<f64>,
    /// One row per component.
    components: Columns,
    /// Index of the category of each training trial.
    category: Vec<usize>,
    /// One row per training trial.
    trials: Columns,
}
