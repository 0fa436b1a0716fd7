//! A row of the benchmark as readable text.

use underbrush_experiments::benchmark::{
    BenchmarkRow, Estimate, Halves, ObjectFigures, Ranking, Reaching, SetRecord, TrackFigures, Transfer, UnknownIn,
    Verdicts,
};

use crate::{Rows, counted};

/// A sentence on what was judged, tables of the figures, and what they were measured on.
pub fn of(row: &BenchmarkRow) -> String {
    let entry = &row.entry;
    let classifier = entry.classifier.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
    let quick = if row.complete { "" } else { ", a quick run that is no row of the table" };
    let figures = match &row.figures {
        TrackFigures::Verdicts(own) => of_halves("leaf, trunk or unknown, balanced, at the end / %", own, of_verdicts),
        TrackFigures::Transfer(own) => of_halves("leaf or trunk, mean over the shifted settings / %", own, of_transfer),
        TrackFigures::Reaching(own) => {
            of_halves("goals reached without more than 5 N on a trunk / %", own, of_reaching)
        }
        TrackFigures::Earlier(figures) => format!("{figures:#}\n"),
    };
    let set = |own: &SetRecord| {
        let SetRecord { name, seed, scenes, data_blake3 } = own;
        let reaches: u64 = scenes.iter().map(|scene| scene.reaches).sum();
        format!("{name}: {} of seed {seed}, data {data_blake3:.16}\n", counted(reaches, "reach", "reaches"))
    };
    let sets: String = row.sets.iter().map(set).collect();
    format!("{}, {}: {}{classifier}{quick}\n\n{figures}\n{sets}", row.benchmark, row.track, entry.name)
}

/// The ranking figure, whether the halves differ, and the figures of both halves.
fn of_halves<T>(figure: &str, halves: &Halves<T>, of: fn(&T) -> String) -> String {
    let Ranking { audit, public, difference } = &halves.ranking;
    let verdict = match halves.ranking.halves_differ() {
        Some(true) => "differ by more than chance explains",
        Some(false) => "do not differ by more than chance explains",
        None => "cannot be compared: there are too few reaches",
    };
    let figures = [("audit, which ranks", audit), ("public", public), ("public minus audit", difference)];
    format!(
        "{}The public and the audit half {verdict}.\n\nAudit half\n{}\nPublic half\n{}\nIn brackets: 95 % intervals over \
         whole reaches.\n",
        Rows::of(&figures).column("half", |own| own.0).column(figure, |own| percent(own.1)).text(),
        of(&halves.audit),
        of(&halves.public),
    )
}

fn of_verdicts(verdicts: &Verdicts) -> String {
    let fitted = |force_n: f64| format!(", with up to {force_n:.3} N called nothing, which the benchmark fitted");
    let nothing = verdicts.nothing_up_to_n.map_or_else(String::new, fitted);
    let forearm = of_objects("forearm", &verdicts.forearm);
    let flipper = verdicts.flipper.as_ref().map(|own| of_objects("flipper", own));
    let flipper = flipper.unwrap_or_else(|| "The model does not judge the flipper.\n".into());
    format!(
        "{forearm}{flipper}Nothing, leaf or trunk, taxel frames of the forearm: {} %{nothing}.\n",
        percent(&verdicts.nothing_leaf_or_trunk)
    )
}

fn of_objects(patch: &str, figures: &ObjectFigures) -> String {
    let table = Rows::of(&figures.moments)
        .column("time since first felt", |at| at.seconds.map_or("end".into(), |seconds| format!("{seconds} s")))
        .column("leaf, trunk or unknown / %", |at| percent(&at.leaf_trunk_or_unknown))
        .column("leaf or trunk / %", |at| percent(&at.leaf_or_trunk))
        .column("unknown found / %", |at| percent(&at.unknown_found))
        .column("known called unknown / %", |at| percent(&at.known_called_unknown))
        .text();
    let [leaves, trunks, unknown] = figures.objects;
    let found = |own: &UnknownIn| format!("; {} of {}: {} % found", own.objects, own.scene, percent(&own.found));
    let scenes: String = figures.unknown_in.iter().map(found).collect();
    format!("{table}Objects that touched the {patch}: {leaves} leaves, {trunks} trunks, {unknown} unknown{scenes}.\n")
}

fn of_transfer(transfer: &Transfer) -> String {
    Rows::of(&transfer.settings)
        .column("setting", |own| own.setting.as_str())
        .columns(["leaves", "trunks"], |own| own.objects)
        .column("leaf or trunk / %", |own| percent(&own.leaf_or_trunk))
        .column("difference / points", |own| percent(&own.difference))
        .text()
}

fn of_reaching(reaching: &Reaching) -> String {
    let figures = [
        ("goals reached without more than 5 N on a trunk / %", percent(&reaching.reached_gently)),
        ("goals reached / %", percent(&reaching.reached)),
        ("time for each goal reached / s", reaching.seconds_for_each.text(1.0, 2)),
        ("largest force on a trunk in a reach, mean / N", reaching.trunk_peak_n.text(1.0, 2)),
        ("impulse on leaves in a reach, mean / N s", reaching.leaf_impulse_n_s.text(1.0, 2)),
        ("largest force on a trunk in any reach / N", format!("{:.1}", reaching.largest_on_trunk_n)),
    ];
    let table = Rows::of(&figures).column("figure", |own| own.0).column("value", |own| own.1.as_str()).text();
    let (reaches, goals) = (counted(reaching.reaches, "reach", "reaches"), counted(reaching.goals, "goal", "goals"));
    format!("{table}{reaches} with {goals}.\n")
}

fn percent(share: &Estimate) -> String {
    share.text(100.0, 1)
}
