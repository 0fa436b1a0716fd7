//! What the numbers say, in words; nothing here knows what they will be.

use std::path::Path;

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;

use super::campaign::AUTHORS;
use super::results::{Ordering, Results, features_name, unit_name};
use super::tables;
use crate::{audit, output};

mod beyond;

pub use beyond::{ablation, classifiers, splits, thresholds};

/// A difference that counts as agreement with the paper, points: the mark set for the mean over the cells.
const CLOSE_POINTS: f64 = 3.0;

/// For a terminal.
pub fn text(results: &Results, out: &Path) -> String {
    let reaches = &results.reaches;
    let mut text = format!(
        "{} training reaches, {:.0} s of simulated time\n{}\n{}\n\n",
        reaches.count,
        reaches.simulated_s,
        reaches.ends.text(),
        audit::text(&reaches.audit).trim_end()
    );
    let mut add = |table: &underbrush_classifier::report::Table, columns: usize| {
        let header: Vec<&str> = table.columns.iter().take(columns).map(String::as_str).collect();
        let rows: Vec<Vec<String>> = table
            .texts()
            .into_iter()
            .map(|mut row| {
                row.truncate(columns);
                row
            })
            .collect();
        text += &format!("{}\n{}\n", table.caption, output::table(&header, &rows));
    };
    add(&tables::trials_per_reach(results), 4);
    add(&tables::table_1(results, AUTHORS), 8);
    add(&tables::table_1(results, super::campaign::MODERN), 8);
    add(
        &tables::orderings("orderings", "The paper's orderings", &results.orderings),
        5,
    );
    if let Some(table) = tables::campaigns(results) {
        add(&table, 10);
    }
    if let Some(campaigns) = &results.campaigns {
        add(
            &tables::orderings("", "The paper's orderings on the mean campaign", &campaigns.orderings),
            5,
        );
    }
    add(&tables::classifiers(results), 5);
    if let Some(table) = tables::campaign_classifiers(results) {
        add(&table, 6);
    }
    for classifier in results.split_classifiers() {
        add(&tables::splits_of(results, classifier), 6);
    }
    if !results.ablation.is_empty() {
        add(&tables::ablation(results), 6);
    }
    add(&tables::figure_11(results), 9);
    add(&tables::detection(results), 7);
    for (recipe, points) in &results.mean_absolute_difference_points {
        text += &format!("mean absolute difference from the paper, {recipe} recipe: {points:.1} points\n");
    }
    for (recipe, points) in results
        .campaigns
        .iter()
        .flat_map(|campaigns| &campaigns.mean_absolute_difference_points)
    {
        text += &format!("the same of the mean campaign, {recipe} recipe: {points:.1} points\n");
    }
    let samples = results
        .figure_9
        .mean_samples_used
        .map_or("none".into(), |mean| format!("{mean:.1}"));
    text + &format!(
        "samples used for a verdict (Fig. 9): {samples}, paper {}\n{:.0} s in all; report in {}",
        results.figure_9.paper,
        results.timing.wall_s,
        out.join("report/index.html").display()
    )
}

/// Name of a cell, accuracy here and in the paper, and the interval of ours.
type Compared = (String, f64, f64, Option<(f64, f64)>);

/// How near cells are to the paper.
fn agreement(what: &str, cells: &[Compared]) -> String {
    let differences: Vec<f64> = cells.iter().map(|cell| (cell.1 - cell.2).abs()).collect();
    let mean = differences.iter().sum::<f64>() / cells.len().max(1) as f64;
    let close = differences
        .iter()
        .filter(|difference| **difference <= CLOSE_POINTS)
        .count();
    let covered = |cell: &&Compared| cell.3.is_some_and(|(low, high)| (low..=high).contains(&cell.2));
    let higher = cells.iter().filter(|cell| cell.1 > cell.2).count();
    let mut text = format!(
        "{what}, the {} cells differ from the paper's by {mean:.1} points on average; {close} are within {CLOSE_POINTS} \
         points, {higher} higher than the paper's and {} lower or equal.",
        cells.len(),
        cells.len() - higher
    );
    if cells.iter().all(|cell| cell.3.is_some()) {
        text += &format!(
            " The paper's figure lies within the interval of {} cells.",
            cells.iter().filter(covered).count()
        );
    }
    let farthest = cells
        .iter()
        .max_by(|a, b| (a.1 - a.2).abs().total_cmp(&(b.1 - b.2).abs()));
    if let Some((name, here, paper, _)) = farthest {
        text += &format!(" Farthest off: {name}, {here:.1} % here and {paper:.1} % in the paper.");
    }
    text
}

