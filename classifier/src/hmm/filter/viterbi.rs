//! Viterbi's filter of one stream: base-2 logarithms of the best path into each state, four states side by side.

use std::f64::consts::LN_2;

use crate::hmm::density::TiledDensity;
use crate::hmm::emission::Emissions;
use crate::hmm::tile::{Tile, WIDTH, add, larger, largest, map, tiled, tiles_for, zip};

/// What Viterbi's filter needs of a model, in base-2 logarithms.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ViterbiModel {
    tiles: usize,
    left_to_right: bool,
    initial: Vec<Tile>,
    /// Transitions, by the tile that they lead into and then the tile that they come from, four rows each. In a
    /// left-to-right model a tile has rows for those up to itself alone.
    transition: Vec<[Tile; WIDTH]>,
    density: TiledDensity,
}

impl ViterbiModel {
    pub(super) fn new(initial: &[f64], transition: &[f64], emissions: &Emissions) -> Self {
        let (states, tiles) = (initial.len(), tiles_for(initial.len()));
        let log2 = |from: usize, to: usize| match from.max(to) < states {
            true => transition[from * states + to].log2(),
            false => f64::NEG_INFINITY,
        };
        let left_to_right = (0..states).all(|from| (0..from).all(|to| log2(from, to) == f64::NEG_INFINITY));
        let row = |from: usize, tile: usize| -> Tile { std::array::from_fn(|lane| log2(from, tile * WIDTH + lane)) };
        let rows = |tile: usize| 0..if left_to_right { tile + 1 } else { tiles };
        let pairs = (0..tiles).flat_map(|tile| rows(tile).map(move |from| (from, tile)));
        ViterbiModel {
            tiles,
            left_to_right,
            initial: tiled(1, states, f64::NEG_INFINITY, |_, state| initial[state].log2()),
            transition: pairs
                .map(|(from, tile)| std::array::from_fn(|lane| row(from * WIDTH + lane, tile)))
                .collect(),
            density: TiledDensity::new(emissions),
        }
    }

    /// The rows into one of so many tiles, of the first states or all.
    #[inline(always)]
    fn rows_into(&self, tile: usize, tiles: usize) -> &[[Tile; WIDTH]] {
        if self.left_to_right {
            &self.transition[tile * (tile + 1) / 2..][..tile + 1]
        } else {
            &self.transition[tile * tiles..][..tiles]
        }
    }
}

/// A stream's logarithms of the best path into each state.
#[derive(Clone, Debug)]
pub(in crate::hmm) struct Viterbi {
    log2: Vec<Tile>,
    /// The same, the sample at hand left out.
    into: Vec<Tile>,
}

impl Viterbi {
    pub(super) fn new(model: &ViterbiModel) -> Self {
        let nothing = vec![[f64::NEG_INFINITY; WIDTH]; model.tiles];
        Viterbi {
            log2: nothing.clone(),
            into: nothing,
        }
    }

    /// Takes in a sample, given feature by feature.
    #[inline(always)]
    pub(super) fn step(&mut self, model: &ViterbiModel, sample: impl Fn(usize) -> f64 + Copy, fresh: bool) {
        match model.tiles {
            _ if fresh => self.into.copy_from_slice(&model.initial),
            // The compiler unrolls loops of a length that it knows: the paper's ten and twenty states.
            3 => self.advance(3, model),
            5 => self.advance(5, model),
            tiles => self.advance(tiles, model),
        }
        for (tile, (log2, into)) in self.log2.iter_mut().zip(&self.into).enumerate() {
            // The comparison turns NaN, opposite infinities, into −inf.
            *log2 = map(add(*into, model.density.log2(tile, sample)), |log2| {
                larger(log2, f64::NEG_INFINITY)
            });
        }
    }

    /// Writes the best paths into the states, the sample at hand left out.
    #[inline(always)]
    fn advance(&mut self, tiles: usize, model: &ViterbiModel) {
        let (log2, into) = (&self.log2[..tiles], &mut self.into[..tiles]);
        for (tile, into) in into.iter_mut().enumerate() {
            // A maximum is the same in any order.
            let mut best = [[f64::NEG_INFINITY; WIDTH]; WIDTH];
            for (rows, log2) in model.rows_into(tile, tiles).iter().zip(log2) {
                for k in 0..WIDTH {
                    best[k] = zip(rows[k], best[k], |entry, best| larger(entry + log2[k], best));
                }
            }
            *into = zip(zip(best[0], best[1], larger), zip(best[2], best[3], larger), larger);
        }
    }

    /// The natural logarithm of the best path.
    #[inline(always)]
    pub(super) fn log_best(&self) -> f64 {
        let start = [f64::NEG_INFINITY; WIDTH];
        largest(self.log2.iter().fold(start, |best, own| zip(*own, best, larger))) * LN_2
    }
}
