//! Runs several suites, and writes bounds from what the runs found.

use std::path::Path;

use serde::Serialize;
use underbrush_recording::{Fault, InputError, disk, math};

use super::metric::{Sides, Statistic};
use super::result::{BoundResult, SuiteResult};
use super::statistics::{margin, margin_with_one_more};
use super::{Bound, SceneBound, Suite};
use crate::files::{self, Source};
use crate::progress::Progress;

/// The results of some suites.
#[derive(Debug, Serialize)]
pub struct Checked {
    /// Whether all bounds hold.
    pub passed: bool,
    /// One for each suite.
    pub suites: Vec<SuiteResult>,
}

impl Checked {
    /// Runs the suites of these files, with `seed` instead of each file's seed if it is given. With `bless`, bounds
    /// computed from the results are written into the files, and the results are checked against them.
    ///
    /// # Errors
    /// As [`Suite::run`]; with `bless` also if a bound is not written in braces, a metric cannot be bounded, or a file
    /// cannot be written.
    pub fn of(
        mut suites: Vec<(Suite, &Path)>,
        seed: Option<u64>,
        bless: bool,
        progress: &dyn Progress,
    ) -> Result<Self, Fault> {
        if bless {
            for (suite, path) in &suites {
                check_places(suite, path)?;
            }
        }
        if let Some(seed) = seed {
            suites.iter_mut().for_each(|(suite, _)| suite.set_seed(seed));
        }
        let (mut results, mut texts) = (Vec::new(), Vec::new());
        for (suite, path) in &suites {
            let mut result = suite.run(progress)?;
            if bless {
                texts.push((suite, *path, blessed(suite, &mut result, path, progress)?));
            }
            results.push(result);
        }
        write(&texts)?;
        Ok(Checked { passed: results.iter().all(|result| result.passed), suites: results })
    }
}

/// The text of the file with new bounds, against which the result is checked. A file is never replaced by one that cannot
/// be read.
pub(super) fn blessed(
    suite: &Suite,
    result: &mut SuiteResult,
    path: &Path,
    progress: &dyn Progress,
) -> Result<String, Fault> {
    let text = blessed_text(suite, result)?;
    let new = Suite::parse(path, text.clone()).map_err(|error| {
        Fault::Usage(format!(
            "the file would not be a suite with the new bounds, so nothing was written ({error}). Write each bound in \
             braces, on one line"
        ))
    })?;
    *result = new.hold(result.clone());
    for scene in &result.scenes {
        for bound in scene.bounds.iter().filter(|bound| bound.allows_everything()) {
            progress.remark(&format!(
                "warning: {}: {} differs so much between reaches that its bound allows everything; run more reaches, let the \
                 scene vary less, or remove it",
                scene.scene, bound.name
            ));
        }
    }
    Ok(text)
}

/// Writes the texts with new bounds, if no file has changed since its suite was read.
pub(super) fn write(texts: &[(&Suite, &Path, String)]) -> Result<(), Fault> {
    for (suite, path, _) in texts {
        if files::read(path, "suite")? != suite.text {
            let path = path.display();
            let text = "changed while the suites ran, so nothing was written; run the command again";
            return Err(Fault::Run(format!("{path}: the file {text}")));
        }
    }
    for (_, path, text) in texts {
        disk::write_file(path, text.as_bytes())?;
    }
    Ok(())
}

/// Checks that every bound of the suite in the file at `path` can be replaced in its text: it must be written in
/// braces. A dotted key or a table header also makes a bound, but then the bound is not in one place.
///
/// # Errors
/// [`InputError`] with the line of the first other bound.
fn check_places(suite: &Suite, path: &Path) -> Result<(), InputError> {
    let text = suite.text.as_str();
    for own in suite.scenes.iter().flat_map(|scene| &scene.bounds) {
        let written = text.get(own.span.clone()).unwrap_or_default();
        if !written.starts_with('{') {
            let source = Source { path, text };
            let field = source.field_at(&format!("bounds.{}", own.name()), own.span.start);
            let allowed = "a bound in braces, on one line, such as goals_reached = { at_least = 0.7 }";
            return Err(field.fault(format!("`{written}`, a dotted key or a table header"), allowed));
        }
    }
    Ok(())
}

