//! How the cells of a cross-validation table agree with published ones, as text and as charts: for one campaign and for
//! the mean of several.

use underbrush_classifier::feature::FeatureSet;
use underbrush_experiments::cell::{CellKey, Ordering, unit_name};
use underbrush_experiments::definition::TableOneUnit;

use crate::drawing::{Axis, Chart, Layer, Point, Shape, Table};
use crate::report::possessive;
use crate::style::{self, PUBLISHED};
use crate::text::counted;

/// A difference that counts as agreement, points: the target for the mean over the cells.
const CLOSE_POINTS: f64 = 3.0;

/// A cell to be compared.
pub struct Compared<'a> {
    /// Which cell.
    pub key: &'a CellKey,
    /// Accuracy here, per cent.
    pub accuracy: f64,
    /// Its interval, or its spread over campaigns.
    pub interval: Option<(f64, f64)>,
    /// Whether the published figure should lie in this interval.
    pub covers: bool,
    /// Balanced accuracy, per cent.
    pub balanced_accuracy: f64,
    /// Majority baseline, per cent.
    pub majority_baseline: f64,
    /// The published accuracy, per cent.
    pub published: Option<f64>,
}

/// The recipes of some cells, in order.
pub fn recipes(cells: &[Compared]) -> Vec<String> {
    let mut recipes: Vec<String> = cells.iter().map(|cell| cell.key.recipe.clone()).collect();
    recipes.dedup();
    recipes
}

/// A sentence, beginning with `what`, on the agreement with the published cells and on cells below the majority
/// baseline.
pub fn sentences(what: &str, cells: &[&Compared]) -> String {
    let below: Vec<String> = cells
        .iter()
        .filter(|cell| cell.accuracy < cell.majority_baseline)
        .map(|cell| {
            format!(
                "{}, {:.1} % (majority {:.1} %, balanced accuracy {:.1} %)",
                cell.key.name(),
                cell.accuracy,
                cell.majority_baseline,
                cell.balanced_accuracy
            )
        })
        .collect();
    let agreement = with_published(what, cells);
    let below = below_majority(&below, cells.len());
    agreement.map_or(below.clone(), |agreement| format!("{agreement} {below}"))
}

fn with_published(what: &str, cells: &[&Compared]) -> Option<String> {
    let pairs: Vec<(&Compared, f64)> = cells.iter().filter_map(|cell| Some((*cell, cell.published?))).collect();
    let difference = |(cell, published): &(&Compared, f64)| (cell.accuracy - published).abs();
    let farthest = pairs.iter().max_by(|a, b| difference(a).total_cmp(&difference(b)))?;
    let mean = pairs.iter().map(difference).sum::<f64>() / pairs.len() as f64;
    let close = pairs.iter().filter(|pair| difference(pair) <= CLOSE_POINTS).count();
    let higher = pairs.iter().filter(|(cell, published)| cell.accuracy > *published).count();
    let mut text = format!(
        "{what}, the {} from the paper's by {mean:.1} points on average. {} within {CLOSE_POINTS} points; {} higher than \
         the paper's and {} lower or equal.",
        if pairs.len() == 1 { "cell differs".to_owned() } else { format!("{} cells differ", pairs.len()) },
        counted(close, "is", "are"),
        counted(higher, "is", "are"),
        pairs.len() - higher
    );
    if pairs.iter().all(|(cell, _)| cell.covers) {
        let covered = pairs
            .iter()
            .filter(|(cell, published)| cell.interval.is_some_and(|(low, high)| (low..=high).contains(published)));
        text +=
            &format!(" The paper's figure lies within the interval of {}.", counted(covered.count(), "cell", "cells"));
    }
    let (cell, published) = farthest;
    text += &format!(
        " The largest difference is in {}: {:.1} % here, {published:.1} % in the paper.",
        cell.key.name(),
        cell.accuracy
    );
    Some(text)
}

/// The cells in which a constant verdict would be more accurate.
fn below_majority(below: &[String], cells: usize) -> String {
    let which = match (below.len(), cells) {
        (_, 1) => "The only cell is".to_owned(),
        (0, _) => format!("All {cells} cells are"),
        (1, _) => format!("1 of the {cells} cells is"),
        (some, _) => format!("{some} of the {cells} cells are"),
    };
    if below.is_empty() {
        return format!("{which} at or above the majority baseline.");
    }
    format!(
        "{which} below the majority baseline, so always naming the most frequent category would do better: {}.",
        below.join("; ")
    )
}

