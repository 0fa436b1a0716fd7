//! Other classifiers, and their accuracy after few samples.

use underbrush_classifier::evaluate::AccuracyBySamples;
use underbrush_experiments::definition::ClassifierEntry;
use underbrush_experiments::experiment::classifiers::{Compared, Outcome, Speed};

use crate::drawing::{Axis, Cell, Chart, Dash, Layer, Point, Shape, Style, Table};
use crate::report::{Report, accuracy_cells, by_touch};
use crate::style::{self, INK};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    if outcome.classifiers.is_empty() {
        return;
    }
    let file = &report.results.definition.file;
    let best = report.published().and_then(|own| own.best_accuracy_percent);
    report.section("classifiers", "Other classifiers, and how fast they decide");
    report.page.paragraph(
        "All classifiers are tested on whole reaches that they were not trained on, all on the same folds. This is stricter \
         than folds by position, which can put trials of one contact on both sides.",
    );
    report.page.paragraph(&best_of(&outcome.classifiers, best));
    let accuracies: Vec<(&str, f64)> =
        outcome.classifiers.iter().map(|own| (own.classifier.as_str(), own.accuracy.accuracy)).collect();
    if let Some(text) = features(&file.classifiers, &accuracies) {
        report.page.paragraph(&text);
    }
    let compared = table(&outcome.classifiers, best);
    report.print(&compared, 7);
    report.table(compared);
    let rows = outcome.classifiers.iter().map(|own| (own.classifier.clone(), &own.accuracy));
    let touched = by_touch("classifiers_by_touch", "Other classifiers", rows);
    report.print(&touched, 9);
    report.table(touched);
    let min_samples = file.trials.min_samples;
    report.page.paragraph(&format!(
        "The charts ask for a verdict after a number of samples since contact; a contact that ended earlier keeps its last \
         verdict. The first chart shows the trials of the cross-validation table, which last {min_samples} samples or more. \
         Its points before {min_samples} are therefore of contacts that are known to go on, which nobody can know at that \
         moment. The second chart shows all contacts, including shorter ones. In both, the classifiers were trained on the \
         longer trials of the other reaches."
    ));
    report.page.paragraph(&speeds(&outcome.speeds, min_samples));
    let lasting = format!("Contacts known to last {min_samples} samples");
    let charts = [
        chart(&outcome.speeds, "lasting", &lasting, |own| &own.lasting_contacts, best),
        chart(&outcome.speeds, "all", "All contacts", |own| &own.all_contacts, best),
    ];
    let charts: Vec<String> = charts.into_iter().flatten().collect();
    report.page.figure("Accuracy on all trials against samples since contact.", &charts);
    report.numbers(by_samples(&outcome.speeds, min_samples));
}

/// The classifier with the highest accuracy, compared with the published best.
fn best_of(classifiers: &[Compared], published: Option<f64>) -> String {
    let best = classifiers.iter().max_by(|a, b| a.accuracy.accuracy.total_cmp(&b.accuracy.accuracy));
    let Some(best) = best else { return String::new() };
    let own = &best.accuracy;
    let against = published.map_or(String::new(), |paper| {
        let place = match () {
            () if own.low > paper => "its whole interval is above",
            () if own.high < paper => "its whole interval is below",
            () => "its interval includes",
        };
        format!(": {place} the paper's best of {paper} %")
    });
    format!(
        "The best on whole trials is {} with {:.1} % ({:.1} to {:.1}, balanced {:.1} %, majority baseline {:.1} %){against}.",
        best.classifier, own.accuracy, own.low, own.high, own.balanced_accuracy, own.majority_baseline
    )
}

