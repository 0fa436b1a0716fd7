//! `underbrush validate`: runs the physics checks and prints their residuals.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;
use underbrush_validation::{CHECKS, Check, FalsifiedOutcome, Outcome, Verdict, falsify};

use crate::options::number;
use crate::{Failure, output, progress};

mod text;

/// Options of `underbrush validate`.
#[derive(Args)]
pub struct ValidateOptions {
    /// Run only this check; may be given several times
    #[arg(long, value_name = "NAME", value_parser = names())]
    only: Vec<String>,
    /// Multiply every tolerance by this factor; 0 makes every comparison fail
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = number(|scale: &f64| (0.0..=f64::MAX).contains(scale), "a number, zero or more"))]
    tolerance_scale: f64,
    /// Test the checks themselves: run each with parameters that are wrong on purpose, one at a time. Every comparison
    /// must fail for at least one of them
    #[arg(long)]
    falsify: bool,
}

/// The result of the checks.
#[derive(Serialize)]
struct Report {
    tolerance_scale: f64,
    falsified: bool,
    /// Whether every check passes.
    sound: bool,
    checks: Vec<Outcome>,
}

/// The result of the checks with parameters that are wrong on purpose.
#[derive(Serialize)]
struct FalsifiedReport {
    tolerance_scale: f64,
    falsified: bool,
    /// Whether every comparison fails at least once, and every wrong parameter is noticed by the right comparisons.
    sound: bool,
    comparisons: usize,
    /// Number of comparisons that fail with at least one wrong parameter.
    broken: usize,
    checks: Vec<FalsifiedOutcome>,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(CHECKS.iter().map(|check| PossibleValue::new(check.name).help(check.summary)))
}

/// Runs the checks and prints the result.
pub fn run(options: ValidateOptions, json: bool) -> Result<(), Failure> {
    let chosen = |check: &&Check| options.only.is_empty() || options.only.iter().any(|name| name == check.name);
    let checks: Vec<&Check> = CHECKS.iter().filter(chosen).collect();
    if options.falsify {
        run_falsified(&checks, options.tolerance_scale, json)
    } else {
        run_as_described(&checks, options.tolerance_scale, json)
    }
}

fn run_as_described(checks: &[&Check], tolerance_scale: f64, json: bool) -> Result<(), Failure> {
    let cases: usize = checks.iter().map(|check| check.cases.len()).sum();
    let bar = progress::bar(cases as u64, "cases");
    let outcomes = underbrush_validation::run(checks, tolerance_scale, move || bar.inc(1));
    let failing = names_of(&outcomes, |outcome| (outcome.verdict == Verdict::Fail).then_some(outcome.name));
    let report = Report { tolerance_scale, falsified: false, sound: failing.is_empty(), checks: outcomes };
    output::result(json, &report, || text::described(&report))?;
    unless(report.sound, format!("these checks fail: {failing}"))
}

fn run_falsified(checks: &[&Check], tolerance_scale: f64, json: bool) -> Result<(), Failure> {
    let cases = checks.iter().flat_map(|check| check.cases);
    let runs: usize = cases.map(|case| case.falsifications.len()).sum();
    let bar = progress::bar(runs as u64, "falsified cases");
    let outcomes = falsify(checks, tolerance_scale, move || bar.inc(1));
    let unsound = names_of(&outcomes, |outcome| (!outcome.sound).then_some(outcome.name));
    let comparisons = || outcomes.iter().flat_map(|outcome| &outcome.comparisons);
    let report = FalsifiedReport {
        tolerance_scale,
        falsified: true,
        sound: unsound.is_empty(),
        comparisons: comparisons().count(),
        broken: comparisons().filter(|found| found.broken).count(),
        checks: outcomes,
    };
    output::result(json, &report, || text::falsified(&report))?;
    unless(report.sound, format!("these checks do not notice a wrong parameter as they should: {unsound}"))
}

fn unless(sound: bool, complaint: String) -> Result<(), Failure> {
    if sound { Ok(()) } else { Err(Failure::run(complaint)) }
}

fn names_of<T>(outcomes: &[T], name: impl Fn(&T) -> Option<&'static str>) -> String {
    outcomes.iter().filter_map(name).collect::<Vec<_>>().join(", ")
}
