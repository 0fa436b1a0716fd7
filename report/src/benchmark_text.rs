//! A row of the benchmark as readable text.

use underbrush_experiments::benchmark::{Estimate, Figures, Reaching, Row, Transfer, Verdicts};

use crate::drawing::Rows;
use crate::text::counted;

/// A sentence on what was judged, a table of the figures, and what they were measured on.
pub fn of(row: &Row) -> String {
    let entry = &row.entry;
    let classifier = entry.classifier.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
    let quick = if row.complete { "" } else { ", a quick run that is no row of the table" };
    let figures = match &row.figures {
        Figures::Verdicts(verdicts) => of_verdicts(verdicts),
        Figures::Transfer(transfer) => of_transfer(transfer),
        Figures::Reaching(reaching) => of_reaching(reaching),
    };
    let set = |own: &underbrush_experiments::benchmark::SetRecord| {
        let reaches: u64 = own.scenes.iter().map(|scene| scene.reaches).sum();
        format!(
            "{}: {} of seed {}, data {}\n",
            own.name,
            counted(reaches, "reach", "reaches"),
            own.seed,
            &own.data_blake3[..16]
        )
    };
    let sets: String = row.sets.iter().map(set).collect();
    format!("{}, {}: {}{classifier}{quick}\n\n{figures}\n{sets}", row.benchmark, row.track, entry.name)
}

fn of_verdicts(verdicts: &Verdicts) -> String {
    let table = Rows::of(&verdicts.moments)
        .column("samples since contact", |at| at.samples.map_or("whole contact".into(), |samples| samples.to_string()))
        .column("leaf or trunk / %", |at| percent(&at.leaf_or_trunk))
        .column("nothing, leaf or trunk / %", |at| percent(&at.nothing_leaf_or_trunk))
        .column("foam roll, ROC area", |at| number(&at.foam_roll_area, 2))
        .column("water bottle, ROC area", |at| number(&at.water_bottle_area, 2))
        .text();
    let counts = &verdicts.contacts;
    let two = majority(&[counts.leaf, counts.trunk]);
    format!(
        "{table}\nBalanced accuracies: naming one class always gives 50 and 33.3 %. In brackets: 95 % intervals over whole reaches.\n\
         Contacts: {} without a touch, {} with leaves, {} with trunks, {} with the foam roll, {} with the water bottle.\n\
         Always naming the more frequent of leaf and trunk is right in {two:.1} % of these contacts.\n",
        counts.nothing, counts.leaf, counts.trunk, counts.foam_roll, counts.water_bottle,
    )
}

fn of_transfer(transfer: &Transfer) -> String {
    let table = Rows::of(&transfer.settings)
        .column("setting", |own| own.setting.as_str())
        .columns(["leaves", "trunks"], |own| own.contacts)
        .number("majority / %", 1, |own| majority(&own.contacts))
        .column("leaf or trunk / %", |own| percent(&own.leaf_or_trunk))
        .column("difference / points", |own| percent(&own.difference))
        .text();
    format!(
        "{table}\nBalanced accuracies at the end of contacts: naming one category always gives 50 %. The first setting is as in \
         training.\nIn brackets: 95 % intervals over whole reaches.\n"
    )
}

fn of_reaching(reaching: &Reaching) -> String {
    let figures = [
        ("goals reached / %", percent(&reaching.reached)),
        ("time for each goal reached / s", number(&reaching.seconds_for_each, 2)),
        ("largest force on a trunk in a reach, mean / N", number(&reaching.trunk_peak_n, 2)),
        ("impulse on leaves in a reach, mean / N s", number(&reaching.leaf_impulse_n_s, 2)),
        ("largest force on a trunk in any reach / N", format!("{:.1}", reaching.largest_on_trunk_n)),
    ];
    format!(
        "{}\n{} with {}. In brackets: 95 % intervals over whole reaches.\n",
        Rows::of(&figures).column("figure", |own| own.0).column("value", |own| own.1.as_str()).text(),
        counted(reaching.reaches, "reach", "reaches"),
        counted(reaching.goals, "goal", "goals")
    )
}

/// Share of the largest count, per cent.
fn majority(counts: &[usize]) -> f64 {
    let all: usize = counts.iter().sum();
    let most = counts.iter().max().copied().unwrap_or_default();
    100.0 * most as f64 / all.max(1) as f64
}

fn percent(share: &Estimate) -> String {
    let of = |value: f64| 100.0 * value;
    number(&Estimate { value: share.value.map(of), interval: share.interval.map(|ends| ends.map(of)) }, 1)
}

fn number(estimate: &Estimate, digits: usize) -> String {
    let Some(value) = estimate.value else {
        return "-".into();
    };
    let interval = estimate.interval.map(|[low, high]| format!(" ({low:.digits$} to {high:.digits$})"));
    format!("{value:.digits$}{}", interval.unwrap_or_default())
}
