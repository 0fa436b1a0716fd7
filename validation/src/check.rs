//! Running checks and judging what they find.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use serde::Serialize;
use underbrush_recording::InputError;

use crate::{Check, Comparison, SHORTFALLS};

/// Whether a check simulates what its closed form describes, or has one parameter wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulated {
    /// As the closed form describes it.
    AsDescribed,
    /// With the check's one parameter wrong.
    Falsified,
}

impl Simulated {
    /// The value to simulate with: `described`, or `wrong` when falsified.
    pub fn with<T>(self, described: T, wrong: T) -> T {
        match self {
            Simulated::AsDescribed => described,
            Simulated::Falsified => wrong,
        }
    }
}

/// Why a check came to no comparison.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The files of the arm are bad.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The case could not be set up or measured.
    #[error("{0}")]
    Case(String),
}

/// How a comparison or a check came out, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within the tolerance.
    Pass,
    /// Outside the tolerance, within the bound of a known shortfall.
    KnownShortfall,
    /// Outside.
    Fail,
}

/// What one check found.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The check's number.
    pub number: u8,
    /// The check's name.
    pub name: &'static str,
    /// What it shows.
    pub summary: &'static str,
    /// The worst of its comparisons.
    pub verdict: Verdict,
    /// Why it came to no comparison, where it broke off.
    pub error: Option<String>,
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
    /// Why it is a known shortfall, where it is one.
    pub cause: Option<&'static str>,
}

/// Runs checks on the threads of the current rayon pool and judges them; outcomes come in the order of `checks`.
/// `done` is called after each.
pub fn run(checks: &[&Check], simulated: Simulated, tolerance_scale: f64, done: impl Fn() + Sync) -> Vec<Outcome> {
    checks
        .par_iter()
        .with_max_len(1)
        .map(|check| {
            // A panic of the engine fails its check and leaves the others.
            let found = catch_unwind(AssertUnwindSafe(|| (check.compare)(simulated)))
                .unwrap_or_else(|_| Err(CheckError::Case("broke off inside the physics engine".into())));
            done();
            judge(check, found, tolerance_scale)
        })
        .collect()
}

/// Judges what a check found. A check without any comparison fails.
pub fn judge(check: &Check, found: Result<Vec<Comparison>, CheckError>, tolerance_scale: f64) -> Outcome {
    let (comparisons, error) = match found {
        Ok(comparisons) => (comparisons, None),
        Err(error) => (Vec::new(), Some(error.to_string())),
    };
    let comparisons: Vec<_> = comparisons
        .into_iter()
        .map(|comparison| {
            let known = SHORTFALLS
                .iter()
                .find(|known| known.check == check.name && known.quantity == comparison.quantity);
            let (verdict, cause) = match known {
                _ if comparison.passes(tolerance_scale) => (Verdict::Pass, None),
                Some(known) if comparison.residual < known.bound * tolerance_scale => {
                    (Verdict::KnownShortfall, Some(known.cause))
                }
                _ => (Verdict::Fail, None),
            };
            Judged {
                comparison,
                verdict,
                cause,
            }
        })
        .collect();
    Outcome {
        number: check.number,
        name: check.name,
        summary: check.summary,
        verdict: comparisons
            .iter()
            .map(|judged| judged.verdict)
            .max()
            .unwrap_or(Verdict::Fail),
        error,
        comparisons,
    }
}
