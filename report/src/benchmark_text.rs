//! A row of the benchmark as readable text.

use underbrush_experiments::benchmark::{Estimate, Figures, Reaching, Row, Transfer, Verdicts};

use crate::text::{counted, table};

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
    let rows: Vec<Vec<String>> = (verdicts.moments.iter())
        .map(|at| {
            vec![
                at.samples.map_or("whole contact".into(), |samples| samples.to_string()),
                percent(&at.leaf_or_trunk),
                percent(&at.nothing_leaf_or_trunk),
                number(&at.foam_roll_area, 2),
                number(&at.water_bottle_area, 2),
            ]
        })
        .collect();
    let header = [
        "samples since contact",
        "leaf or trunk / %",
        "nothing, leaf or trunk / %",
        "foam roll, ROC area",
        "water bottle, ROC area",
    ];
    let counts = &verdicts.contacts;
    let two = majority(&[counts.leaf, counts.trunk]);
    format!(
        "{}\nBalanced accuracies: naming one class always gives 50 and 33.3 %. In brackets: 95 % intervals over whole reaches.\n\
         Contacts: {} without a touch, {} with leaves, {} with trunks, {} with the foam roll, {} with the water bottle.\n\
         Always naming the more frequent of leaf and trunk is right in {two:.1} % of these contacts.\n",
        table(&header, &rows),
        counts.nothing,
        counts.leaf,
        counts.trunk,
        counts.foam_roll,
        counts.water_bottle,
    )
}

fn of_transfer(transfer: &Transfer) -> String {
    let rows: Vec<Vec<String>> = (transfer.settings.iter())
        .map(|setting| {
            let [leaf, trunk] = setting.contacts;
            vec![
                setting.setting.clone(),
                leaf.to_string(),
                trunk.to_string(),
                format!("{:.1}", majority(&setting.contacts)),
                percent(&setting.leaf_or_trunk),
                percent(&setting.difference),
            ]
        })
        .collect();
    let header = ["setting", "leaves", "trunks", "majority / %", "leaf or trunk / %", "difference / points"];
    format!(
        "{}\nBalanced accuracies at the end of contacts: naming one category always gives 50 %. The first setting is as in \
         training.\nIn brackets: 95 % intervals over whole reaches.\n",
        table(&header, &rows)
    )
}

fn of_reaching(reaching: &Reaching) -> String {
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let rows = [
        row("goals reached / %", percent(&reaching.reached)),
        row("time for each goal reached / s", number(&reaching.seconds_for_each, 2)),
        row("largest force on a trunk in a reach, mean / N", number(&reaching.trunk_peak_n, 2)),
        row("impulse on leaves in a reach, mean / N s", number(&reaching.leaf_impulse_n_s, 2)),
        row("largest force on a trunk in any reach / N", format!("{:.1}", reaching.largest_on_trunk_n)),
    ];
    format!(
        "{}\n{} with {}. In brackets: 95 % intervals over whole reaches.\n",
        table(&["figure", "value"], &rows),
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
