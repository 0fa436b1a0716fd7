//! The first screen: how near the results are to the published ones, what agrees, what does not, and why.

use std::collections::BTreeMap;

use underbrush_experiments::Unit;
use underbrush_experiments::table_cell::Ordering;

use crate::agreement::{self, Compared};
use crate::section::{campaigns, moments, table_one};
use crate::{Report, escape, fitting, joined};

/// Trials per reach that differ by less than this factor count as agreeing.
const SIMILAR: f64 = 1.25;

/// What is compared: the means of all campaigns, or else the only campaign.
struct Comparison<'a> {
    /// The cells of all recipes.
    all: Vec<Compared<'a>>,
    orderings: &'a [Ordering],
    /// By recipe: the mean difference from the published cells, points.
    points: &'a BTreeMap<String, f64>,
    /// Name of the unit and the category, number of trials per reach here, and the published one.
    trials: Vec<(String, f64, Option<f64>)>,
    /// Name, accuracy, balanced accuracy and majority baseline of each classifier, per cent.
    classifiers: Vec<(&'a str, [f64; 3])>,
    /// What the figures are, after the name of the table.
    of_what: String,
    whiskers: &'static str,
}

impl<'a> Comparison<'a> {
    fn of(report: &Report<'a>) -> Self {
        let outcomes = &report.results.outcomes;
        let trials_name = |unit: Unit, category: &str| format!("{} trials of {category}", unit.name());
        match &outcomes.campaigns.campaigns {
            Some(own) => Comparison {
                all: own.table_1.iter().map(campaigns::compared).collect(),
                orderings: &own.orderings,
                points: &own.mean_absolute_difference_points,
                trials: (own.trials_per_reach.iter())
                    .map(|row| (trials_name(row.by, &row.category), row.per_reach.mean, row.paper))
                    .collect(),
                classifiers: (own.classifiers.iter())
                    .map(|own| (own.classifier.as_str(), &own.figures.all))
                    .map(|(name, all)| (name, [&all.accuracy, &all.balanced_accuracy, &all.majority_baseline]))
                    .map(|(name, figures)| (name, figures.map(|own| own.mean)))
                    .collect(),
                of_what: format!("mean of {} campaigns", own.seeds.len()),
                whiskers: "± one standard deviation",
            },
            None => Comparison {
                all: outcomes.table_one.table_1.iter().map(table_one::compared).collect(),
                orderings: &outcomes.table_one.orderings,
                points: &outcomes.table_one.mean_absolute_difference_points,
                trials: (outcomes.training_data.trials_per_reach.iter())
                    .map(|row| (trials_name(row.by, &row.category), row.per_reach, row.paper))
                    .collect(),
                classifiers: (outcomes.classifiers.classifiers.iter())
                    .map(|own| (own.classifier.as_str(), own.figures.figures()))
                    .collect(),
                of_what: "one campaign".to_owned(),
                whiskers: "95 % intervals",
            },
        }
    }

    /// The first recipe, of which the first screen tells.
    fn recipe(&self) -> Option<&str> {
        self.all.first().map(|cell| cell.key.recipe.as_str())
    }
}

/// Adds the first screen.
pub fn add(report: &mut Report) {
    let (comparison, results) = (Comparison::of(report), report.results);
    let name = report.figure_name("table_one", "Cross-validation");
    report.page.lead(&lead(&comparison, &name));
    let introduction = results.definition.file.introduction.trim();
    if !introduction.is_empty() {
        report.page.paragraph(introduction);
    }
    let Comparison { of_what, whiskers, .. } = &comparison;
    let title = format!("{name}, {of_what}, {whiskers}");
    let mut parts = vec![agreement::dot_plot("table-1", &title, &comparison.all)];
    if let Some(moment) = results.outcomes.moments.all().next() {
        let address = escape(&moments::address(moment, 0));
        let image = moments::image(moment, 0);
        parts.push(format!("<a href=\"{address}\">{image}Replay this reach in 3-D</a>"));
    }
    report.page.side_by_side(&parts);
    let (agrees, differs) = compare(&comparison, results.quick);
    report.page.cards([
        ("Agrees with the paper", agrees),
        ("Does not agree", differs),
        ("Why", why(report, &comparison)),
    ]);
}

/// How close the table is to the paper, and how good the classifier with the best balanced accuracy is.
fn lead(comparison: &Comparison, name: &str) -> String {
    let best = comparison.classifiers.iter().max_by(|a, b| a.1[1].total_cmp(&b.1[1]));
    let best = best.map(|(name, [accuracy, balanced, majority])| {
        format!(
            "The classifier with the best balanced accuracy, {name}, is right on {accuracy:.1} % of the taxel trials (balanced \
             {balanced:.1} %, majority baseline {majority:.1} %)."
        )
    });
    let points = comparison.recipe().and_then(|recipe| comparison.points.get(recipe));
    let near = points.map(|points| {
        format!("{name} differs from the paper's by {points:.1} points on average ({}).", comparison.of_what)
    });
    joined(near.into_iter().chain(best), " ")
}

