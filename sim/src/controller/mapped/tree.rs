//! A tree of postures.

use super::arm_shapes::distance_rad;

/// A tree of postures, each with the index of the one before it.
#[derive(Default)]
pub(super) struct Tree {
    /// rad.
    pub(super) postures: Vec<Vec<f64>>,
    before: Vec<Option<usize>>,
}

impl Tree {
    /// Adds a posture, and returns its index.
    pub(super) fn add(&mut self, posture_rad: Vec<f64>, before: Option<usize>) -> usize {
        self.postures.push(posture_rad);
        self.before.push(before);
        self.postures.len() - 1
    }

    /// The index of the posture that is nearest to this one.
    pub(super) fn nearest(&self, posture_rad: &[f64]) -> usize {
        let distance = |own: &Vec<f64>| distance_rad(own, posture_rad);
        let nearest = (0..self.postures.len())
            .map(|index| (index, distance(&self.postures[index])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or(0, |(index, _)| index)
    }

    /// The postures from this one back to the root.
    pub(super) fn to_root(&self, mut index: usize) -> Vec<Vec<f64>> {
        let mut path = vec![self.postures[index].clone()];
        while let Some(before) = self.before[index] {
            path.push(self.postures[before].clone());
            index = before;
        }
        path
    }
}
