//! The authors' earlier method: k nearest neighbours on principal components of a fixed window.

use nalgebra::{DMatrix, SymmetricEigen};
use underbrush_recording::Trial;

use crate::estimator::{Classifier, Estimator};
use crate::feature::{AREA, FORCE, FeatureError, FeatureSet, MOTION};
use crate::model_set::{ModelError, trials_by_category};

/// k nearest neighbours on principal components of force, contact area and contact motion over a window from the first
/// contact (Bhattacharjee, Rehg, Kemp, IROS 2012). Contact area is the number of taxels of the contact region.
///
/// The method needs sequences of equal length: a trial shorter than the window, or not yet as long, is padded with its
/// last sample, and what comes after the window has no part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestNeighbours {
    /// What a sample of the window holds.
    pub features: FeatureSet,
    /// Samples of the window, at least 1.
    pub window: usize,
    /// Neighbours that vote, at least 1.
    pub neighbours: usize,
    /// Principal components are kept until they explain this fraction of the variance.
    pub explained: f64,
}

impl Default for NearestNeighbours {
    /// Half a second at 100 Hz by choice: most contacts are shorter, and padding them further adds nothing; five votes,
    /// and the components that explain 95 % of the variance.
    fn default() -> Self {
        NearestNeighbours {
            features: FeatureSet::new([&FORCE, &AREA, &MOTION]),
            window: 50,
            neighbours: 5,
            explained: 0.95,
        }
    }
}

impl Estimator for NearestNeighbours {
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError> {
        if self.window == 0 || self.neighbours == 0 {
            return Err(ModelError::Mismatch {
                found: format!("{} samples and {} neighbours", self.window, self.neighbours),
                allowed: "at least 1 of each".into(),
            });
        }
        let by_category = trials_by_category(trials.iter().copied());
        if by_category.is_empty() {
            return Err(ModelError::NoCategories { trials: trials.len() });
        }
        let (mut rows, mut category_of) = (Vec::new(), Vec::new());
        for (category, trials) in by_category.values().enumerate() {
            for trial in trials {
                rows.push(window(self.features, trial, self.window, trial.samples.len())?);
                category_of.push(category);
            }
        }
        let (mean, scale) = scaling(&rows, self.window);
        let mut matrix = DMatrix::from_fn(rows.len(), mean.len(), |row, d| rows[row][d]);
        for (d, mut column) in matrix.column_iter_mut().enumerate() {
            column
                .iter_mut()
                .for_each(|value| *value = (*value - mean[d]) * scale[d / self.window]);
        }
        let components = principal_components(&matrix, self.explained);
        Ok(Box::new(Fitted {
            options: *self,
            count: by_category.values().map(Vec::len).collect(),
            categories: by_category.into_keys().collect(),
            mean,
            scale,
            known: (&matrix * &components).transpose(),
            components,
            category_of,
        }))
    }
}

/// The first feature at each sample of the window, then the second, and so on, of the trial's first `count` samples.
fn window(features: FeatureSet, trial: &Trial, window: usize, count: usize) -> Result<Vec<f64>, FeatureError> {
    let observations = features.observations(trial, Some(count.min(window)))?;
    let last = observations.sample_count() - 1;
    let channels = 0..features.dimension();
    let of_channel = |channel| (0..window).map(move |k: usize| (k.min(last), channel));
    Ok(channels
        .flat_map(of_channel)
        .map(|(sample, channel)| observations.sample(sample)[channel])
        .collect())
}

/// The mean of each column, and for each channel one over its deviation, so that newtons, taxels and metres weigh alike.
fn scaling(rows: &[Vec<f64>], window: usize) -> (Vec<f64>, Vec<f64>) {
    let count = rows.len() as f64;
    let mean: Vec<f64> = (0..rows[0].len())
        .map(|d| rows.iter().map(|row| row[d]).sum::<f64>() / count)
        .collect();
    let scale_of = |channel: usize| {
        let columns = channel * window..(channel + 1) * window;
        let squares = |d: usize| rows.iter().map(|row| (row[d] - mean[d]).powi(2)).sum::<f64>();
        let variance = columns.map(squares).sum::<f64>() / count / window as f64;
        if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
    };
    let scale = (0..mean.len() / window).map(scale_of).collect();
    (mean, scale)
}

/// The first principal directions of centred rows, one a column, that explain the fraction; at least one.
fn principal_components(rows: &DMatrix<f64>, explained: f64) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(rows.transpose() * rows);
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

struct Fitted {
    options: NearestNeighbours,
    categories: Vec<String>,
    /// Training trials by category.
    count: Vec<usize>,
    mean: Vec<f64>,
    scale: Vec<f64>,
    components: DMatrix<f64>,
    /// Training trials, one a column.
    known: DMatrix<f64>,
    category_of: Vec<usize>,
}

impl Fitted {
    /// ln of votes over trials of the category: frequent categories have more neighbours to offer. Each category has one
    /// vote more than its neighbours, shared among all, so that none is ever impossible.
    fn scores(&self, mut channels: Vec<f64>) -> Vec<f64> {
        for (d, value) in channels.iter_mut().enumerate() {
            *value = (*value - self.mean[d]) * self.scale[d / self.options.window];
        }
        let query = self.components.tr_mul(&nalgebra::DVector::from_vec(channels));
        let distances = self.known.column_iter().map(|known| (known - &query).norm_squared());
        let mut nearest: Vec<(f64, usize)> = distances.zip(self.category_of.iter().copied()).collect();
        let by_distance = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let votes = self.options.neighbours.min(nearest.len());
        if votes < nearest.len() {
            nearest.select_nth_unstable_by(votes, by_distance);
        }
        let mut share = vec![1.0 / self.categories.len() as f64; self.categories.len()];
        nearest[..votes]
            .iter()
            .for_each(|&(_, category)| share[category] += 1.0);
        share
            .iter()
            .zip(&self.count)
            .map(|(share, count)| (share / *count as f64).ln())
            .collect()
    }
}

impl Classifier for Fitted {
    fn categories(&self) -> Vec<String> {
        self.categories.clone()
    }

    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        counts
            .iter()
            .map(|&count| Ok(self.scores(window(self.options.features, trial, self.options.window, count)?)))
            .collect()
    }
}