fn cell_name(by: TableOneUnit, features: FeatureSet, states: usize) -> String {
    format!("{}, {}, {states} states", unit_name(by), features_name(features))
}

/// Agreement of Table I in one recipe.
pub fn table_1(results: &Results, recipe: &str) -> String {
    let own = results.measurement.table_1.iter().filter(|cell| cell.recipe == recipe);
    let cells: Vec<_> = own
        .map(|cell| {
            let name = cell_name(cell.by, cell.features, cell.states);
            (name, cell.accuracy, cell.paper, Some((cell.low, cell.high)))
        })
        .collect();
    agreement(&format!("In the {} recipe", possessive(recipe)), &cells)
}

/// Agreement of the mean of campaigns in one recipe.
pub fn campaigns(results: &Results, recipe: &str) -> Option<String> {
    let campaigns = results.campaigns.as_ref()?;
    let own = campaigns.table_1.iter().filter(|cell| cell.recipe == recipe);
    let cells: Vec<_> = own
        .map(|cell| {
            let name = cell_name(cell.by, cell.features, cell.states);
            (name, cell.accuracy, cell.paper, None)
        })
        .collect();
    let what = format!(
        "In the mean of {} campaigns and the {} recipe",
        campaigns.seeds.len(),
        possessive(recipe)
    );
    Some(agreement(&what, &cells))
}

/// The authors' recipe, the modern recipe.
pub fn possessive(recipe: &str) -> String {
    if recipe == AUTHORS {
        format!("{recipe}'")
    } else {
        recipe.to_owned()
    }
}

/// Each ordering as a sentence.
pub fn orderings(orderings: &[Ordering]) -> Vec<String> {
    let sentence = |ordering: &Ordering| {
        let verdict = match ordering.pairs_holding {
            all if all == ordering.pairs => "holds in all".to_owned(),
            some => format!("does not hold: {some} of"),
        };
        format!(
            "{} recipe: that {} {verdict} {} pairs of cells",
            possessive(&ordering.recipe),
            ordering.statement,
            ordering.pairs
        )
    };
    orderings.iter().map(sentence).collect()
}

/// Trials per reach against the paper's.
pub fn trials(results: &Results) -> String {
    let parts: Vec<String> = results
        .measurement
        .trials_per_reach
        .iter()
        .map(|row| {
            let ratio = row.per_reach / row.paper;
            format!("{} {}: {ratio:.2} times the paper's", unit_name(row.by), row.category)
        })
        .collect();
    format!("Trials per reach, {}.", parts.join("; "))
}

/// The spread of accuracies over truncations, against the paper's "no significant effect".
pub fn truncation(results: &Results) -> String {
    let of = |states: usize, most: Option<usize>| {
        let own = results
            .figure_13
            .iter()
            .find(|point| (point.states, point.max_samples) == (states, most));
        own.map(|point| point.accuracy)
    };
    let parts: Vec<String> = [10, 20]
        .iter()
        .filter_map(|states| {
            let (full, at_50, at_6) = (of(*states, None)?, of(*states, Some(50))?, of(*states, Some(6))?);
            Some(format!(
                "{states} states: {full:.1} % on whole trials, {at_50:.1} % on 50 samples ({:+.1} points), {at_6:.1} % on 6 \
                 ({:+.1} points)",
                at_50 - full,
                at_6 - full
            ))
        })
        .collect();
    format!("With {}.", parts.join("; "))
}
