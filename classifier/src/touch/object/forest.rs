//! Extremely randomized trees (Geurts, Ernst, Wehenkel 2006).
//!
//! Every tree is fitted to all rows. At each node some features are drawn, and for each a cut, uniform between its smallest
//! and largest value there; the cut with the largest decrease of Gini's impurity divides the node. The probabilities of the
//! classes are the means of their shares in the leaves.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number of trees. Choice: with more, probabilities change little.
const TREES: usize = 100;
/// Leaves have at least this many rows, and are at most this deep. Choices: a model file of four families then has some
/// megabytes.
const LEAF_ROWS: usize = 12;
const DEPTH: usize = 8;
/// Stands for no feature: the node is a leaf.
const LEAF: u8 = u8::MAX;
/// Cuts are rounded to this, which is far below the error of any feature, so that files are short.
const CUT: f32 = 1e-3;
/// Shares are in parts of this.
const WHOLE: f64 = 255.0;

/// A row to fit to.
#[derive(Clone, Copy, Debug)]
pub(super) struct ForestRow<'a> {
    pub(super) features: &'a [f32],
    pub(super) class: usize,
    pub(super) weight: f64,
}

/// One tree, its nodes in depth-first order: the left child of a node comes right after it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tree {
    /// The feature that is compared with the cut; 255 for a leaf.
    feature: Vec<u8>,
    /// Rows with at most this go to the left; 0 for a leaf.
    cut: Vec<f32>,
    /// The right child; for a leaf, the number of its shares.
    right: Vec<u16>,
    /// Shares of the classes in each leaf in turn, in parts of 255.
    shares: Vec<u8>,
}

/// Trees that together give probabilities of classes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Forest {
    trees: Vec<Tree>,
}

impl Forest {
    /// Fits trees that tell this many classes apart. The result is the same for any number of threads.
    pub(super) fn fit(rows: &[ForestRow<'_>], classes: usize, seed: u64) -> Self {
        // Column by column, because a node looks at one feature of its rows at a time.
        let count = rows.first().map_or(0, |row| row.features.len());
        let columns: Vec<Vec<f32>> =
            (0..count).map(|column| rows.iter().map(|row| row.features[column]).collect()).collect();
        let tree = |index: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(index as u64);
            let mut growing = Growing { rows, columns: &columns, classes, random, tree: Tree::default() };
            growing.grow(&mut (0..rows.len()).collect::<Vec<_>>(), 0);
            growing.tree
        };
        Forest { trees: (0..TREES).into_par_iter().map(tree).collect() }
    }

    /// Writes the probabilities of the classes.
    pub(super) fn probabilities(&self, features: &[f32], classes: &mut [f64]) {
        classes.fill(0.0);
        let each = 1.0 / (WHOLE * self.trees.len() as f64);
        for tree in &self.trees {
            let leaf = tree.leaf_of(features) * classes.len();
            for (class, share) in classes.iter_mut().zip(&tree.shares[leaf..]) {
                *class += f64::from(*share) * each;
            }
        }
    }

    /// Whether rows of this many features can be judged, and this many classes told apart.
    pub(super) fn is_sound(&self, features: usize, classes: usize) -> bool {
        !self.trees.is_empty() && self.trees.iter().all(|tree| tree.is_sound(features, classes))
    }
}

impl Tree {
    fn leaf_of(&self, features: &[f32]) -> usize {
        let mut node = 0;
        while self.feature[node] != LEAF {
            let is_left = features[usize::from(self.feature[node])] <= self.cut[node];
            node = if is_left { node + 1 } else { usize::from(self.right[node]) };
        }
        usize::from(self.right[node])
    }

    fn is_sound(&self, features: usize, classes: usize) -> bool {
        let (nodes, leaves) = (self.feature.len(), self.shares.len() / classes);
        let node = |index: usize| {
            let right = usize::from(self.right[index]);
            match self.feature[index] {
                LEAF => right < leaves,
                feature => usize::from(feature) < features && index + 1 < nodes && index < right && right < nodes,
            }
        };
        nodes > 0 && self.cut.len() == nodes && self.right.len() == nodes && (0..nodes).all(node)
    }
}

