//! Initial distribution and transitions of a model before training.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which transitions exist. Transitions that are zero here stay zero in training.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Topology {
    /// Upper triangular with forward skips of any length; the last state absorbs. The authors' choice.
    LeftToRight,
    /// Every state can follow every state, with equal probability.
    Ergodic,
}

impl Topology {
    /// All topologies, with their names as options.
    pub const NAMED: [(&'static str, Topology); 2] =
        [("left-right", Topology::LeftToRight), ("ergodic", Topology::Ergodic)];

    /// The N × N initial transition probabilities.
    ///
    /// For 5 left-to-right states this is the authors' own matrix. For other numbers it generalizes their pattern for
    /// 10 and 20 states. Self-transitions have probability 0.1 in the first 60 % of the states, 0.2 up to 85 %, then
    /// 0.3, 0.4 in the second to last and 1 in the last. The rest is divided among the later states in proportion to
    /// 0.25, 0.20, 0.15, then 0.05 for each farther one (below 15 states), or 0.35, 0.25, then 0.015 for each farther
    /// one (from 15 states).
    ///
    /// Choice: the authors publish ranges for these weights; the values within the ranges and the limit of 15 are ours.
    ///
    /// ```
    /// use underbrush_classifier::hmm::Topology;
    ///
    /// // No state goes back, and the last one stays.
    /// let rows = Topology::LeftToRight.transitions(3);
    /// assert_eq!((rows[1][0], rows[2][2]), (0.0, 1.0));
    /// ```
    pub fn transitions(self, states: usize) -> Vec<Vec<f64>> {
        match self {
            Topology::Ergodic => vec![vec![1.0 / states as f64; states]; states],
            Topology::LeftToRight if states == 5 => LEFT_TO_RIGHT_5.iter().map(|row| row.to_vec()).collect(),
            Topology::LeftToRight => (0..states).map(|state| left_to_right_row(state, states)).collect(),
        }
    }
}

/// The initial distribution before training.
///
/// ```
/// use underbrush_classifier::hmm::InitialDistribution;
///
/// for (name, distribution) in InitialDistribution::NAMED {
///     let sum: f64 = distribution.probabilities(4).iter().sum();
///     assert!((sum - 1.0).abs() < 1e-12, "{name}");
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InitialDistribution {
    /// All states equally likely: the authors' choice, also for left-to-right models.
    Uniform,
    /// Always the first state.
    FirstState,
}

impl InitialDistribution {
    /// All distributions, with their names as options.
    pub const NAMED: [(&'static str, InitialDistribution); 2] =
        [("uniform", InitialDistribution::Uniform), ("first-state", InitialDistribution::FirstState)];

    /// The N initial probabilities.
    pub fn probabilities(self, states: usize) -> Vec<f64> {
        match self {
            InitialDistribution::Uniform => vec![1.0 / states as f64; states],
            InitialDistribution::FirstState => (0..states).map(|state| if state == 0 { 1.0 } else { 0.0 }).collect(),
        }
    }
}

/// The initial transition matrix of the authors' 5-state models.
const LEFT_TO_RIGHT_5: [[f64; 5]; 5] = [
    [0.2, 0.35, 0.2, 0.15, 0.1],
    [0.0, 0.2, 0.45, 0.25, 0.1],
    [0.0, 0.0, 0.2, 0.55, 0.25],
    [0.0, 0.0, 0.0, 0.2, 0.8],
    [0.0, 0.0, 0.0, 0.0, 1.0],
];

fn left_to_right_row(state: usize, states: usize) -> Vec<f64> {
    let (near, far): (&[f64], f64) = if states < 15 { (&[0.25, 0.2, 0.15], 0.05) } else { (&[0.35, 0.25], 0.015) };
    let forward: Vec<f64> = (1..states - state).map(|skip| near.get(skip - 1).copied().unwrap_or(far)).collect();
    let self_loop = self_loop(state, states);
    let share = (1.0 - self_loop) / forward.iter().sum::<f64>();
    let mut row = vec![0.0; state];
    row.push(self_loop);
    row.extend(forward.iter().map(|weight| weight * share));
    row
}

fn self_loop(state: usize, states: usize) -> f64 {
    let number = state + 1;
    if number == states {
        1.0
    } else if 5 * number <= 3 * states {
        0.1
    } else if 20 * number <= 17 * states {
        0.2
    } else if number + 1 == states {
        0.4
    } else {
        0.3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that every initial matrix is stochastic, left-to-right ones upper triangular with an absorbing last state.
    #[test]
    fn rows_sum_to_one_and_nothing_goes_back() {
        for states in 1..=40 {
            for topology in [Topology::LeftToRight, Topology::Ergodic] {
                let rows = topology.transitions(states);
                assert_eq!(rows.len(), states);
                for (i, row) in rows.iter().enumerate() {
                    assert_eq!(row.len(), states);
                    assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{states} states, row {i}: {row:?}");
                    if topology == Topology::LeftToRight {
                        assert!(row[..i].iter().all(|&p| p == 0.0) && row[i..].iter().all(|&p| p > 0.0));
                    }
                }
                assert!(topology == Topology::Ergodic || rows[states - 1][states - 1] == 1.0);
            }
        }
    }

    /// Tests the published figures: the self-transitions of each state; with 10 states, 0.25 to the next state and 0.05
    /// to far ones; with 20 states, 0.25 to 0.4 to the next two states and 0.01 to 0.02 to farther ones.
    #[test]
    fn self_loops_and_skips_follow_the_published_pattern() {
        let diagonal = |states: usize| -> Vec<f64> {
            Topology::LeftToRight.transitions(states).iter().enumerate().map(|(i, row)| row[i]).collect()
        };
        assert_eq!(diagonal(5), [0.2, 0.2, 0.2, 0.2, 1.0]);
        assert_eq!(diagonal(10), [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.2, 0.2, 0.4, 1.0]);
        let twenty = diagonal(20);
        assert_eq!(twenty[..12], [0.1; 12]);
        assert_eq!(twenty[12..], [0.2, 0.2, 0.2, 0.2, 0.2, 0.3, 0.4, 1.0]);
        let first_of_10 = &Topology::LeftToRight.transitions(10)[0];
        for (found, expected) in first_of_10.iter().zip([0.1, 0.25, 0.2, 0.15, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05]) {
            assert!((found - expected).abs() < 1e-12);
        }
        let first_of_20 = &Topology::LeftToRight.transitions(20)[0];
        assert!(first_of_20[1..3].iter().all(|p| (0.25..=0.4).contains(p)));
        assert!(first_of_20[3..].iter().all(|p| (0.01..=0.02).contains(p)));
    }

    /// Tests both initial distributions.
    #[test]
    fn initial_distributions_sum_to_one() {
        assert_eq!(InitialDistribution::Uniform.probabilities(4), [0.25; 4]);
        assert_eq!(InitialDistribution::FirstState.probabilities(3), [1.0, 0.0, 0.0]);
    }
}
