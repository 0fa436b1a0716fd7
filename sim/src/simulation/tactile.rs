//! What the skin feels in one frame.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use underbrush_recording::TaxelReading;

/// A part of the arm and an object, or the arm and itself, that press on each other. The part is a patch of skin or the bare
/// part of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ContactPair {
    /// The patch; `None` for the bare part of the link.
    pub patch: Option<u16>,
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter; `None` for other links of the arm.
    pub object: Option<u16>,
}

/// The force between one link, skin and bare part together, and one object, or the other links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkForce {
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter; `None` for other links of the arm.
    pub object: Option<u16>,
    /// The patch that takes most of it; `None` if the bare part does.
    pub patch: Option<u16>,
    /// Its magnitude, N.
    pub force_n: f64,
}

/// What the skin feels in one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TactileFrame {
    /// Taxels with a true or a sensed force, sorted by patch, then taxel.
    pub taxels: Vec<TaxelReading>,
    /// Sum of the solver's contact forces on each patch, N, world frame.
    pub contact_force_world: Vec<DVec3>,
    /// The patch of each of the frame's contacts, in their order; `None` for the bare part of a link.
    pub contact_patch: Vec<Option<u16>>,
    /// Force between each pair in contact, N, world frame; sorted by pair.
    pub pairs: Vec<(ContactPair, DVec3)>,
    /// Largest relative difference, over the patches, between the vector sum of the taxel forces and the solver's
    /// force.
    pub force_residual: f64,
    /// Largest difference, over the patches, between the moment of the taxel forces, each acting at its taxel's centre,
    /// and that of the solver's contacts, divided by the sum of the contacts' magnitudes, m.
    pub moment_residual_m: f64,
}

impl TactileFrame {
    /// The largest force between one link and one object; `None` if nothing touches the arm.
    pub fn largest_force(&self) -> Option<LinkForce> {
        // Forces between the same two bodies add up, on the skin and beside it.
        let between_the_same = |own: &ContactPair| {
            let bodies = (own.link, own.object);
            let pairs = self.pairs.iter();
            pairs.filter(move |(pair, _)| (pair.link, pair.object) == bodies)
        };
        let forces = self.pairs.iter().map(|(own, _)| {
            let (mut sum, mut patch, mut largest_part_n) = (DVec3::ZERO, None, 0.0);
            for (pair, force) in between_the_same(own) {
                let part_n = force.length();
                sum += *force;
                if part_n > largest_part_n {
                    (patch, largest_part_n) = (pair.patch, part_n);
                }
            }
            LinkForce { link: own.link, object: own.object, patch, force_n: sum.length() }
        });
        // Of equal forces, the one on the last link and object counts.
        let order = |force: &LinkForce| (force.link, force.object);
        forces.max_by(|a, b| a.force_n.total_cmp(&b.force_n).then_with(|| order(a).cmp(&order(b))))
    }
}

/// The value of a key in a list that is sorted by keys; a new one if there is none. Unlike a map, a list that is
/// cleared keeps its memory for the next frame.
pub(super) fn entry<K: Ord, V: Default>(list: &mut Vec<(K, V)>, key: K) -> &mut V {
    let place = match list.binary_search_by(|(own, _)| own.cmp(&key)) {
        Ok(place) => place,
        Err(place) => {
            list.insert(place, (key, V::default()));
            place
        }
    };
    &mut list[place].1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the force that is compared with the stop force: the force between one link and one object, skin and bare
    /// parts together. Forces of other links or other objects are not added, and the patch named is the one that feels
    /// most of it.
    #[test]
    fn forces_add_up_by_link_and_object() {
        let pair = |patch, link, object| ContactPair { patch, link, object: Some(object) };
        let tactile =
            |pairs: &[(ContactPair, DVec3)]| TactileFrame { pairs: pairs.to_vec(), ..TactileFrame::default() };
        assert_eq!(TactileFrame::default().largest_force(), None);
        let found = tactile(&[
            (pair(Some(0), 3, 5), DVec3::X * 60.0),
            (pair(None, 3, 5), DVec3::X * 50.0),
            (pair(Some(1), 4, 5), DVec3::X * 90.0),
            (pair(None, 3, 6), DVec3::X * 100.0),
        ]);
        let expected = LinkForce { link: 3, object: Some(5), patch: Some(0), force_n: 110.0 };
        assert_eq!(found.largest_force(), Some(expected));
        let bare = tactile(&[(pair(Some(0), 3, 5), DVec3::X * 3.0), (pair(None, 3, 5), DVec3::Y * 4.0)]);
        let expected = LinkForce { patch: None, force_n: 5.0, ..expected };
        assert_eq!(bare.largest_force(), Some(expected));
    }
}
