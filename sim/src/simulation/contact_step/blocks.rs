//! The unknowns of a step: for each tree that something may touch, the coordinates that a contact can push directly. Those
//! behind them, such as the tip of a leaf that is touched near its root, follow from these without iteration. The end
//! stops of joints become rows of the contact solver here, too.

use super::Scene;
use super::candidate::Candidate;
use crate::contact::law::Stop;
use crate::contact::solver::Solver;
use crate::dynamics::{Coordinate, EndStop, Tree};
use crate::simulation::placed::PlacedLink;

/// A stop is solved for when its joint is this close to a limit, rad: at 5 rad/s a joint covers it in a step of 10 ms.
const NEAR_STOP_RAD: f64 = 0.05;

/// The trees that have a block of the solver.
#[derive(Clone, Default)]
pub(super) struct Blocks {
    /// By slot: where its coordinates begin in `places`.
    first: Vec<usize>,
    /// By coordinate of all trees: whether it is an unknown, and its index in the block of its tree.
    places: Vec<Option<usize>>,
    /// By slot: the number of patches and stops, and the block of the solver.
    patches: Vec<usize>,
    blocks: Vec<usize>,
    /// The slots of the trees that have a block, in the order of the blocks.
    order: Vec<usize>,
    /// Coordinates of one tree that are unknowns, and a part of its mass matrix.
    unknowns: Vec<usize>,
    mass: Vec<f64>,
}

impl Blocks {
    /// Gives every tree that something may touch, or that is near an end stop, a block of the solver. The more patches
    /// and stops a tree has, the later its block. Returns whether there are any blocks.
    pub(super) fn choose(&mut self, scene: &Scene, candidates: &[Candidate], solver: &mut Solver) -> bool {
        self.first.clear();
        let mut end = 0;
        for placed in scene.slots() {
            self.first.push(end);
            end += placed.as_ref().map_or(0, |placed| placed.tree.coordinates.len());
        }
        self.places.clear();
        self.places.resize(end, None);
        self.patches.clear();
        self.patches.resize(scene.slots().len(), 0);
        for at in candidates.iter().flat_map(|candidate| candidate.links.iter().flatten()) {
            self.add(scene, *at);
        }
        for (slot, placed) in scene.slots().iter().enumerate() {
            for (_, stopped) in placed.iter().flat_map(|placed| near_stops(&placed.tree)) {
                self.add(scene, PlacedLink { slot, link: stopped.link });
            }
        }
        self.order.clear();
        self.order.extend((0..self.patches.len()).filter(|slot| self.patches[*slot] > 0));
        self.order.sort_by_key(|slot| self.patches[*slot]);
        self.blocks.clear();
        self.blocks.resize(scene.slots().len(), usize::MAX);
        for slot in &self.order {
            let tree = scene.tree(*slot);
            let places = &mut self.places[self.first[*slot]..][..tree.coordinates.len()];
            self.unknowns.clear();
            for (at, place) in places.iter_mut().enumerate().filter(|(_, place)| place.is_some()) {
                *place = Some(self.unknowns.len());
                self.unknowns.push(at);
            }
            tree.mass_of(&self.unknowns, &mut self.mass);
            let (theta, size) = (tree.theta().value(), self.unknowns.len());
            self.blocks[*slot] = solver.add_block(
                self.unknowns.iter().map(|at| tree.coordinates[*at].velocity),
                self.unknowns.iter().map(|at| tree.next()[*at]),
                |row, column| self.mass[row.max(column) * size + row.min(column)] / theta,
            );
        }
        !self.order.is_empty()
    }

    /// Counts a patch or a stop at a link, and makes the coordinates that move the link unknowns.
    fn add(&mut self, scene: &Scene, PlacedLink { slot, link }: PlacedLink) {
        self.patches[slot] += 1;
        for at in scene.tree(slot).path(link) {
            self.places[self.first[slot] + at] = Some(0);
        }
    }

    /// The slots of the trees that have a block, each with its block.
    pub(super) fn trees(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.order.iter().map(|slot| (*slot, self.blocks[*slot]))
    }

    /// The block of a tree.
    pub(super) fn block(&self, slot: usize) -> usize {
        self.blocks[slot]
    }

    /// By coordinate of a tree: whether it is an unknown, and its index in the tree's block.
    pub(super) fn places(&self, slot: usize) -> &[Option<usize>] {
        &self.places[self.first[slot]..]
    }
}

/// The coordinates of a tree that may reach a limit in this step, with their indices.
pub(super) fn near_stops(tree: &Tree) -> impl Iterator<Item = (usize, &Coordinate)> {
    tree.coordinates.iter().enumerate().filter(|(_, own)| {
        own.stop.is_some_and(|EndStop { limits_rad: [lower, upper], .. }| {
            own.position < lower + NEAR_STOP_RAD || own.position > upper - NEAR_STOP_RAD
        })
    })
}

/// The stops at both limits of a coordinate, whose velocity has this index in the solver.
pub(super) fn stop_rows(index: usize, coordinate: &Coordinate, tree: &Tree) -> impl Iterator<Item = Stop> + use<> {
    let angle = coordinate.position - tree.ahead_s() * coordinate.velocity;
    let theta = tree.theta();
    coordinate.stop.into_iter().flat_map(move |stop| {
        let EndStop { limits_rad: [lower, upper], stiffness_nm_per_rad, loss_time_s } = stop;
        let sides = [(1.0, lower - angle), (-1.0, angle - upper)];
        sides.map(|(sign, overlap_rad)| Stop { index, sign, overlap_rad, stiffness_nm_per_rad, loss_time_s, theta })
    })
}