/// Each published ordering as a sentence.
pub fn orderings(orderings: &[Ordering]) -> Vec<String> {
    let sentence = |ordering: &Ordering| {
        let verdict = match ordering.pairs_holding {
            all if all == ordering.pairs => "this holds in all".to_owned(),
            some => format!("this does not hold; it does in {some} of"),
        };
        format!(
            "{} recipe, {}: {verdict} {} pairs of cells",
            possessive(&ordering.recipe),
            ordering.statement,
            ordering.pairs
        )
    };
    orderings.iter().map(sentence).collect()
}

/// The published orderings as a table.
pub fn orderings_table(name: &str, caption: &str, orderings: &[Ordering]) -> Table {
    let columns = ["the paper's statement", "recipe", "holds", "pairs", "pairs holding", "where not"];
    let mut table = Table::new(name, caption, &columns);
    for ordering in orderings {
        table.rows.push(vec![
            ordering.statement.as_str().into(),
            ordering.recipe.as_str().into(),
            (if ordering.holds { "true" } else { "false" }).into(),
            ordering.pairs.into(),
            ordering.pairs_holding.into(),
            ordering.failing.join("; ").into(),
        ]);
    }
    table
}

/// Accuracy over the number of states: a chart for each unit and feature set; `suffix` follows each title.
pub fn charts(table: &str, suffix: &str, cells: &[Compared]) -> Vec<String> {
    let lowest = lowest(cells);
    let mut charts = Vec::new();
    for by in [TableOneUnit::Taxel, TableOneUnit::Component] {
        for features in [FeatureSet::FORCE, FeatureSet::FORCE_AND_MOTION] {
            let own = cells.iter().filter(|cell| (cell.key.by, cell.key.features) == (by, features));
            let own: Vec<&Compared> = own.collect();
            if !own.is_empty() {
                charts.push(chart(table, format!("{}, {features}{suffix}", unit_name(by)), &own, lowest));
            }
        }
    }
    charts
}

fn chart(table: &str, title: String, cells: &[&Compared], lowest: f64) -> String {
    let mut states: Vec<usize> = cells.iter().map(|cell| cell.key.states).collect();
    states.sort_unstable();
    states.dedup();
    let mut recipes: Vec<&String> = cells.iter().map(|cell| &cell.key.recipe).collect();
    recipes.dedup();
    let mut description = format!("Accuracy in per cent by number of hidden states, {title}.");
    let mut layers = Vec::new();
    let mut layer = |name: String, style, points: Vec<(usize, Point)>| {
        if points.is_empty() {
            return;
        }
        let values: Vec<String> = points.iter().map(|(states, point)| format!("{states}: {:.1}", point.y)).collect();
        description += &format!(" {name}: {}.", values.join(", "));
        let points = points.into_iter().map(|(_, point)| point).collect();
        layers.push(Layer::new(name, style, Shape::Points(points)));
    };
    let place = |cell: &Compared| states.iter().position(|own| *own == cell.key.states).unwrap_or_default() as f64;
    for (number, recipe) in recipes.iter().enumerate() {
        let own = cells.iter().filter(|cell| cell.key.recipe == **recipe);
        let points = own.map(|cell| {
            let point = Point {
                x: place(cell) + style::aside(number, recipes.len()),
                y: cell.accuracy,
                interval: cell.interval,
            };
            (cell.key.states, point)
        });
        layer(format!("{} recipe", possessive(recipe)), style::paired(number), points.collect());
    }
    let first = cells.iter().filter(|cell| Some(&&cell.key.recipe) == recipes.first());
    let published = first.filter_map(|cell| {
        let point = Point { x: place(cell), y: cell.published?, interval: None };
        Some((cell.key.states, point))
    });
    layer("paper".into(), PUBLISHED, published.collect());
    if let Some(cell) = cells.first() {
        description += &format!(" Majority baseline: {:.1}.", cell.majority_baseline);
        layers.push(style::majority_layer(cell.majority_baseline, states.len()));
    }
    let chart = Chart {
        name: format!("{table}-{}", crate::drawing::slug(&title)),
        title,
        description,
        x: Axis::names("hidden states", states.iter().map(usize::to_string)),
        y: Axis::spanning("accuracy / %", lowest, 100.0),
        layers,
    };
    chart.svg()
}

/// Lower end of the axes of accuracy, per cent: 40, or less if an interval begins lower.
fn lowest(cells: &[Compared]) -> f64 {
    let values = cells.iter().flat_map(|cell| [cell.accuracy, cell.interval.map_or(cell.accuracy, |(low, _)| low)]);
    let lowest = values.fold(40.0, f64::min);
    (lowest / 20.0).floor() * 20.0
}
