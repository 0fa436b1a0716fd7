//! The text that `underbrush validate` prints.

use std::fmt::Write;

use underbrush_recording::math;
use underbrush_report::drawing::Rows;
use underbrush_validation::{FalsifiedOutcome, FalsifiedRun, Judged, Outcome, Verdict};

use super::{FalsifiedReport, Report};

/// The checks with their tables.
pub fn described(report: &Report) -> String {
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
pub fn falsified(report: &FalsifiedReport) -> String {
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
fn comparisons(outcome: &Outcome, tolerance_scale: f64) -> String {
    if outcome.comparisons.is_empty() {
        return String::new();
    }
    let mut reasons: Vec<&str> = Vec::new();
    let mut rows = Vec::new();
    for judged in &outcome.comparisons {
        let known = reasons.iter().position(|reason| *reason == judged.comparison.reason);
        let reason = known.unwrap_or_else(|| {
            reasons.push(judged.comparison.reason);
            reasons.len() - 1
        });
        rows.push((judged, reason + 1));
    }
    let mut text = Rows::of(rows)
        .columns(VALUES, |(judged, _)| values(judged, tolerance_scale))
        .column("", |(judged, _)| word(judged.verdict))
        .column("because", |(_, reason)| format!("[{reason}]"))
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
    let error = |value: f64| {
        if comparison.relative { format!("{:.3} %", 100.0 * value) } else { number(value) }
    };
    // In per cent, small relative residuals would all be 0.000 %.
    let small = |value: f64| {
        if comparison.relative && value < 1e-5 { format!("{value:.1e}") } else { error(value) }
    };
    [
        name,
        number(comparison.expected),
        number(comparison.found),
        small(comparison.residual),
        small(comparison.tolerance * tolerance_scale),
    ]
}

/// Six digits, with an exponent if the number is far from 1.
fn number(value: f64) -> String {
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
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Fail => "FAIL",
    }
}
