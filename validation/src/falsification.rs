//! Checks with one parameter of the simulated side wrong on purpose: every comparison must fail under one of them.

use serde::Serialize;

use crate::check::run_all;
use crate::{Case, Check, Falsification, Found, Judged, Simulated, Verdict};

/// The results of the falsifications of one check.
#[derive(Clone, Debug, Serialize)]
pub struct FalsifiedOutcome {
    /// The check's number.
    pub number: u8,
    /// The check's name.
    pub name: &'static str,
    /// What it shows.
    pub summary: &'static str,
    /// Whether every comparison is broken by a falsification, and every falsification breaks the comparisons that it
    /// must.
    pub sound: bool,
    /// The faults found; empty if the check is sound.
    pub faults: Vec<String>,
    /// The falsifications, case by case.
    pub falsifications: Vec<Falsification>,
    /// The comparisons, case by case.
    pub comparisons: Vec<Falsified>,
}

/// One comparison under the falsifications of its case.
#[derive(Clone, Debug, Serialize)]
pub struct Falsified {
    /// What is compared.
    pub quantity: String,
    /// Whether it fails under at least one.
    pub broken: bool,
    /// Its results, one for each falsification.
    pub runs: Vec<FalsifiedRun>,
}

/// One comparison under one falsification.
#[derive(Clone, Debug, Serialize)]
pub struct FalsifiedRun {
    /// Index in the check's falsifications.
    pub falsification: usize,
    /// Whether this falsification must break the comparison.
    pub must_break: bool,
    /// The comparison under this falsification, with its verdict.
    #[serde(flatten)]
    pub judged: Judged,
}

/// Runs every case of the checks under each of its falsifications on the threads of the current rayon pool. The
/// outcomes are in the order of `checks`. `done` is called after each case and falsification.
pub fn falsify(checks: &[&Check], tolerance_scale: f64, done: impl Fn() + Sync) -> Vec<FalsifiedOutcome> {
    let falsified = |case: &'static Case| case.falsifications.iter().map(move |wrong| (case, Simulated(Some(*wrong))));
    let jobs: Vec<(&Case, Simulated)> = checks.iter().flat_map(|check| check.cases).flat_map(falsified).collect();
    let mut found = run_all(&jobs, done).into_iter();
    let judged = |check: &&Check| {
        let cases = check.cases.iter();
        let own = cases.map(|case| found.by_ref().take(case.falsifications.len()).collect());
        judge_falsified(check, own.collect(), tolerance_scale)
    };
    checks.iter().map(judged).collect()
}

/// Judges what the cases of a check found. `found` has the results of each case under its falsifications, in their
/// order.
fn judge_falsified(check: &Check, found: Vec<Vec<Found>>, tolerance_scale: f64) -> FalsifiedOutcome {
    let mut falsifications = Vec::new();
    let mut comparisons = Vec::new();
    let mut faults = Vec::new();
    for (case, runs) in check.cases.iter().zip(found) {
        let mut own: Vec<Falsified> = Vec::new();
        for (falsification, found) in case.falsifications.iter().zip(runs) {
            let index = falsifications.len();
            falsifications.push(*falsification);
            let wrong = format!("{}, {}", falsification.wrong, falsification.by);
            let found = match found {
                Ok(found) => found,
                // A case that ends with an error says nothing about its comparisons.
                Err(error) => {
                    faults.push(format!("with {wrong}: {error}"));
                    continue;
                }
            };
            let unknown = falsification.unknown_names(&found);
            faults.extend(unknown.map(|name| format!("with {wrong}: no comparison is named {name:?}")));
            for comparison in found {
                let quantity = comparison.quantity.clone();
                let must_break = falsification.must_break(&quantity);
                let judged = Judged::new(comparison, tolerance_scale);
                if must_break && judged.verdict != Verdict::Fail {
                    faults.push(format!("with {wrong}: {quantity} does not fail"));
                }
                let run = FalsifiedRun { falsification: index, must_break, judged };
                match own.iter_mut().find(|known| known.quantity == quantity) {
                    Some(known) => known.runs.push(run),
                    None => own.push(Falsified { quantity, broken: false, runs: vec![run] }),
                }
            }
        }
        for comparison in &mut own {
            comparison.broken = comparison.runs.iter().any(|run| run.judged.verdict == Verdict::Fail);
            if !comparison.broken {
                faults.push(format!("{} holds under every falsification", comparison.quantity));
            }
        }
        if own.is_empty() {
            faults.push("a case without comparisons".into());
        }
        comparisons.extend(own);
    }
    FalsifiedOutcome {
        number: check.number(),
        name: check.name,
        summary: check.summary,
        sound: faults.is_empty(),
        faults,
        falsifications,
        comparisons,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Comparison, Fault};

    const LONG: Falsification = Falsification::new("length", "1 % too long").breaking(&["length"]);
    const HEAVY: Falsification = Falsification::new("mass", "1 % too high");

    /// A length and a mass. A wrong value of each is noticed by one comparison only.
    fn compare(simulated: Simulated) -> Found {
        let same = |name: &str, found| Comparison::of(name, "", 1.0, found).relative(1e-3, "none");
        Ok(vec![same("length", simulated.with(LONG, 1.0, 1.01)), same("mass", simulated.with(HEAVY, 1.0, 1.01))])
    }

    const fn check(cases: &'static [Case]) -> Check {
        Check { name: "example", summary: "", cases }
    }

    /// Tests that a comparison that no falsification breaks is a fault, even if another comparison of its case is
    /// broken.
    #[test]
    fn each_comparison_must_be_broken() {
        const ALONE: Check = check(&[Case { compare, falsifications: &[LONG] }]);
        let outcome = &falsify(&[&ALONE], 1.0, || ())[0];
        let broken: Vec<bool> = outcome.comparisons.iter().map(|found| found.broken).collect();
        assert_eq!((outcome.sound, broken), (false, vec![true, false]));
        assert_eq!(outcome.faults, ["mass holds under every falsification"]);
    }

    /// Tests that a falsification must break every comparison that it names, and not only some.
    #[test]
    fn a_falsification_must_break_what_it_names() {
        const BOTH: Check = check(&[Case { compare, falsifications: &[LONG, HEAVY] }]);
        let outcome = &falsify(&[&BOTH], 1.0, || ())[0];
        assert!(outcome.comparisons.iter().all(|found| found.broken));
        assert_eq!(outcome.faults, ["with mass, 1 % too high: length does not fail"]);
    }

    /// Tests that a case that ends with an error, a case without comparisons, and a name that no comparison has are
    /// faults.
    #[test]
    fn what_cannot_be_judged_is_a_fault() {
        const ALONE: Check = check(&[Case { compare, falsifications: &[LONG] }]);
        let faults = |found: Found| judge_falsified(&ALONE, vec![vec![found]], 1.0).faults;
        let broken_off = faults(Err(Fault::Run("no leaf".into())));
        assert_eq!(broken_off, ["with length, 1 % too long: no leaf", "a case without comparisons"]);
        let other = Comparison::of("mass", "kg", 0.0, 1.0).absolute(0.1, "none");
        assert_eq!(faults(Ok(vec![other])), ["with length, 1 % too long: no comparison is named \"length\""]);
    }
}
