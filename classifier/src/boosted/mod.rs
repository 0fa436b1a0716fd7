//! Gradient-boosted trees (Friedman 2001). They tell one class, the *family*, from all else: a family of unknown objects from
//! known ones, or one category from the others. Or they estimate a number.
//!
//! Each tree is fitted to the gradient of the [`Loss`] at the sum of the earlier ones, by its second-order expansion: a
//! leaf adds Σ g / (Σ h + λ), shrunk, with the gradient g and the curvature h of each row, and a cut is
//! the one that gains most of (Σ g)² / (Σ h + λ). Cuts are sought between quantiles of each feature. Nothing is drawn, so the same
//! rows give the same trees.

use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{math, stop};

use packed::{Node, Packed, Span};

mod packed;
#[cfg(test)]
mod tests;

/// Number of trees, and the share of its step that each of them takes. Choices, in the usual range. Other numbers, depths and parts of
/// the features and rows for each tree gain nothing (docs/evidence/unknown-objects.md).
const TREES: usize = 200;
const RATE: f64 = 0.06;
/// Leaves are at most this deep and have at least this many rows, or a tenth of all rows if these are few. Choices: interactions of
/// four features, and no leaf for a single object.
const DEPTH: usize = 4;
const LEAF_ROWS: usize = 20;
/// Added to the curvature of a leaf, in rows of mean weight, so that leaves that are sure of themselves stay finite.
const RIDGE: f64 = 1.0;
/// Number of cuts that are tried for each feature. Choice: the time of a fit grows with it; no other was tried.
const CUTS: usize = 64;
/// Leaves hold whole multiples of this log-odds, or of this part of the unit of the target.
const UNIT: f64 = 1e-4;

/// A row to fit to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row<'a> {
    pub(crate) features: &'a [f32],
    /// 1 for the family and 0 for all else, or the number to estimate.
    pub(crate) target: f64,
    pub(crate) weight: f64,
}

/// What the trees are fitted to, for a row with target y and weight w where the earlier trees sum to s.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Loss {
    /// The log-odds of the family: g = w (y − p) and h = w p (1 − p) with p = 1 / (1 + exp(−s)).
    Logistic,
    /// A number: g = w (y − s) and h = w.
    Squared,
}

impl Loss {
    fn slopes(self, target: f64, weight: f64, score: f64) -> Slopes {
        match self {
            Loss::Logistic => {
                let probability = 1.0 / (1.0 + math::exp(-score));
                Slopes::new(weight * (target - probability), weight * probability * (1.0 - probability), 1.0)
            }
            Loss::Squared => Slopes::new(weight * (target - score), weight, 1.0),
        }
    }
}

/// Trees whose sum is the log-odds of a family, or a number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Packed", into = "Packed")]
pub(crate) struct Boosted {
    /// One for each feature.
    spans: Vec<Span>,
    trees: Vec<Vec<Node>>,
}

