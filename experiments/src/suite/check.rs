//! Rules for a suite file that the types of its keys do not express.

use std::ops::Range;

use underbrush_classifier::any_model::OnlineModel;
use underbrush_recording::{Category, InputError, PLAIN, is_plain};
use underbrush_sim::scene::Scene;

use super::SceneBound;
use super::file::{BlessSection, Bound, Bounds, Entry, SceneEntry, SuiteFile};
use super::metric::{METRICS, Metric};
use crate::files::Source;

/// Largest number of reaches of a scene. A regression test cannot run more, so a larger number is a typing error.
const MAX_REACHES: u64 = 100_000;

/// Checks the summary and the numbers of a file.
pub fn numbers(file: &SuiteFile, source: &Source) -> Result<(), InputError> {
    if !is_plain(&file.summary) {
        return Err(source.field("summary", "").fault(format!("{:?}", file.summary), PLAIN));
    }
    if file.scenes.is_empty() {
        return Err(source.field("scenes", "").fault("no scenes", "at least one [[scenes]]"));
    }
    for SceneEntry { reaches, .. } in &file.scenes {
        let allowed = format!("2 to {MAX_REACHES} reaches: one alone does not show how much they vary");
        source.check((2..=MAX_REACHES).contains(reaches), "scenes.reaches", &reaches.to_string(), &allowed)?;
    }
    let BlessSection { false_alarm, largest_factor } = file.bless;
    let (alarm_holds, factor_holds) = ((1e-9..=0.5).contains(&false_alarm), (1.0..=1000.0).contains(&largest_factor));
    source.check_number(alarm_holds, "bless.false_alarm", false_alarm, "a probability from 1e-9 to 0.5")?;
    source.check_number(factor_holds, "bless.largest_factor", largest_factor, "a factor from 1 to 1000")
}

/// The bounds of a scene, in the order of the file.
pub fn bounds(
    bounds: &Bounds,
    scene: &Scene,
    model: Option<&OnlineModel>,
    source: &Source,
) -> Result<Vec<SceneBound>, InputError> {
    let mut found = Vec::new();
    for (name, entry) in &bounds.0 {
        // A table of categories begins at its first category.
        let first = match entry.get_ref() {
            Entry::Bound(_) => None,
            Entry::ByCategory(categories) => categories.values().map(|bound| bound.span().start).min(),
        };
        let field = source.field_at(&format!("bounds.{name}"), first.unwrap_or(entry.span().start));
        let Some(metric) = Metric::find(name) else {
            let names = METRICS.map(|metric| metric.name).join(", ");
            return Err(field.fault(name, format!("one of {names}")));
        };
        if metric.needs_model && model.is_none() {
            let allowed = "a bound on verdicts only in a suite with a [model] file";
            return Err(field.fault("a suite without a model", allowed));
        }
        if metric.needs_touch_model && matches!(model, Some(OnlineModel::OfTrials(..))) {
            let allowed = "a bound on this verdict only with a touch model, because other models never give it";
            return Err(field.fault("a suite with a classifier of trials", allowed));
        }
        match (entry.get_ref(), metric.by_category) {
            (Entry::Bound(bound), false) => found.push(checked(metric, None, *bound, entry.span(), source)?),
            (Entry::ByCategory(categories), true) => {
                for (name, bound) in categories {
                    let category = scene.categories().get(name.as_str()).copied().ok_or_else(|| {
                        let field = source.field_at(&format!("bounds.{}", metric.name), bound.span().start);
                        let names: Vec<&str> = scene.categories().into_keys().collect();
                        field.fault(name, format!("a category of the scene's objects: {}", names.join(", ")))
                    })?;
                    found.push(checked(metric, Some(category), *bound.get_ref(), bound.span(), source)?);
                }
            }
            (Entry::Bound(_), true) => {
                let allowed = format!("a bound for each category, such as {}.leaf = {{ at_most = 1.0 }}", metric.name);
                return Err(field.fault("a bound without a category", allowed));
            }
            (Entry::ByCategory(_), false) => {
                let allowed = format!("one bound, such as {} = {{ at_most = 1.0 }}", metric.name);
                return Err(field.fault("bounds for categories", allowed));
            }
        }
    }
    found.sort_by_key(|bound| bound.span.start);
    Ok(found)
}

/// Checks the numbers of a bound.
fn checked(
    metric: &'static Metric,
    category: Option<Category>,
    bound: Bound,
    span: Range<usize>,
    source: &Source,
) -> Result<SceneBound, InputError> {
    let own = SceneBound { metric, category, bound, span };
    let numbers = [bound.at_least, bound.at_most, bound.blessed];
    let field = source.field_at(&format!("bounds.{}", own.name()), own.span.start);
    let end = metric.statistic.end();
    if let Some(number) = numbers.into_iter().flatten().find(|number| !number.is_finite() || *number > end) {
        let allowed = if end < f64::INFINITY { "finite numbers up to 1, for a share" } else { "finite numbers" };
        return Err(field.fault(number.to_string(), allowed));
    }
    if let Some((low, high)) = bound.at_least.zip(bound.at_most).filter(|(low, high)| low > high) {
        return Err(field.fault(format!("at_least = {low} and at_most = {high}"), "at_least no larger than at_most"));
    }
    Ok(own)
}
