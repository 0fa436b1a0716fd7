//! `underbrush validate`: runs the physics checks and prints their residuals.

use std::fmt::Write;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;
use underbrush_recording::{distinct, math};
use underbrush_report::drawing::Rows;
use underbrush_validation::{CHECKS, Check, CheckOutcome, FalsifiedOutcome, FalsifiedRun, Judged, Verdict, falsify};

use crate::options::number;
use crate::{Failure, output, progress};

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
    checks: Vec<CheckOutcome>,
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
    output::result(json, &report, || described(&report))?;
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
    output::result(json, &report, || falsified(&report))?;
    unless(report.sound, format!("these checks do not notice a wrong parameter as they should: {unsound}"))
}

fn unless(sound: bool, complaint: String) -> Result<(), Failure> {
    if sound { Ok(()) } else { Err(Failure::run(complaint)) }
}

fn names_of<T>(outcomes: &[T], name: impl Fn(&T) -> Option<&'static str>) -> String {
    outcomes.iter().filter_map(name).collect::<Vec<_>>().join(", ")
}

/// The checks with their tables.
fn described(report: &Report) -> String {
    let mut text = String::new();
    for outcome in &report.checks {
        let _ = writeln!(text, "{} {}: {}\n{}.", outcome.number, outcome.name, word(outcome.verdict), outcome.summary);
        for error in &outcome.errors {
            let _ = writeln!(text, "Stopped with an error: {error}.");
        }
        text += &comparisons(outcome, report.tolerance_scale);
        text.push('\n');
    }
    let count = |verdict| report.checks.iter().filter(|outcome| outcome.verdict == verdict).count();
    let _ =
        write!(text, "{} checks: {} pass, {} fail", report.checks.len(), count(Verdict::Pass), count(Verdict::Fail));
    text
}

/// The checks, with the effect of each wrong parameter on their comparisons.
fn falsified(report: &FalsifiedReport) -> String {
    let mut text = String::new();
    for outcome in &report.checks {
        let broken = outcome.comparisons.iter().filter(|found| found.broken).count();
        let FalsifiedOutcome { number, name, summary, comparisons, .. } = outcome;
        let all = comparisons.len();
        let _ = writeln!(text, "{number} {name}: {broken} of {all} comparisons fail as they should\n{summary}.");
        for (index, wrong) in outcome.falsifications.iter().enumerate() {
            let _ = writeln!(text, "[{}] {}: {}", index + 1, wrong.wrong, wrong.by);
        }
        text += &broken_comparisons(outcome, report.tolerance_scale);
        for fault in &outcome.faults {
            let _ = writeln!(text, "FAULT: {fault}");
        }
        text.push('\n');
    }
    let runs: usize = report.checks.iter().map(|outcome| outcome.falsifications.len()).sum();
    let FalsifiedReport { comparisons, broken, checks, .. } = report;
    let (checks, hold) = (checks.len(), comparisons - broken);
    let _ = write!(text, "{comparisons} comparisons of {checks} checks with {runs} wrong parameters: ");
    let _ = write!(text, "{broken} fail as they should, {hold} hold");
    text
}

/// The comparisons of one check with wrong parameters. Each is shown with the first parameter that makes it fail, or
/// with the last one if none does.
fn broken_comparisons(outcome: &FalsifiedOutcome, tolerance_scale: f64) -> String {
    let breaks = |run: &&FalsifiedRun| run.judged.verdict == Verdict::Fail;
    let shown = outcome.comparisons.iter().filter_map(|found| {
        let run = found.runs.iter().find(breaks).or(found.runs.last())?;
        Some((found, run))
    });
    Rows::of(shown)
        .columns(VALUES, |(_, run)| values(&run.judged, tolerance_scale))
        .column("fails with", |(found, _)| {
            let by = found.runs.iter().filter(breaks).map(|run| format!("[{}]", run.falsification + 1));
            let by = by.collect::<Vec<_>>().join(" ");
            if by.is_empty() { "HOLDS".into() } else { by }
        })
        .text()
}

/// The table of one check, with the reasons for its tolerances.
fn comparisons(outcome: &CheckOutcome, tolerance_scale: f64) -> String {
    if outcome.comparisons.is_empty() {
        return String::new();
    }
    let reasons = distinct(outcome.comparisons.iter().map(|judged| judged.comparison.reason));
    let before = |judged: &Judged| reasons.iter().take_while(|reason| **reason != judged.comparison.reason).count();
    let mut text = Rows::of(&outcome.comparisons)
        .columns(VALUES, |judged| values(judged, tolerance_scale))
        .column("", |judged| word(judged.verdict))
        .column("because", |judged| format!("[{}]", before(judged) + 1))
        .text();
    for (index, reason) in reasons.iter().enumerate() {
        let _ = writeln!(text, "[{}] {reason}", index + 1);
    }
    text
}

/// The headings of [`values`].
const VALUES: [&str; 5] = ["", "closed form", "simulated", "residual", "tolerance"];

/// Quantity, closed form, simulated value, residual and tolerance.
fn values(judged: &Judged, tolerance_scale: f64) -> [String; 5] {
    let comparison = &judged.comparison;
    let name = if comparison.unit.is_empty() {
        comparison.quantity.clone()
    } else {
        format!("{} / {}", comparison.quantity, comparison.unit)
    };
    let error = |value: f64| match comparison.relative {
        // In per cent, small relative residuals would all be 0.000 %.
        true if value < 1e-5 => format!("{value:.1e}"),
        true => format!("{:.3} %", 100.0 * value),
        false => six_digits(value),
    };
    [
        name,
        six_digits(comparison.expected),
        six_digits(comparison.found),
        error(comparison.residual),
        error(comparison.tolerance * tolerance_scale),
    ]
}

/// Six digits, with an exponent if the number is far from 1.
fn six_digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e6).contains(&size) => format!("{value:.3e}"),
        size => {
            let digits = (5 - math::log10(size).floor() as i32).clamp(0, 8) as usize;
            format!("{value:.digits$}")
        }
    }
}

fn word(verdict: Verdict) -> &'static str {
    if verdict == Verdict::Pass { "pass" } else { "FAIL" }
}
