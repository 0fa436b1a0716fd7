//! How the cells of a cross-validation table agree with published ones, as text and as a chart: for one campaign and for
//! the mean of several.

use underbrush_experiments::table_cell::{CellKey, Ordering};
use underbrush_recording::distinct;

use crate::style::{self, PUBLISHED};
use crate::{AccuracyChart, Report, Rows, Table, capitalized, counted, fitting, lowest, possessive};

/// A difference that counts as agreement, points: the target for the mean over the cells.
const CLOSE_POINTS: f64 = 3.0;

/// A cell to be compared.
#[derive(Clone, Copy)]
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

/// A sentence, beginning with `what`, on the agreement with the published cells and on cells below the majority
/// baseline.
pub fn sentences(what: &str, cells: &[&Compared]) -> String {
    let below = cells.iter().filter(|cell| cell.accuracy < cell.majority_baseline).map(|cell| {
        let Compared { key, accuracy, majority_baseline, balanced_accuracy, .. } = cell;
        let name = key.name();
        format!(
            "{name}, {accuracy:.1} % (majority {majority_baseline:.1} %, balanced accuracy {balanced_accuracy:.1} %)"
        )
    });
    let below = below_majority(&below.collect::<Vec<String>>(), cells.len());
    match with_published(what, cells) {
        Some(published) => format!("{published} {}", capitalized(&below)),
        None => format!("{what}, {below}"),
    }
}

fn with_published(what: &str, cells: &[&Compared]) -> Option<String> {
    let pairs: Vec<(&Compared, f64)> = cells.iter().filter_map(|cell| Some((*cell, cell.published?))).collect();
    let difference = |(cell, published): &(&Compared, f64)| (cell.accuracy - published).abs();
    let farthest = pairs.iter().max_by(|a, b| difference(a).total_cmp(&difference(b)))?;
    let mean = pairs.iter().map(difference).sum::<f64>() / pairs.len() as f64;
    let close = pairs.iter().filter(|pair| difference(pair) <= CLOSE_POINTS).count();
    let higher = pairs.iter().filter(|(cell, published)| cell.accuracy > *published).count();
    let text = format!(
        "{what}, the {} from the paper's by {mean:.1} points on average. {} within {CLOSE_POINTS} points; {} higher than \
         the paper's and {} lower or equal.",
        if pairs.len() == 1 { "cell differs".to_owned() } else { format!("{} cells differ", pairs.len()) },
        counted(close, "is", "are"),
        counted(higher, "is", "are"),
        pairs.len() - higher
    );
    let (cell, published) = farthest;
    let (name, here) = (cell.key.name(), cell.accuracy);
    Some(text + &format!(" The largest difference is in {name}: {here:.1} % here, {published:.1} % in the paper."))
}

/// The cells in which a constant verdict would be more accurate, as a sentence that begins with a small letter.
fn below_majority(below: &[String], cells: usize) -> String {
    if below.is_empty() {
        return "no cell is below the majority baseline.".into();
    }
    let (count, are) = (below.len(), fitting(below.len(), "is", "are"));
    format!(
        "{count} of {cells} cells {are} below the majority baseline, so always naming the most frequent category would do better: \
         {}.",
        below.join("; ")
    )
}

/// Adds [`sentences`] on each recipe, which begin with what `what` makes of its name, and returns the recipes.
pub fn add_sentences(report: &mut Report, cells: &[Compared], what: impl Fn(&str) -> String) -> Vec<String> {
    let recipes = distinct(cells.iter().map(|cell| cell.key.recipe.clone()));
    for recipe in &recipes {
        let own: Vec<&Compared> = cells.iter().filter(|cell| cell.key.recipe == *recipe).collect();
        report.page.paragraph(&sentences(&what(possessive(recipe)), &own));
    }
    recipes
}

/// Adds the published orderings, if there are any, as sentences and as a table.
pub fn add_orderings(report: &mut Report, name: &str, caption: &str, own: &[Ordering]) {
    if own.is_empty() {
        return;
    }
    report.page.paragraph(&format!("{caption}:"));
    report.page.list(own.iter().map(|own| ordering(own, report.results.quick)));
    let table = orderings_table(name, caption, own);
    report.print(&table, 5);
    report.numbers(table);
}

/// A published ordering as a sentence. The few reaches of a quick run cannot decide it.
fn ordering(own: &Ordering, is_quick: bool) -> String {
    let verdict = match own.pairs_holding {
        some if is_quick => format!("a quick run cannot decide this; here it holds in {some} of"),
        all if all == own.pairs => "this holds in all".to_owned(),
        some => format!("this does not hold; it does in {some} of"),
    };
    format!("{} recipe, {}: {verdict} {} pairs of cells", possessive(&own.recipe), own.statement, own.pairs)
}

/// The published orderings as a table.
fn orderings_table(name: &str, caption: &str, orderings: &[Ordering]) -> Table {
    Rows::of(orderings)
        .column("the paper's statement", |own| own.statement.as_str())
        .column("recipe", |own| own.recipe.as_str())
        .column("holds", |own| own.holds.to_string())
        .column("pairs", |own| own.pairs)
        .column("pairs holding", |own| own.pairs_holding)
        .column("where not", |own| own.failing.join("; "))
        .table(name, caption)
}

/// All cells in one chart: a row for each, with a mark for each recipe, the published figure and the majority baseline.
pub fn dot_plot(name: &str, title: &str, cells: &[Compared]) -> String {
    let names = distinct(cells.iter().map(|cell| cell.key.name()));
    let recipes = distinct(cells.iter().map(|cell| &cell.key.recipe));
    let row = |cell: &Compared| names.iter().position(|name| *name == cell.key.name()).unwrap_or_default();
    let first: Vec<&Compared> = cells.iter().filter(|cell| Some(&&cell.key.recipe) == recipes.first()).collect();
    let mut chart = AccuracyChart::new(format!("Accuracy in per cent: {title}."), names.clone());
    let baselines = first.iter().map(|cell| (row(cell), cell.majority_baseline, None));
    chart.series("majority", style::MAJORITY_MARK, 0.0, baselines);
    for (number, recipe) in recipes.iter().enumerate() {
        let own = cells.iter().filter(|cell| cell.key.recipe == **recipe);
        let points = own.map(|cell| (row(cell), cell.accuracy, cell.interval));
        // A row of this chart is about a third as high as a place of an upright one is wide.
        let aside = 3.0 * style::aside(number, recipes.len());
        chart.series(&format!("{} recipe", possessive(recipe)), style::paired(number), aside, points);
    }
    chart.series("paper", PUBLISHED, 0.0, first.iter().filter_map(|cell| Some((row(cell), cell.published?, None))));
    let lowest =
        lowest(cells.iter().map(|cell| cell.interval.map_or(cell.accuracy, |(low, _)| low.min(cell.accuracy))));
    chart.chart(name, title, "", lowest).dot_plot()
}
