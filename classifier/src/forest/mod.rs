//! Extremely randomized trees (Geurts, Ernst, Wehenkel 2006) that tell one class, the *family*, from all else: a family of
//! unknown objects from known ones, or one category from the others.
//!
//! Every tree is fitted to all rows. At each node some features are drawn, and for each a cut, uniform between its smallest
//! and largest value there; the cut with the largest decrease of Gini's impurity divides the node. The probability of the
//! family is the mean of its shares in the leaves.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use packed::{Node, Packed, Span};

mod packed;
#[cfg(test)]
mod tests;

/// Number of trees. Choice: in a prototype, 150 found no more than 60 on development seeds.
const TREES: usize = 100;
/// Leaves have at least this many rows, and are at most this deep. Choices, on development seeds: larger leaves find a
/// quarter less, smaller ones no more.
const LEAF_ROWS: usize = 4;
const DEPTH: usize = 14;
/// Shares in leaves are whole parts of this.
const WHOLE: f64 = 255.0;

/// A row to fit to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ForestRow<'a> {
    pub(crate) features: &'a [f32],
    pub(crate) is_family: bool,
    pub(crate) weight: f64,
}

/// Trees that together give the probability of a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Packed", into = "Packed")]
pub(crate) struct Forest {
    /// One for each feature.
    spans: Vec<Span>,
    trees: Vec<Vec<Node>>,
}

impl Forest {
    /// Fits trees to rows with this many features. Leaves weigh at least `leaf_weight`. The result is the same for any number
    /// of threads.
    pub(crate) fn fit(rows: &[ForestRow<'_>], features: usize, leaf_weight: f64, seed: u64) -> Self {
        // Column by column, because a node looks at one feature of its rows at a time.
        let columns: Vec<Vec<f32>> =
            (0..features).map(|column| rows.iter().map(|row| row.features[column]).collect()).collect();
        let all: Vec<usize> = (0..rows.len()).collect();
        let spans: Vec<Span> = columns.iter().map(|column| span(column, &all)).collect();
        let tree = |index: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(index as u64);
            let mut growing = Growing { rows, columns: &columns, spans: &spans, leaf_weight, random, tree: Vec::new() };
            growing.grow(&mut all.clone(), 0);
            growing.tree
        };
        Forest { trees: (0..TREES).into_par_iter().map(tree).collect(), spans }
    }

    /// The number of features.
    pub(crate) fn features(&self) -> usize {
        self.spans.len()
    }

    /// The probability of the family.
    pub(crate) fn probability(&self, features: &[f32]) -> f64 {
        let shares: f64 = self.trees.iter().map(|tree| f64::from(self.share(tree, features))).sum();
        shares / (WHOLE * self.trees.len() as f64)
    }

    fn share(&self, tree: &[Node], features: &[f32]) -> u8 {
        let mut node = 0;
        loop {
            match tree[node] {
                Node::Leaf(share) => return share,
                Node::Cut { feature, cut, right } => {
                    let feature = usize::from(feature);
                    let is_left = features[feature] <= self.spans[feature].at(cut);
                    node = if is_left { node + 1 } else { right as usize };
                }
            }
        }
    }
}

impl From<Forest> for Packed {
    fn from(forest: Forest) -> Self {
        Packed::of(forest.spans, &forest.trees)
    }
}

impl TryFrom<Packed> for Forest {
    type Error = &'static str;

    fn try_from(packed: Packed) -> Result<Self, Self::Error> {
        Ok(Forest { trees: packed.trees()?, spans: packed.spans })
    }
}

/// A tree that is being fitted.
struct Growing<'a> {
    rows: &'a [ForestRow<'a>],
    columns: &'a [Vec<f32>],
    spans: &'a [Span],
    leaf_weight: f64,
    random: ChaCha8Rng,
    tree: Vec<Node>,
}

impl Growing<'_> {
    fn grow(&mut self, rows: &mut [usize], depth: usize) {
        let node = self.tree.len();
        let weights = self.weights(rows);
        let share = weights[1] / (weights[0] + weights[1]);
        self.tree.push(Node::Leaf((WHOLE * share).round() as u8));
        if let Some((feature, cut)) = self.cut(rows, weights).filter(|_| depth < DEPTH) {
            let (column, at) = (&self.columns[feature], self.spans[feature].at(cut));
            let left = divide(rows, |row| column[row] <= at);
            let (low, high) = rows.split_at_mut(left);
            self.grow(low, depth + 1);
            self.tree[node] = Node::Cut { feature: feature as u8, cut, right: self.tree.len() as u32 };
            self.grow(high, depth + 1);
        }
    }

    /// The best of the cuts that are drawn; `None` if no cut leaves enough rows on both sides.
    fn cut(&mut self, rows: &[usize], all: [f64; 2]) -> Option<(usize, u16)> {
        if rows.len() < 2 * LEAF_ROWS || all.contains(&0.0) {
            return None;
        }
        let count = self.columns.len();
        let mut features: Vec<usize> = (0..count).collect();
        features.shuffle(&mut self.random);
        let mut left_to_try = count.isqrt();
        let mut best: Option<(f64, usize, u16)> = None;
        for feature in features {
            let (column, Span(low, high)) = (&self.columns[feature], span(&self.columns[feature], rows));
            if low >= high {
                continue;
            }
            let drawn = low + (high - low) * self.random.random::<f32>();
            let cut = self.spans[feature].nearest(drawn);
            let at = self.spans[feature].at(cut);
            let (mut left, mut left_rows) = ([0.0; 2], 0);
            for row in rows.iter().filter(|row| column[**row] <= at) {
                left[usize::from(self.rows[*row].is_family)] += self.rows[*row].weight;
                left_rows += 1;
            }
            let right = [all[0] - left[0], all[1] - left[1]];
            let lighter = (left[0] + left[1]).min(right[0] + right[1]);
            if left_rows.min(rows.len() - left_rows) >= LEAF_ROWS && lighter >= self.leaf_weight {
                let purity = purity(left) + purity(right);
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

    /// The weights of all else and of the family in these rows.
    fn weights(&self, rows: &[usize]) -> [f64; 2] {
        let mut weights = [0.0; 2];
        rows.iter().for_each(|row| weights[usize::from(self.rows[*row].is_family)] += self.rows[*row].weight);
        weights
    }
}

/// The range of a feature in some rows.
fn span(column: &[f32], rows: &[usize]) -> Span {
    let ends = Span(f32::INFINITY, f32::NEG_INFINITY);
    rows.iter().fold(ends, |Span(low, high), row| Span(low.min(column[*row]), high.max(column[*row])))
}

/// Σ w² / Σ w, which is larger the less mixed the classes are; Gini's impurity times the weight is Σ w minus this.
fn purity(weights: [f64; 2]) -> f64 {
    let [one, other] = weights;
    (one * one + other * other) / (one + other).max(f64::MIN_POSITIVE)
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
