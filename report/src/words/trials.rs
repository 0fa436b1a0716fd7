//! What the numbers say about trials, and about models tested on them.

use underbrush_classifier::evaluate::TableOneUnit;

use super::possessive;
use underbrush_experiments::accuracy::Accuracy;
use underbrush_experiments::data;
use underbrush_experiments::example::Typical;
use underbrush_experiments::measurement::{Cell, TrialsPerReach, unit_name};
use underbrush_experiments::results::{Ordering, Results};

/// A difference that counts as agreement with the paper, points: the mark set for the mean over the cells.
const CLOSE_POINTS: f64 = 3.0;

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

/// Agreement of Table I in one recipe.
pub fn table_1(cells: &[Cell], recipe: &str) -> String {
    let own = || cells.iter().filter(|cell| cell.key.recipe == recipe);
    let cells: Vec<_> = own()
        .map(|cell| {
            let interval = Some((cell.accuracy.low, cell.accuracy.high));
            (cell.key.name(), cell.accuracy.accuracy, cell.paper, interval)
        })
        .collect();
    let below: Vec<String> = own()
        .filter(|cell| cell.accuracy.accuracy < cell.accuracy.majority_baseline)
        .map(|cell| {
            let Accuracy {
                accuracy,
                balanced_accuracy,
                majority_baseline,
                ..
            } = cell.accuracy;
            format!(
                "{}, {accuracy:.1} % (majority {majority_baseline:.1} %, balanced accuracy {balanced_accuracy:.1} %)",
                cell.key.name()
            )
        })
        .collect();
    let agreement = agreement(&format!("In the {} recipe", possessive(recipe)), &cells);
    format!("{agreement} {}", below_majority(&below, cells.len()))
}

/// Which cells the same verdict for every trial would beat.
fn below_majority(below: &[String], cells: usize) -> String {
    if below.is_empty() {
        return format!("All {cells} cells are at or above the majority baseline.");
    }
    format!(
        "{} of the {cells} cells lie below the majority baseline, so always naming the more frequent category would do \
         better: {}.",
        below.len(),
        below.join("; ")
    )
}

/// Agreement of the mean of campaigns in one recipe.
pub fn campaigns(results: &Results, recipe: &str) -> Option<String> {
    let campaigns = results.campaigns.as_ref()?;
    let own = || campaigns.table_1.iter().filter(|cell| cell.key.recipe == recipe);
    let cells: Vec<_> = own()
        .map(|cell| (cell.key.name(), cell.figures.accuracy.mean, cell.paper, None))
        .collect();
    let what = format!(
        "In the mean of {} campaigns and the {} recipe",
        campaigns.seeds.len(),
        possessive(recipe)
    );
    let below: Vec<String> = own()
        .filter(|cell| cell.figures.accuracy.mean < cell.figures.majority_baseline.mean)
        .map(|cell| {
            format!(
                "{}, {:.1} % (majority {:.1} %, balanced accuracy {:.1} %)",
                cell.key.name(),
                cell.figures.accuracy.mean,
                cell.figures.majority_baseline.mean,
                cell.figures.balanced_accuracy.mean
            )
        })
        .collect();
    Some(format!(
        "{} {}",
        agreement(&what, &cells),
        below_majority(&below, cells.len())
    ))
}

/// The majority baselines here, and in the paper by its counts of trials.
pub fn baselines(results: &Results) -> String {
    let of = |unit: TableOneUnit| {
        let cell = results.measurement.table_1.iter().find(|cell| cell.key.by == unit);
        let here = cell.map_or(f64::NAN, |cell| cell.accuracy.majority_baseline);
        format!(
            "{here:.1} % of the trials by {} ({:.1} % by the paper's counts)",
            unit_name(unit),
            data::paper_majority_percent(unit)
        )
    };
    format!(
        "An accuracy means little without its baseline. The majority baseline is what the same verdict for every trial would \
         reach: {} and {}. The balanced accuracy is the mean of the recalls of leaf and trunk, 50 % for such a verdict.",
        of(TableOneUnit::Component),
        of(TableOneUnit::Taxel)
    )
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
        own.map(|point| point.accuracy.accuracy)
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

/// The paper's statements on Fig. 5 against the medians over all touched trials.
pub fn figure_5(medians: &[Typical]) -> String {
    let of = |category: &str| medians.iter().find(|own| own.category == category);
    let (Some(leaf), Some(trunk)) = (of("leaf"), of("trunk")) else {
        return "There are too few trials in which something touched the taxel to compare leaf and trunk.".into();
    };
    let agreement = |holds: bool| {
        if holds {
            "as in the paper"
        } else {
            "unlike in the paper"
        }
    };
    let larger = |trunk: f64, leaf: f64| if trunk > leaf { "larger" } else { "not larger" };
    format!(
        "Medians over all trials in which something touched the taxel, {} of trunks and {} of leaves: the force 0.1 s after \
         contact is {} on trunks, {} ({:.2} N, leaves {:.2} N); the peak force is {} on trunks, {} ({:.2} N, leaves {:.2} N); \
         the motion is {} on trunks, {} ({:.1} cm, leaves {:.1} cm).",
        trunk.trials,
        leaf.trials,
        larger(trunk.force_after_100_ms_n, leaf.force_after_100_ms_n),
        agreement(trunk.force_after_100_ms_n > leaf.force_after_100_ms_n),
        trunk.force_after_100_ms_n,
        leaf.force_after_100_ms_n,
        larger(trunk.peak_force_n, leaf.peak_force_n),
        agreement(trunk.peak_force_n > leaf.peak_force_n),
        trunk.peak_force_n,
        leaf.peak_force_n,
        larger(trunk.motion_m, leaf.motion_m),
        agreement(trunk.motion_m < leaf.motion_m),
        100.0 * trunk.motion_m,
        100.0 * leaf.motion_m
    )
}

/// How many trials came of the sensor alone.
pub fn untouched(rows: &[TrialsPerReach]) -> String {
    let parts: Vec<String> = rows
        .iter()
        .filter(|row| row.trials > 0)
        .map(|row| {
            format!(
                "{} of {} by {} of {} ({:.0} %)",
                row.untouched,
                row.trials,
                unit_name(row.by),
                row.category,
                100.0 * row.untouched as f64 / row.trials as f64
            )
        })
        .collect();
    format!(
        "Nothing ever touched the skin in some trials: they come of strays, creep or crosstalk and carry the label of their \
         environment, as they would on the robot. They are {}. Accuracies are also given for touched and untouched trials \
         apart.",
        parts.join(", ")
    )
}
