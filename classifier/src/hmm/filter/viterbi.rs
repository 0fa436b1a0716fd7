//! The Viterbi filter of one stream: base-2 logarithms of the best path into each state, four states at a time.

use std::f64::consts::LN_2;

use crate::hmm::gaussian::Gaussians;
use crate::hmm::model::HmmParameters;
use crate::hmm::tile::{Tile, WIDTH, add, larger, largest, map, tiled, tiles_for, zip};
use underbrush_recording::math;

/// Initial and transition probabilities as the Viterbi filter reads them, as base-2 logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ViterbiTables {
    tiles: usize,
    left_to_right: bool,
    initial: Vec<Tile>,
    /// Transitions, grouped by target tile and then by source tile, four rows each. In a left-to-right model, a target
    /// tile has rows only for the source tiles up to itself.
    transition: Vec<[Tile; WIDTH]>,
}

impl ViterbiTables {
    pub(super) fn new(HmmParameters { initial, transition, .. }: &HmmParameters) -> Self {
        let (states, tiles) = (initial.len(), tiles_for(initial.len()));
        let log2 = |from: usize, to: usize| match from.max(to) < states {
            true => math::log2(transition[from][to]),
            false => f64::NEG_INFINITY,
        };
        let left_to_right = (0..states).all(|from| (0..from).all(|to| log2(from, to) == f64::NEG_INFINITY));
        let row = |from: usize, tile: usize| -> Tile { std::array::from_fn(|lane| log2(from, tile * WIDTH + lane)) };
        let rows = |tile: usize| 0..if left_to_right { tile + 1 } else { tiles };
        let pairs = (0..tiles).flat_map(|tile| rows(tile).map(move |from| (from, tile)));
        ViterbiTables {
            tiles,
            left_to_right,
            initial: tiled(1, states, f64::NEG_INFINITY, |_, state| math::log2(initial[state])),
            transition: pairs.map(|(from, tile)| std::array::from_fn(|lane| row(from * WIDTH + lane, tile))).collect(),
        }
    }

    /// The transitions into one of `tiles` tiles.
    #[inline(always)]
    fn rows_into(&self, tile: usize, tiles: usize) -> &[[Tile; WIDTH]] {
        if self.left_to_right {
            &self.transition[tile * (tile + 1) / 2..][..tile + 1]
        } else {
            &self.transition[tile * tiles..][..tiles]
        }
    }
}

/// Log2-probabilities of the best path into each state.
#[derive(Clone, Debug)]
pub(super) struct Viterbi {
    log2: Vec<Tile>,
    /// Log2-probabilities of the best path into each state, without the density of the current sample.
    into: Vec<Tile>,
}

impl Viterbi {
    pub(super) fn new(states: usize) -> Self {
        let nothing = vec![[f64::NEG_INFINITY; WIDTH]; tiles_for(states)];
        Viterbi { log2: nothing.clone(), into: nothing }
    }

    /// Takes one sample, given feature by feature.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        tables: &ViterbiTables,
        gaussians: &Gaussians,
        sample: impl Fn(usize) -> f64 + Copy,
        fresh: bool,
    ) {
        match tables.tiles {
            _ if fresh => self.into.copy_from_slice(&tables.initial),
            // Constant lengths let the compiler unroll the loops for the paper's ten and twenty states.
            3 => self.advance(3, tables),
            5 => self.advance(5, tables),
            tiles => self.advance(tiles, tables),
        }
        for (tile, (log2, into)) in self.log2.iter_mut().zip(&self.into).enumerate() {
            // The comparison turns NaN, from infinities of opposite sign, into −inf.
            *log2 = map(add(*into, gaussians.log2_of_states(tile, sample)), |log2| larger(log2, f64::NEG_INFINITY));
        }
    }

    /// Extends the best paths by one transition, without the density of the current sample.
    #[inline(always)]
    fn advance(&mut self, tiles: usize, tables: &ViterbiTables) {
        let (log2, into) = (&self.log2[..tiles], &mut self.into[..tiles]);
        for (tile, into) in into.iter_mut().enumerate() {
            // A maximum does not depend on the order, so four partial maxima are kept side by side.
            let mut best = [[f64::NEG_INFINITY; WIDTH]; WIDTH];
            for (rows, log2) in tables.rows_into(tile, tiles).iter().zip(log2) {
                for k in 0..WIDTH {
                    best[k] = zip(rows[k], best[k], |entry, best| larger(entry + log2[k], best));
                }
            }
            *into = zip(zip(best[0], best[1], larger), zip(best[2], best[3], larger), larger);
        }
    }

    /// The natural logarithm of the probability of the best path.
    #[inline(always)]
    pub(super) fn log_best(&self) -> f64 {
        let start = [f64::NEG_INFINITY; WIDTH];
        largest(self.log2.iter().fold(start, |best, own| zip(*own, best, larger))) * LN_2
    }
}
