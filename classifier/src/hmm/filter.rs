//! Forward and Viterbi filters that advance four streams at a time.

mod forward;
mod viterbi;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::forward::{Forward, ForwardTables};
use self::viterbi::{Viterbi, ViterbiTables};
use super::model::GaussianHmm;
use super::tile::{Tile, WIDTH};

/// How a sequence is scored under a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScoreKind {
    /// ln P(O|λ), summed over all state paths (paper, eq. 2).
    Forward,
    /// ln of the joint probability of the observations and the best state path. The authors' published code uses this
    /// score, and their thresholds of 80 and 15 nats apply to it.
    Viterbi,
}

/// Number of streams that a filter follows.
pub(super) const STREAMS: usize = WIDTH;

/// Transition and initial probabilities in the layouts that the two filters read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FilterTables {
    forward: ForwardTables,
    viterbi: ViterbiTables,
}

impl FilterTables {
    pub(super) fn new(model: &GaussianHmm) -> Self {
        FilterTables {
            forward: ForwardTables::new(model.parameters()),
            viterbi: ViterbiTables::new(model.parameters()),
        }
    }
}

/// The weights of a model's states for four streams.
#[derive(Clone, Debug)]
pub(super) enum Weights {
    Forward(Forward),
    Viterbi([Viterbi; STREAMS]),
}

impl Weights {
    pub(super) fn new(kind: ScoreKind, states: usize) -> Self {
        match kind {
            ScoreKind::Forward => Weights::Forward(Forward::new(states)),
            ScoreKind::Viterbi => Weights::Viterbi(std::array::from_fn(|_| Viterbi::new(states))),
        }
    }

    /// Takes one sample of each stream (D tiles). Streams whose entry in `fresh` is above 0 start with this sample.
    ///
    /// Streams that are not `used` still need a sample, and have no valid score until they start again.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        model: &GaussianHmm,
        tables: &FilterTables,
        sample: &[Tile],
        fresh: Tile,
        used: [bool; STREAMS],
    ) {
        let gaussians = &model.gaussians;
        match self {
            Weights::Forward(weights) => weights.step(&tables.forward, gaussians, sample, fresh),
            Weights::Viterbi(streams) => {
                for (stream, weights) in streams.iter_mut().enumerate().filter(|(stream, _)| used[*stream]) {
                    let sample = |feature: usize| sample[feature][stream];
                    weights.step(&tables.viterbi, gaussians, sample, fresh[stream] > 0.0);
                }
            }
        }
    }

    /// The scores of the streams in nats; −inf where the model rules a stream out.
    #[inline(always)]
    pub(super) fn scores(&self) -> Tile {
        match self {
            Weights::Forward(weights) => weights.log_sum(),
            Weights::Viterbi(streams) => std::array::from_fn(|stream| streams[stream].log_best()),
        }
    }
}