/// Compares classifiers with the same features, and the same method with more features.
pub fn features(entries: &[ClassifierEntry], accuracies: &[(&str, f64)]) -> Option<String> {
    let accuracy = |entry: &ClassifierEntry| {
        let own = accuracies.iter().find(|(name, _)| *name == entry.name);
        own.map(|(_, accuracy)| *accuracy)
    };
    let mut sentences = Vec::new();
    for (place, entry) in entries.iter().enumerate() {
        for other in &entries[place + 1..] {
            let (Some(first), Some(second)) = (accuracy(entry), accuracy(other)) else {
                continue;
            };
            let (Some(seen), Some(other_seen)) = (entry.features, other.features) else {
                continue;
            };
            let (same, all) = (seen.names(), other_seen.names());
            let same_method = entry.method.name == other.method.name;
            if let Some(added) = all.strip_prefix(same.as_slice()).filter(|_| same_method) {
                let of_region: Vec<&str> = other_seen.of_region().map(|feature| feature.name).collect();
                let added = match added == of_region {
                    true => "the contact region".to_owned(),
                    false => added.join(" and "),
                };
                sentences.push(format!(
                    "Adding {added} changes the accuracy of {} by {:+.1} points, to {second:.1} %.",
                    entry.name,
                    second - first
                ));
            } else if !same_method && seen == other_seen {
                sentences.push(format!(
                    "With the same features ({}), {} has {first:.1} % and {} {second:.1} % ({:+.1} points).",
                    same.join(", "),
                    entry.name,
                    other.name,
                    second - first
                ));
            }
        }
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

/// How much the accuracy after a few samples depends on knowing that a contact will last.
fn speeds(speeds: &[Speed], min_samples: usize) -> String {
    let after = |points: &[AccuracyBySamples], samples| {
        let own = points.iter().find(|point| point.samples == samples);
        own.map_or(f64::NAN, |point| 100.0 * point.accuracy)
    };
    let count = |points: &[AccuracyBySamples]| points.last().map_or(0, |point| point.lasting);
    let Some(first) = speeds.first() else {
        return String::new();
    };
    let rows: Vec<String> = speeds
        .iter()
        .map(|speed| {
            let (lasting, all) = (&speed.lasting_contacts, &speed.all_contacts);
            format!(
                "{}: {:.1} % and {:.1} % after 12 samples, {:.1} % and {:.1} % at the end",
                speed.classifier,
                after(lasting, Some(12)),
                after(all, Some(12)),
                after(lasting, None),
                after(all, None)
            )
        })
        .collect();
    format!(
        "{} of {} contacts last {min_samples} samples or more. Accuracy on the longer ones and on all: {}.",
        count(&first.lasting_contacts),
        count(&first.all_contacts),
        rows.join("; ")
    )
}

fn chart(
    speeds: &[Speed],
    name: &str,
    title: &str,
    points_of: impl Fn(&Speed) -> &Vec<AccuracyBySamples>,
    published: Option<f64>,
) -> Option<String> {
    let first = points_of(speeds.first()?);
    let sample_name = |point: &AccuracyBySamples| point.samples.map_or("all".into(), |samples| samples.to_string());
    let names: Vec<String> = first.iter().map(sample_name).collect();
    let mut description = String::from("Accuracy in per cent by samples since contact.");
    let mut layers = Vec::new();
    for (place, speed) in speeds.iter().enumerate() {
        let points = points_of(speed).iter().enumerate().map(|(place, point)| Point {
            x: place as f64,
            y: 100.0 * point.accuracy,
            interval: None,
        });
        let points: Vec<Point> = points.collect();
        description += &format!(" {}: {}.", speed.classifier, style::told(&names, &points));
        layers.push(Layer::new(speed.classifier.as_str(), style::series(place), Shape::Points(points)));
    }
    // The baseline is the same at every count, because all trials are judged.
    if let Some(point) = first.first() {
        let majority = 100.0 * point.majority_baseline;
        description += &format!(" Majority baseline: {majority:.1}.");
        layers.push(style::majority_layer(majority, names.len()));
    }
    if let Some(best) = published {
        let ends = [0, names.len() - 1].map(|place| (place as f64, best));
        layers.push(Layer::new(
            "paper's best, whole trials",
            Style::line(INK, Dash::Dotted),
            Shape::Line(ends.to_vec()),
        ));
    }
    let all = speeds.iter().flat_map(&points_of).map(|point| 100.0 * point.accuracy);
    let lowest = all.fold(40.0, f64::min);
    let chart = Chart {
        name: format!("by-samples-{name}"),
        title: title.into(),
        description,
        x: Axis::names("samples since contact", names),
        y: Axis::spanning("accuracy / %", (lowest / 20.0).floor() * 20.0, 100.0),
        layers,
    };
    Some(chart.svg())
}

fn table(classifiers: &[Compared], published: Option<f64>) -> Table {
    let mut columns = vec!["classifier", "accuracy / %", "from", "to", "balanced / %", "majority / %"];
    columns.extend(published.map(|_| "against the paper's best"));
    let caption = "Taxels, whole trials, two folds of whole reaches: accuracy with the 95 % interval by reach, balanced accuracy \
                   and majority baseline";
    let mut table = Table::new("classifiers", caption, &columns);
    for compared in classifiers {
        let mut row = vec![compared.classifier.as_str().into()];
        row.extend(accuracy_cells(&compared.accuracy, 1));
        row.extend(published.map(|best| Cell::Difference(compared.accuracy.accuracy - best, 1)));
        table.rows.push(row);
    }
    table
}

/// Accuracy after increasing numbers of samples, on lasting contacts and on all contacts.
fn by_samples(speeds: &[Speed], min_samples: usize) -> Table {
    let columns = [
        "contacts",
        "classifier",
        "max samples",
        "accuracy / %",
        "from",
        "to",
        "balanced / %",
        "majority / %",
        "trials lasting so long",
        "accuracy on these / %",
        "balanced on these / %",
        "majority on these / %",
    ];
    let lasting = format!("{min_samples} samples or more");
    let percent = |fraction: Option<f64>| Cell::optional(fraction.map(|fraction| 100.0 * fraction), 1);
    let mut table = Table::new("accuracy_by_samples", "Accuracy by samples since contact", &columns);
    for speed in speeds {
        for (contacts, points) in [(lasting.as_str(), &speed.lasting_contacts), ("all", &speed.all_contacts)] {
            for point in points {
                let interval = point.interval_by_reach;
                table.rows.push(vec![
                    contacts.into(),
                    speed.classifier.as_str().into(),
                    point.samples.map_or("all".into(), Cell::Count),
                    Cell::Number(100.0 * point.accuracy, 1),
                    percent(interval.map(|interval| interval.low)),
                    percent(interval.map(|interval| interval.high)),
                    percent(point.balanced_accuracy),
                    percent(Some(point.majority_baseline)),
                    point.lasting.into(),
                    percent(point.accuracy_of_lasting),
                    percent(point.balanced_accuracy_of_lasting),
                    percent(point.majority_baseline_of_lasting),
                ]);
            }
        }
    }
    table
}
