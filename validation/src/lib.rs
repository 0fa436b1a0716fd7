//! The physics checks: simulation and models against closed-form solutions.
//!
//! A [`Check`] has a number, a name, a sentence and one or more [`Case`]s. A case simulates something and returns
//! [`Comparison`]s: the closed-form value, the value found, the residual, the tolerance and where the tolerance comes
//! from. The closed form is computed from what a scene or an arm file says, never from what the simulation made of it.
//!
//! Every case lists [`Falsification`]s: parameters of the simulated side that are wrong on purpose, with the
//! comparisons that must notice. [`falsify`] runs them all and demands that every comparison of every check fails under
//! at least one, because a comparison that cannot fail shows nothing. [`CHECKS`] is the one list of checks.

mod check;
mod comparison;
mod contact_law;
mod convergence;
mod determinism;
mod falsification;
mod foam;
mod free_arm;
mod friction;
mod hmm;
mod joint_step;
mod joint_torque;
mod joint_trees;
mod leaf_bending;
mod leaf_case;
mod leaf_vibration;
mod pressed_arm;
mod reach_energy;
mod resting_load;
mod sensor;
mod series;
mod skin_forces;
mod skin_layer;
mod standing_bottle;

pub use check::{Case, Check, CheckOutcome, Found, Judged, Simulated, Verdict, run};
pub use comparison::{Comparison, Falsification};
pub use falsification::{Falsified, FalsifiedOutcome, FalsifiedRun, falsify};
pub use underbrush_recording::fault::Fault;

/// All checks, in the order of their numbers.
pub const CHECKS: &[Check] = &[
    leaf_bending::SMALL_LOAD,
    leaf_bending::LARGE_DEFLECTION,
    leaf_vibration::CHECK,
    resting_load::CHECK,
    skin_forces::CHECK,
    joint_torque::CHECK,
    friction::CHECK,
    free_arm::CHECK,
    joint_step::CHECK,
    skin_layer::CHECK,
    foam::CHECK,
    reach_energy::CHECK,
    convergence::CHECK,
    series::CHECK,
    determinism::CHECK,
    sensor::CHECK,
    hmm::CHECK,
    contact_law::CHECK,
    standing_bottle::CHECK,
    joint_trees::CHECK,
];

impl Check {
    /// Its number: its place in [`CHECKS`], from 1 on; 0 for one that is not listed.
    pub fn number(&self) -> u8 {
        CHECKS.iter().position(|own| own.name == self.name).map_or(0, |place| place as u8 + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that each check has a name of its own.
    #[test]
    fn checks_are_listed_once() {
        for (index, check) in CHECKS.iter().enumerate() {
            assert!(CHECKS[..index].iter().all(|other| other.name != check.name));
        }
    }

    /// Tests that every case has a falsification, and that the falsifications of one case can be told apart by what is
    /// wrong.
    #[test]
    fn every_case_can_be_falsified() {
        for check in CHECKS {
            assert!(!check.cases.is_empty(), "{}", check.name);
            for case in check.cases {
                assert!(!case.falsifications.is_empty(), "a case of {}", check.name);
                for (index, falsification) in case.falsifications.iter().enumerate() {
                    let mut others = case.falsifications[..index].iter();
                    assert!(others.all(|other| other.wrong != falsification.wrong), "{falsification:?}");
                }
            }
        }
    }
}