/// The text of the suite's file with new bounds, from a result of the same suite. Everything else in the file stays as
/// it is.
///
/// An existing bound stays one- or two-sided; a new one follows its metric. The false-alarm probability of the suite
/// is shared equally among the sides of all means and shares.
///
/// # Errors
/// When a metric was measured in fewer than two reaches and therefore cannot be bounded.
pub(super) fn blessed_text(suite: &Suite, result: &SuiteResult) -> Result<String, Fault> {
    let all = || {
        let scenes = suite.scenes.iter().zip(&result.scenes);
        scenes.flat_map(|(scene, found)| scene.bounds.iter().zip(&found.bounds).map(move |pair| (scene, pair)))
    };
    let derived = all().map(|(_, (own, _))| own).filter(|own| own.metric.statistic != Statistic::Largest);
    let count = derived.flat_map(sides).filter(|is_bounded| *is_bounded).count();
    let probability = suite.file.bless.false_alarm / count.max(1) as f64;
    let mut changes = Vec::new();
    for (scene, (own, found)) in all() {
        let bound = new_bound(suite, own, found, probability).ok_or_else(|| {
            let path = scene.plan.scene.path.display();
            let (name, measured, reaches) = (&found.name, found.values.len(), scene.reaches);
            Fault::Usage(format!(
                "{path}: {name} was measured in {measured} of {reaches} reaches, and a bound takes two; nothing was written. Add \
                 reaches, change the scene, or remove the bound"
            ))
        })?;
        changes.push((own.span.clone(), written(&bound)));
    }
    changes.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
    let mut text = suite.text.clone();
    for (span, bound) in changes {
        text.replace_range(span, &bound);
    }
    Ok(text)
}

/// Whether it is bounded below, and whether above.
fn sides(own: &SceneBound) -> [bool; 2] {
    match own.bound {
        bound if bound.is_given() => [bound.at_least.is_some(), bound.at_most.is_some()],
        _ => [own.metric.sides != Sides::AtMost, own.metric.sides != Sides::AtLeast],
    }
}

fn new_bound(suite: &Suite, own: &SceneBound, result: &BoundResult, probability: f64) -> Option<Bound> {
    let found = result.found?;
    let values: Vec<f64> = result.values.iter().map(|own| own.value).collect();
    let margin = match own.metric.statistic {
        Statistic::Mean if own.metric.counts => margin_with_one_more(&values, found + 1.0, probability)?,
        // The added reach is at the other end of the range. A share that is the same in all reaches needs it too,
        // because it has no spread of its own.
        Statistic::Share if own.metric.counts || values.iter().all(|value| *value == values[0]) => {
            margin_with_one_more(&values, if found < 0.5 { 1.0 } else { 0.0 }, probability)?
        }
        Statistic::Mean | Statistic::Share => margin(&values, probability)?,
        Statistic::Largest => (suite.file.bless.largest_factor - 1.0) * found.abs(),
    };
    let end = own.metric.statistic.end();
    // A limit does not depend on what was found. If the file has another limit, somebody chose it on purpose.
    let limit = own.metric.limit.map(|limit| own.bound.at_most.unwrap_or(limit));
    let high = limit.unwrap_or((found + margin).min(end));
    let [below, above] = sides(own);
    Some(Bound {
        // No metric is negative.
        at_least: below.then(|| rounded(found - margin, f64::floor).max(0.0)),
        at_most: above.then(|| rounded(high, f64::ceil).min(end)),
        blessed: Some(rounded(found, f64::round)),
    })
}

/// A number rounded to four significant digits; `round` gives the direction.
fn rounded(number: f64, round: fn(f64) -> f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return number;
    }
    let digits = 3 - math::log10(number.abs()).floor() as i32;
    // Goes through decimal text, so that no binary rounding error of the scale remains.
    let scaled = round(number * 10_f64.powi(digits));
    format!("{scaled}e{}", -digits).parse().unwrap_or(number)
}

fn written(bound: &Bound) -> String {
    let keys = [("at_least", bound.at_least), ("at_most", bound.at_most), ("blessed", bound.blessed)];
    let given = keys.into_iter().filter_map(|(key, value)| Some(format!("{key} = {}", number(value?))));
    format!("{{ {} }}", given.collect::<Vec<_>>().join(", "))
}

/// A number as TOML. Very small numbers, such as residuals, get an exponent.
fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 { format!("{value:e}") } else { value.to_string() }
}
