//! `underbrush validate`: the physics checks with their residuals.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use serde::Serialize;
use underbrush_validation::{CHECKS, Check, CheckError, Judged, Outcome, Simulated, Verdict, portraits, roll_loop};

use crate::failure::Failure;
use crate::{output, portrait, progress};

/// Options of `underbrush validate`.
#[derive(Args)]
pub struct Options {
    /// Run this check only; may be repeated
    #[arg(long, value_name = "NAME", value_parser = names())]
    only: Vec<String>,
    /// Multiply every tolerance by this; 0 makes every comparison fail
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = scale)]
    tolerance_scale: f64,
    /// Run every check with one parameter wrong on purpose, and demand that it fails
    #[arg(long)]
    falsify: bool,
    /// Folder for pictures: the skin under the edge of a leaf, a trunk and a foam roll, and the roll's loop (SVG)
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    tolerance_scale: f64,
    falsified: bool,
    /// Whether all is as it should be: every check passes, or, falsified, every check fails.
    sound: bool,
    checks: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    outcome: Outcome,
    falsification: &'static str,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(
        CHECKS
            .iter()
            .map(|check| PossibleValue::new(check.name).help(check.summary)),
    )
}

fn scale(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(scale) if (0.0..=f64::MAX).contains(&scale) => Ok(scale),
        _ => Err("a number, zero or more".into()),
    }
}

/// Runs the checks and prints what they found.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let chosen = |check: &&Check| options.only.is_empty() || options.only.iter().any(|name| name == check.name);
    let checks: Vec<&Check> = CHECKS.iter().filter(chosen).collect();
    let simulated = if options.falsify {
        Simulated::Falsified
    } else {
        Simulated::AsDescribed
    };
    if let Some(folder) = &options.pictures {
        let broken = |error: CheckError| Failure::run(error.to_string());
        let skin = portrait::skin(&portraits().map_err(broken)?);
        output::write_file(&folder.join("skin.svg"), skin.as_bytes())?;
        let roll = portrait::roll_loop(&roll_loop().map_err(broken)?);
        output::write_file(&folder.join("foam-roll.svg"), roll.as_bytes())?;
    }
    let bar = progress::bar(checks.len() as u64, "checks");
    let outcomes = underbrush_validation::run(&checks, simulated, options.tolerance_scale, || bar.inc(1));
    bar.finish_and_clear();
    let is_sound = |outcome: &Outcome| (outcome.verdict == Verdict::Fail) == options.falsify;
    let unsound: Vec<&str> = outcomes
        .iter()
        .filter(|outcome| !is_sound(outcome))
        .map(|outcome| outcome.name)
        .collect();
    let failure = match (unsound.is_empty(), options.falsify) {
        (true, _) => Ok(()),
        (false, false) => Err(Failure::run(format!("these checks fail: {}", unsound.join(", ")))),
        (false, true) => Err(Failure::run(format!(
            "these checks do not fail though falsified: {}",
            unsound.join(", ")
        ))),
    };
    let report = Report {
        tolerance_scale: options.tolerance_scale,
        falsified: options.falsify,
        sound: unsound.is_empty(),
        checks: outcomes
            .into_iter()
            .zip(&checks)
            .map(|(outcome, check)| Row {
                outcome,
                falsification: check.falsification,
            })
            .collect(),
    };
    output::result(json, &report, || text(&report))?;
    failure
}

fn text(report: &Report) -> String {
    let mut text = String::new();
    for row in &report.checks {
        let outcome = &row.outcome;
        let _ = writeln!(
            text,
            "{} {}: {}\n{}.",
            outcome.number,
            outcome.name,
            word(outcome.verdict),
            outcome.summary
        );
        if report.falsified {
            let _ = writeln!(text, "Falsified: {}.", row.falsification);
        }
        if let Some(error) = &outcome.error {
            let _ = writeln!(text, "Broke off: {error}.");
        }
        text += &comparisons(outcome, report.tolerance_scale);
        text.push('\n');
    }
    let count = |verdict| {
        report
            .checks
            .iter()
            .filter(|row| row.outcome.verdict == verdict)
            .count()
    };
    let _ = write!(
        text,
        "{} checks: {} pass, {} with a known shortfall, {} fail",
        report.checks.len(),
        count(Verdict::Pass),
        count(Verdict::KnownShortfall),
        count(Verdict::Fail)
    );
    if report.falsified {
        text += "; falsified, every one must fail";
    }
    text
}

/// The table of one check, with what its tolerances come from and why known shortfalls miss them.
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
        rows.push(cells(judged, tolerance_scale, reason + 1));
    }
    let header = ["", "closed form", "simulated", "residual", "tolerance", "", "because"];
    let mut text = output::table(&header, &rows);
    for (index, reason) in reasons.iter().enumerate() {
        let _ = writeln!(text, "[{}] {reason}", index + 1);
    }
    let mut causes: Vec<&str> = Vec::new();
    for cause in outcome.comparisons.iter().filter_map(|judged| judged.cause) {
        if !causes.contains(&cause) {
            causes.push(cause);
            let _ = writeln!(text, "short: {cause}");
        }
    }
    text
}

fn cells(judged: &Judged, tolerance_scale: f64, reason: usize) -> Vec<String> {
    let comparison = &judged.comparison;
    let name = if comparison.unit.is_empty() {
        comparison.quantity.clone()
    } else {
        format!("{} / {}", comparison.quantity, comparison.unit)
    };
    let error = |value: f64| {
        if comparison.relative {
            format!("{:.3} %", 100.0 * value)
        } else {
            number(value)
        }
    };
    // Small relative residuals would all be 0.000 %.
    let small = |value: f64| {
        if comparison.relative && value < 1e-5 {
            format!("{value:.1e}")
        } else {
            error(value)
        }
    };
    vec![
        name,
        number(comparison.expected),
        number(comparison.found),
        small(comparison.residual),
        small(comparison.tolerance * tolerance_scale),
        word(judged.verdict).into(),
        format!("[{reason}]"),
    ]
}

/// Six digits, with an exponent where the number is far from 1.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e6).contains(&size) => format!("{value:.3e}"),
        size => {
            let digits = (5 - size.log10().floor() as i32).clamp(0, 8) as usize;
            format!("{value:.digits$}")
        }
    }
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::KnownShortfall => "short",
        Verdict::Fail => "FAIL",
    }
}