/// A tree that is being fitted.
struct Growing<'a> {
    rows: &'a [ForestRow<'a>],
    columns: &'a [Vec<f32>],
    classes: usize,
    random: ChaCha8Rng,
    tree: Tree,
}

impl Growing<'_> {
    fn grow(&mut self, rows: &mut [usize], depth: usize) {
        let node = self.tree.feature.len();
        self.tree.feature.push(LEAF);
        self.tree.cut.push(0.0);
        self.tree.right.push(0);
        match self.cut(rows).filter(|_| depth < DEPTH) {
            Some((feature, cut)) => {
                let column = &self.columns[feature];
                let left = divide(rows, |row| column[row] <= cut);
                let (low, high) = rows.split_at_mut(left);
                (self.tree.feature[node], self.tree.cut[node]) = (feature as u8, cut);
                self.grow(low, depth + 1);
                self.tree.right[node] = self.tree.feature.len() as u16;
                self.grow(high, depth + 1);
            }
            None => {
                self.tree.right[node] = (self.tree.shares.len() / self.classes) as u16;
                let weights = self.weights(rows);
                let sum: f64 = weights.iter().sum();
                self.tree.shares.extend(weights.iter().map(|weight| (WHOLE * weight / sum).round() as u8));
            }
        }
    }

    /// The best of the cuts that are drawn; `None` if no cut leaves enough rows on both sides.
    fn cut(&mut self, rows: &[usize]) -> Option<(usize, f32)> {
        let all = self.weights(rows);
        if rows.len() < 2 * LEAF_ROWS || all.iter().filter(|weight| **weight > 0.0).count() < 2 {
            return None;
        }
        let count = self.columns.len();
        let mut features: Vec<usize> = (0..count).collect();
        features.shuffle(&mut self.random);
        let mut left_to_try = count.isqrt();
        let mut best: Option<(f64, usize, f32)> = None;
        for feature in features {
            let column = &self.columns[feature];
            let values = rows.iter().map(|row| column[*row]);
            let ends = (f32::INFINITY, f32::NEG_INFINITY);
            let (low, high) = values.fold(ends, |(low, high), value| (low.min(value), high.max(value)));
            if high - low < 2.0 * CUT {
                continue;
            }
            let drawn = low + (high - low) * self.random.random::<f32>();
            let cut = (drawn / CUT).round() * CUT;
            let (mut left, mut left_rows) = (vec![0.0; self.classes], 0);
            for row in rows.iter().filter(|row| column[**row] <= cut) {
                left[self.rows[*row].class] += self.rows[*row].weight;
                left_rows += 1;
            }
            if left_rows.min(rows.len() - left_rows) >= LEAF_ROWS {
                let right: Vec<f64> = all.iter().zip(&left).map(|(all, left)| all - left).collect();
                let purity = purity(&left) + purity(&right);
                if best.is_none_or(|(most, _, _)| purity > most) {
                    best = Some((purity, feature, cut));
                }
            }
            left_to_try -= 1;
            if left_to_try == 0 {
                break;
            }
        }
        best.map(|(_, feature, cut)| (feature, cut))
    }

    /// The weights of the classes in these rows.
    fn weights(&self, rows: &[usize]) -> Vec<f64> {
        let mut weights = vec![0.0; self.classes];
        for &row in rows {
            weights[self.rows[row].class] += self.rows[row].weight;
        }
        weights
    }
}

/// Σ w² / Σ w, which is larger the less mixed the classes are; Gini's impurity times the weight is Σ w minus this.
fn purity(weights: &[f64]) -> f64 {
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight * weight).sum::<f64>() / sum.max(f64::MIN_POSITIVE)
}

/// Puts the rows that go to the left first, and returns how many there are.
fn divide(rows: &mut [usize], is_left: impl Fn(usize) -> bool) -> usize {
    let mut left = 0;
    for index in 0..rows.len() {
        if is_left(rows[index]) {
            rows.swap(left, index);
            left += 1;
        }
    }
    left
}