impl Boosted {
    /// Fits trees to rows with this many features. The sum begins at 0, so both classes should weigh the same, and numbers should
    /// lie around 0. The result is the same for any number of threads.
    pub(crate) fn fit(loss: Loss, rows: &[Row<'_>], features: usize) -> Self {
        let columns: Vec<Column> = (0..features).into_par_iter().map(|feature| Column::of(rows, feature)).collect();
        let mean = rows.iter().map(|row| row.weight).sum::<f64>() / rows.len().max(1) as f64;
        let mut boosting = Boosting {
            loss,
            columns: &columns,
            targets: rows.iter().map(|row| (row.target, row.weight / mean)).collect(),
            scores: vec![0.0; rows.len()],
            slopes: vec![Slopes::ZERO; rows.len()],
            leaf_rows: LEAF_ROWS.min(rows.len() / 10).max(1),
        };
        let tree = |_| {
            stop::check();
            boosting.tree()
        };
        let trees = (0..TREES).map(tree).collect();
        Boosted { trees, spans: columns.iter().map(|column| column.span).collect() }
    }

    /// The number of features.
    pub(crate) fn features(&self) -> usize {
        self.spans.len()
    }

    /// The logarithm of the odds of the family, or the number.
    pub(crate) fn score(&self, features: &[f32]) -> f64 {
        let steps: i64 = self.trees.iter().map(|tree| i64::from(self.step(tree, features))).sum();
        UNIT * steps as f64
    }

    fn step(&self, tree: &[Node], features: &[f32]) -> i16 {
        let mut node = 0;
        loop {
            match tree[node] {
                Node::Leaf(step) => return step,
                Node::Cut { feature, cut, right } => {
                    let feature = usize::from(feature);
                    let is_left = features[feature] <= self.spans[feature].at(cut);
                    node = if is_left { node + 1 } else { right as usize };
                }
            }
        }
    }
}

/// A feature of all rows.
struct Column {
    span: Span,
    /// Ascending; a row goes to the left of a cut if its feature is at most this.
    cuts: Vec<u16>,
    /// For each row, how many cuts are below its feature.
    bins: Vec<u8>,
}

impl Column {
    fn of(rows: &[Row<'_>], feature: usize) -> Self {
        let mut values: Vec<f32> = rows.iter().map(|row| row.features[feature]).collect();
        values.sort_unstable_by(f32::total_cmp);
        let span = Span(values.first().copied().unwrap_or_default(), values.last().copied().unwrap_or_default());
        values.dedup();
        // Between neighbouring values, evenly spaced among them, so that rare large values are told apart as well.
        let step = (values.len() as f64 / (CUTS + 1) as f64).max(1.0);
        let places = (1..=CUTS).map(|place| (place as f64 * step) as usize).filter(|place| *place < values.len());
        let mut cuts: Vec<u16> = places.map(|place| span.nearest(0.5 * (values[place - 1] + values[place]))).collect();
        cuts.dedup();
        let bin = |row: &Row<'_>| cuts.partition_point(|cut| span.at(*cut) < row.features[feature]) as u8;
        Column { span, bins: rows.iter().map(bin).collect(), cuts }
    }
}

/// Trees that are being fitted.
struct Boosting<'a> {
    loss: Loss,
    columns: &'a [Column],
    /// The target and the weight of each row.
    targets: Vec<(f64, f64)>,
    scores: Vec<f64>,
    /// The slopes of the loss at the score of each row.
    slopes: Vec<Slopes>,
    leaf_rows: usize,
}

impl Boosting<'_> {
    fn tree(&mut self) -> Vec<Node> {
        for ((slopes, (target, weight)), score) in self.slopes.iter_mut().zip(&self.targets).zip(&self.scores) {
            *slopes = self.loss.slopes(*target, *weight, *score);
        }
        let mut tree = Vec::new();
        self.grow(&mut tree, &mut (0..self.scores.len() as u32).collect::<Vec<_>>(), DEPTH);
        tree
    }

    fn grow(&mut self, tree: &mut Vec<Node>, rows: &mut [u32], depth: usize) {
        let all: Slopes = rows.iter().map(|row| self.slopes[*row as usize]).sum();
        let node = tree.len();
        match (depth > 0).then(|| self.cut(rows, all)).flatten() {
            Some((feature, cut)) => {
                let column = &self.columns[feature];
                let left = divide(rows, |row| usize::from(column.bins[row as usize]) <= cut);
                let cut = column.cuts[cut];
                tree.push(Node::Leaf(0));
                let (low, high) = rows.split_at_mut(left);
                self.grow(tree, low, depth - 1);
                tree[node] = Node::Cut { feature: feature as u8, cut, right: tree.len() as u32 };
                self.grow(tree, high, depth - 1);
            }
            None => {
                let step = (RATE * all.x / (all.y + RIDGE) / UNIT).round() as i16;
                tree.push(Node::Leaf(step));
                for row in rows {
                    self.scores[*row as usize] += UNIT * f64::from(step);
                }
            }
        }
    }

    /// The feature and the number of the cut that gains most; `None` if no cut gains anything and leaves enough rows.
    fn cut(&self, rows: &[u32], all: Slopes) -> Option<(usize, usize)> {
        if rows.len() < 2 * self.leaf_rows {
            return None;
        }
        let best_of = |(feature, column): (usize, &Column)| {
            let mut bins = [Slopes::ZERO; CUTS + 1];
            for row in rows {
                bins[usize::from(column.bins[*row as usize])] += self.slopes[*row as usize];
            }
            let mut left = Slopes::ZERO;
            let mut best = (gain(all), feature, None);
            for (cut, bin) in bins.iter().take(column.cuts.len()).enumerate() {
                left += *bin;
                let right = all - left;
                let gain = gain(left) + gain(right);
                if left.z.min(right.z) >= self.leaf_rows as f64 && gain > best.0 {
                    best = (gain, feature, Some(cut));
                }
            }
            best
        };
        let best: Vec<_> = self.columns.par_iter().enumerate().map(best_of).collect();
        let (_, feature, cut) = best.into_iter().reduce(|best, other| if other.0 > best.0 { other } else { best })?;
        Some((feature, cut?))
    }
}

/// Of a row, or sums over rows: the gradient, the curvature, and the number of rows.
type Slopes = DVec3;

/// What a leaf with these sums gains.
fn gain(sums: Slopes) -> f64 {
    sums.x * sums.x / (sums.y + RIDGE)
}

/// Puts the rows that go to the left first, and returns how many there are.
fn divide(rows: &mut [u32], is_left: impl Fn(u32) -> bool) -> usize {
    let mut left = 0;
    for index in 0..rows.len() {
        if is_left(rows[index]) {
            rows.swap(left, index);
            left += 1;
        }
    }
    left
}