/// What agrees with the published figures, and what does not.
fn compare(comparison: &Comparison, is_quick: bool) -> (Vec<String>, Vec<String>) {
    let (mut agrees, mut differs) = (Vec::new(), Vec::new());
    let cells = comparison.all.iter().filter(|cell| Some(cell.key.recipe.as_str()) == comparison.recipe());
    let pairs: Vec<(&Compared, f64)> = cells.filter_map(|cell| Some((cell, cell.published?))).collect();
    let is_within = |(cell, published): &&(&Compared, f64)| {
        let reach = if cell.covers { 1.0 } else { 2.0 };
        let wide = |end: f64| cell.accuracy + reach * (end - cell.accuracy);
        cell.interval.is_some_and(|(low, high)| (wide(low)..=wide(high)).contains(published))
    };
    let (within, all) = (pairs.iter().filter(is_within).count(), pairs.len());
    let what =
        if pairs.iter().all(|(cell, _)| cell.covers) { "95 % interval" } else { "interval of two standard deviations" };
    if within > 0 {
        agrees.push(format!(
            "{within} of {all} accuracies of the paper {} within the {what} of those here.",
            fitting(within, "lies", "lie")
        ));
    }
    let difference = |(cell, published): &(&Compared, f64)| cell.accuracy - published;
    let farthest = pairs.iter().max_by(|a, b| difference(a).abs().total_cmp(&difference(b).abs()));
    if let Some((cell, published)) = farthest.filter(|_| within < all) {
        let (outside, name, here) = (all - within, cell.key.name(), cell.accuracy);
        differs.push(format!(
            "{outside} of {all} {} outside the {what}. The farthest is {name}: {here:.1} % here, {published:.1} % in the paper.",
            fitting(outside, "lies", "lie")
        ));
    }
    let orderings = comparison.orderings.iter().filter(|own| Some(own.recipe.as_str()) == comparison.recipe());
    for ordering in orderings.filter(|_| !is_quick) {
        let side = if ordering.holds { &mut agrees } else { &mut differs };
        let Ordering { statement, pairs_holding, pairs, .. } = ordering;
        side.push(match ordering.holds {
            true => format!("As in the paper, {statement} (in all {pairs} pairs of cells)."),
            false => format!("In the paper {statement}; here in {pairs_holding} of {pairs} pairs of cells."),
        });
    }
    for (name, here, published) in &comparison.trials {
        let Some(published) = published else { continue };
        let ratio = here / published;
        let side = if (1.0 / SIMILAR..SIMILAR).contains(&ratio) { &mut agrees } else { &mut differs };
        side.push(format!("{ratio:.2} times the paper's number of {name} per reach."));
    }
    (agrees, differs)
}

/// What decides the level of the accuracies: trials that nothing touched, and the number of reaches.
fn why(report: &Report, comparison: &Comparison) -> Vec<String> {
    let mut why = Vec::new();
    let outcomes = &report.results.outcomes;
    let rows = &outcomes.training_data.trials_per_reach;
    let (trials, untouched) = rows.iter().fold((0, 0), |sum, row| (sum.0 + row.trials, sum.1 + row.untouched));
    let cells = outcomes.table_one.table_1.iter();
    let cells = cells.filter(|cell| Some(cell.key.recipe.as_str()) == comparison.recipe());
    let parts = cells.filter_map(|cell| Some([cell.figures.touched.as_ref()?, cell.figures.untouched.as_ref()?]));
    let parts: Vec<[f64; 2]> = parts.map(|parts| parts.map(|part| part.accuracy)).collect();
    if !parts.is_empty() {
        let [touched, nothing] = [0, 1].map(|side| parts.iter().map(|own| own[side]).sum::<f64>() / parts.len() as f64);
        let (share, seed) = (100.0 * untouched as f64 / trials.max(1) as f64, report.results.seed);
        why.push(format!(
            "Nothing touched the skin in {share:.0} % of the trials of seed {seed}: they are readings of the sensor alone, labelled by their \
             scene as on the robot. {nothing:.0} % of them are classified as labelled, and {touched:.0} % of the others (means \
             over the cells of the table)."
        ));
    }
    if report.results.quick {
        let undecided =
            if comparison.orderings.is_empty() { "" } else { ", and it cannot decide the paper's orderings" };
        why.push(format!(
            "This is a quick run of {} training reaches, so its intervals are wide{undecided}. A run without --quick has the full \
             number.",
            outcomes.training_data.reaches.count
        ));
    }
    why
}
