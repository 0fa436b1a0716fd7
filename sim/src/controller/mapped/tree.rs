//! A tree of postures.

/// A tree of postures of an arm, each with the index of the one before it.
pub(super) struct Tree {
    joints: usize,
    /// One posture after the other, rad, because a long search compares all of them with each posture that it draws.
    postures_rad: Vec<f64>,
    before: Vec<Option<usize>>,
}

impl Tree {
    /// A tree without postures, of an arm with this many joints.
    pub(super) fn new(joints: usize) -> Self {
        Tree { joints, postures_rad: Vec::new(), before: Vec::new() }
    }

    /// Adds a posture, and returns its index.
    pub(super) fn add(&mut self, posture_rad: &[f64], before: Option<usize>) -> usize {
        self.postures_rad.extend_from_slice(posture_rad);
        self.before.push(before);
        self.before.len() - 1
    }

    /// A posture, rad.
    pub(super) fn posture(&self, index: usize) -> &[f64] {
        &self.postures_rad[index * self.joints..][..self.joints]
    }

    /// The index of the first of the postures that are nearest to this one.
    pub(super) fn nearest(&self, posture_rad: &[f64]) -> usize {
        let (mut nearest, mut least, mut least_square) = (0, f64::INFINITY, f64::INFINITY);
        for (index, own) in self.postures_rad.chunks_exact(self.joints).enumerate() {
            let square = own.iter().zip(posture_rad).map(|(own, other)| (other - own) * (other - own)).sum::<f64>();
            // Squares that differ may have the same root.
            if square < least_square && square.sqrt() < least {
                (nearest, least, least_square) = (index, square.sqrt(), square);
            }
        }
        nearest
    }

    /// The postures from this one back to the root.
    pub(super) fn to_root(&self, index: usize) -> Vec<Vec<f64>> {
        let indices = std::iter::successors(Some(index), |index| self.before[*index]);
        indices.map(|index| self.posture(index).to_vec()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the first of the nearest postures is found, and that a branch leads back to the root.
    #[test]
    fn the_first_of_the_nearest_is_found() {
        let mut tree = Tree::new(2);
        let root = tree.add(&[0.0, 0.0], None);
        let first = tree.add(&[3.0, 4.0], Some(root));
        let left = tree.add(&[-1.0, 0.1], Some(first));
        assert_eq!(tree.nearest(&[0.0, 0.04]), root);
        assert_eq!(tree.nearest(&[2.0, 5.0]), first);
        assert_eq!(tree.nearest(&[0.0, 2.0]), root);
        assert_eq!(tree.to_root(left), [[-1.0, 0.1], [3.0, 4.0], [0.0, 0.0]]);
        let mut tied = Tree::new(1);
        for angle_rad in [-1.0, 1.0, -1.0] {
            tied.add(&[angle_rad], None);
        }
        assert_eq!(tied.nearest(&[0.0]), 0);
    }
}
