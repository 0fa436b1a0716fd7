//! Viterbi's filter: logarithms of the best path into each state.

use super::{CHUNK, FilterModel};
use crate::hmm::tile::{Tile, WIDTH, larger, select, zip};

/// Four streams' logarithms of the best path into each state.
#[derive(Clone, Debug)]
pub(in crate::hmm) struct Viterbi {
    states: usize,
    /// N, padded, each: before and after the sample at hand.
    log: Vec<Tile>,
    next: Vec<Tile>,
}

impl Viterbi {
    pub(super) fn new(model: &FilterModel) -> Self {
        let nothing = vec![[f64::NEG_INFINITY; WIDTH]; model.padded()];
        Viterbi {
            states: model.states,
            log: nothing.clone(),
            next: nothing,
        }
    }

    pub(super) fn state_count(&self) -> usize {
        self.states
    }

    #[inline(always)]
    pub(super) fn step(&mut self, model: &FilterModel, sample: &[Tile], fresh: Tile) {
        let states = model.into.iter().zip(&model.log_initial).zip(&mut self.next);
        for (state, (((from, places), initial), next)) in states.enumerate() {
            let before = self.log[from.clone()].as_chunks::<CHUNK>().0;
            let logs = model.log[places.clone()].as_chunks::<CHUNK>().0;
            let mut best = [[f64::NEG_INFINITY; WIDTH]; CHUNK];
            for (before, log) in before.iter().zip(logs) {
                for k in 0..CHUNK {
                    best[k] = zip(before[k], best[k], |before, best| larger(before + log[k], best));
                }
            }
            // A maximum is the same in any order.
            let best = best
                .iter()
                .fold([f64::NEG_INFINITY; WIDTH], |all, one| zip(*one, all, larger));
            let best = select(fresh, [*initial; WIDTH], best);
            *next = zip(best, model.log_density.of(state, sample), |best, density| {
                let log = best + density;
                if log.is_nan() { f64::NEG_INFINITY } else { log }
            });
        }
        std::mem::swap(&mut self.log, &mut self.next);
    }

    #[inline(always)]
    pub(super) fn log_best(&self) -> Tile {
        let start = [f64::NEG_INFINITY; WIDTH];
        self.log.iter().fold(start, |best, own| zip(*own, best, larger))
    }
}
