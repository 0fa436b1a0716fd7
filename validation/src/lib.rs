//! The physics checks: simulation and models against closed-form solutions.
//!
//! A [`Check`] has a number, a name and a sentence; run, it returns [`Comparison`]s: the closed-form value, the one
//! found, the residual, the tolerance and where the tolerance comes from. It can also be run *falsified*, with one
//! parameter of the simulated side wrong by a stated amount, and must then fail: a check that cannot fail shows
//! nothing. [`CHECKS`] is the one list of checks, [`SHORTFALLS`] the one list of tolerances that are not met.

mod check;
mod comparison;
mod convergence;
mod determinism;
mod driven;
mod foam;
mod free_arm;
mod friction;
mod hmm;
mod joint_step;
mod joint_torque;
mod leaf_bending;
mod leaf_case;
mod leaf_vibration;
mod portrait;
mod pressed_arm;
mod reach_energy;
mod resting_load;
mod sensor;
mod series;
mod shortfall;
mod skin_forces;
mod skin_layer;

pub use check::{CheckError, Judged, Outcome, Simulated, Verdict, judge, run};
pub use comparison::Comparison;
pub use portrait::{Portrait, portraits, roll_loop};
pub use shortfall::{SHORTFALLS, Shortfall};

/// One check.
#[derive(Debug)]
pub struct Check {
    /// Its number; checks are listed by it.
    pub number: u8,
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub summary: &'static str,
    /// What is wrong, and by how much, when it is falsified.
    pub falsification: &'static str,
    /// Runs it.
    pub compare: fn(Simulated) -> Result<Vec<Comparison>, CheckError>,
}

/// All checks, by number.
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
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins that checks are listed by number, each with a name of its own, and that shortfalls are those of checks.
    #[test]
    fn checks_are_listed_once_by_number() {
        assert!(CHECKS.windows(2).all(|pair| pair[0].number < pair[1].number));
        for (index, check) in CHECKS.iter().enumerate() {
            assert!(CHECKS[..index].iter().all(|other| other.name != check.name));
        }
        for known in SHORTFALLS {
            assert!(CHECKS.iter().any(|check| check.name == known.check), "{}", known.check);
        }
    }

    /// Pins that a check which breaks off, or compares nothing, fails.
    #[test]
    fn a_check_without_comparisons_fails() {
        let check = &CHECKS[0];
        assert_eq!(judge(check, Ok(Vec::new()), 1.0).verdict, Verdict::Fail);
        let broken = judge(check, Err(CheckError::Case("no leaf".into())), 1.0);
        assert_eq!(
            (broken.verdict, broken.error.as_deref()),
            (Verdict::Fail, Some("no leaf"))
        );
    }
}
