//! Runs checks and judges what they find.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use serde::Serialize;

use crate::{Comparison, Falsification, Fault};

/// One check.
#[derive(Debug)]
pub struct Check {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub summary: &'static str,
    /// What it simulates.
    pub cases: &'static [Case],
}

/// One thing that a check simulates.
#[derive(Debug)]
pub struct Case {
    /// Simulates it and compares it with its closed form.
    pub compare: fn(Simulated) -> Found,
    /// Wrong parameters that its comparisons must notice.
    pub falsifications: &'static [Falsification],
}

/// What a case simulates: what its closed form describes, or the same with this parameter wrong on purpose.
#[derive(Clone, Copy, Debug)]
pub struct Simulated(pub(crate) Option<Falsification>);

impl Simulated {
    /// The value to simulate with: `wrong` when falsified by `falsification`, otherwise `described`.
    pub fn with<T>(self, falsification: Falsification, described: T, wrong: T) -> T {
        if self.is(falsification) { wrong } else { described }
    }

    /// Whether it is falsified by `falsification`.
    pub fn is(self, falsification: Falsification) -> bool {
        self.0.is_some_and(|active| active.wrong == falsification.wrong)
    }
}

/// The verdict on a comparison or a check, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within the tolerance.
    Pass,
    /// Outside the tolerance.
    Fail,
}

/// What one check found.
#[derive(Clone, Debug, Serialize)]
pub struct CheckOutcome {
    /// The check's number.
    pub number: u8,
    /// The check's name.
    pub name: &'static str,
    /// What it shows.
    pub summary: &'static str,
    /// The worst verdict of its comparisons; a failure if a case ended with an error.
    pub verdict: Verdict,
    /// The errors of cases that produced no comparisons.
    pub errors: Vec<String>,
    /// Its comparisons, each with its verdict.
    pub comparisons: Vec<Judged>,
}

/// One comparison with its verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Judged {
    /// The comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// Its verdict at the tolerance scale of the run.
    pub verdict: Verdict,
}

impl Judged {
    /// Judges a comparison.
    pub(crate) fn new(comparison: Comparison, tolerance_scale: f64) -> Self {
        let verdict = if comparison.passes(tolerance_scale) { Verdict::Pass } else { Verdict::Fail };
        Judged { comparison, verdict }
    }
}

/// The comparisons of a case, or the error that ended it.
pub type Found = Result<Vec<Comparison>, Fault>;

/// What each of these cases finds, in their order, on all cores; `done` is called after each. A panic inside the physics
/// engine becomes an error of its case, and the other cases still run.
pub(crate) fn run_all(jobs: &[(&Case, Simulated)], done: impl Fn() + Sync) -> Vec<Found> {
    let one = |(case, simulated): &(&Case, Simulated)| {
        let found = catch_unwind(AssertUnwindSafe(|| (case.compare)(*simulated)));
        done();
        found.unwrap_or_else(|_| Err(Fault::Run("broke off inside the physics engine".into())))
    };
    jobs.par_iter().with_max_len(1).map(one).collect()
}

/// Runs checks on the threads of the current rayon pool and judges them. The outcomes are in the order of `checks`.
/// `done` is called after each case.
pub fn run(checks: &[&Check], tolerance_scale: f64, done: impl Fn() + Sync) -> Vec<CheckOutcome> {
    let cases = checks.iter().flat_map(|check| check.cases);
    let jobs: Vec<(&Case, Simulated)> = cases.map(|case| (case, Simulated(None))).collect();
    let mut found = run_all(&jobs, done).into_iter();
    let judged = |check: &&Check| judge(check, found.by_ref().take(check.cases.len()).collect(), tolerance_scale);
    checks.iter().map(judged).collect()
}

/// Judges what the cases of a check found. A check without any comparison fails, and so does one with a case that ended
/// with an error.
fn judge(check: &Check, found: Vec<Found>, tolerance_scale: f64) -> CheckOutcome {
    let (mut comparisons, mut errors) = (Vec::new(), Vec::new());
    let judged = |comparison: Comparison| Judged::new(comparison, tolerance_scale);
    for case in found {
        match case {
            Ok(found) => comparisons.extend(found.into_iter().map(judged)),
            Err(error) => errors.push(error.to_string()),
        }
    }
    let worst = comparisons.iter().map(|judged| judged.verdict).max();
    CheckOutcome {
        number: check.number(),
        name: check.name,
        summary: check.summary,
        verdict: worst.filter(|_| errors.is_empty()).unwrap_or(Verdict::Fail),
        errors,
        comparisons,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CHECKS;

    /// Tests that a check fails when it compares nothing, and when one of its cases ends with an error although the
    /// others pass.
    #[test]
    fn a_check_without_comparisons_fails() {
        let check = &CHECKS[0];
        assert_eq!(judge(check, vec![Ok(Vec::new())], 1.0).verdict, Verdict::Fail);
        let good = || Ok(vec![Comparison::of("x", "m", 1.0, 1.0).absolute(0.1, "none")]);
        assert_eq!(judge(check, vec![good()], 1.0).verdict, Verdict::Pass);
        let broken = judge(check, vec![good(), Err(Fault::Run("no leaf".into()))], 1.0);
        assert_eq!((broken.verdict, broken.errors), (Verdict::Fail, vec!["no leaf".to_owned()]));
    }
}
