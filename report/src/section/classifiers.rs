//! Other classifiers, and their accuracy after few samples.

use underbrush_classifier::evaluate::AccuracyBySamples;
use underbrush_experiments::experiment::classifiers::{Compared, ComparedClassifiers, Speed};

use crate::{ACCURACY_HEADINGS, AccuracyChart, Cell, Report, Rows, Table, by_touch, lowest, style};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ComparedClassifiers) {
    if outcome.classifiers.is_empty() {
        return;
    }
    let best = report.published().and_then(|own| own.best_accuracy_percent);
    let how_fast = if outcome.speeds.is_empty() { "" } else { ", and how fast they decide" };
    report.section("classifiers", &format!("Other classifiers{how_fast}"));
    report.page.paragraph(
        "All classifiers are tested on whole reaches that they were not trained on, all on the same folds. This is stricter \
         than folds by position, which can put trials of one contact on both sides.",
    );
    report.page.paragraph(&best_of(&outcome.classifiers, best));
    report.printed(table(&outcome.classifiers, best), 7);
    let rows = outcome.classifiers.iter().map(|own| (own.classifier.clone(), &own.figures));
    report.printed(by_touch("classifiers_by_touch", "Other classifiers", rows), 9);
    if outcome.speeds.is_empty() {
        return;
    }
    let min_samples = report.results.definition.file.trials.min_samples;
    report.page.paragraph(&format!(
        "The charts ask for a verdict after a number of samples since contact; a contact that ended earlier keeps its last \
         verdict. The first chart shows the trials of the cross-validation table, which last {min_samples} samples or more. \
         Its points before {min_samples} are therefore of contacts that are known to go on, which nobody can know at that \
         moment. The second chart shows all contacts, including shorter ones. In both, the classifiers were trained on the \
         longer trials of the other reaches."
    ));
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
    let best = classifiers.iter().max_by(|a, b| a.figures.accuracy.total_cmp(&b.figures.accuracy));
    let Some(best) = best else { return String::new() };
    let own = &best.figures;
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

fn chart(
    speeds: &[Speed],
    name: &str,
    title: &str,
    points_of: impl Fn(&Speed) -> &Vec<AccuracyBySamples>,
    published: Option<f64>,
) -> Option<String> {
    let first = points_of(speeds.first()?);
    let sample_name = |point: &AccuracyBySamples| point.samples.map_or("all".into(), |samples| samples.to_string());
    let places = first.iter().map(sample_name).collect();
    let mut chart = AccuracyChart::new("Accuracy in per cent by samples since contact.", places);
    for (index, speed) in speeds.iter().enumerate() {
        let points = points_of(speed).iter().enumerate();
        let points = points.map(|(place, point)| (place, 100.0 * point.accuracy, None));
        chart.series(&speed.classifier, style::series(index), 0.0, points);
    }
    // The baseline is the same at every count, because all trials are judged.
    chart.majority(first.first().map(|point| 100.0 * point.majority_baseline));
    if let Some(best) = published {
        chart.level("paper's best, whole trials", best);
    }
    let all = speeds.iter().flat_map(&points_of).map(|point| 100.0 * point.accuracy);
    Some(chart.chart(format!("by-samples-{name}"), title, "samples since contact", lowest(all)).svg())
}

fn table(classifiers: &[Compared], published: Option<f64>) -> Table {
    let caption = "Taxels, whole trials, two folds of whole reaches: accuracy with the 95 % interval by reach, balanced accuracy \
                   and majority baseline";
    Rows::of(classifiers)
        .column("classifier", |own| own.classifier.as_str())
        .accuracy(ACCURACY_HEADINGS, 1, |own| &own.figures)
        .against_best(published, |own| own.figures.accuracy)
        .table("classifiers", caption)
}

/// Accuracy after increasing numbers of samples, on lasting contacts and on all contacts.
fn by_samples(speeds: &[Speed], min_samples: usize) -> Table {
    let lasting = format!("{min_samples} samples or more");
    let points = speeds.iter().flat_map(|Speed { classifier, lasting_contacts, all_contacts }| {
        let lasting = lasting_contacts.iter().map(|point| (lasting.as_str(), classifier.as_str(), point));
        lasting.chain(all_contacts.iter().map(|point| ("all", classifier.as_str(), point)))
    });
    Rows::of(points)
        .column("contacts", |(contacts, ..)| contacts)
        .column("classifier", |(_, classifier, _)| classifier)
        .column("max samples", |(.., point)| point.samples.map_or("all".into(), Cell::Count))
        .percent("accuracy / %", 1, |(.., point)| point.accuracy)
        .percent("from", 1, |(.., point)| point.interval_by_reach.map(|interval| interval.low))
        .percent("to", 1, |(.., point)| point.interval_by_reach.map(|interval| interval.high))
        .percent("balanced / %", 1, |(.., point)| point.balanced_accuracy)
        .percent("majority / %", 1, |(.., point)| point.majority_baseline)
        .column("trials lasting so long", |(.., point)| point.lasting)
        .percent("accuracy on these / %", 1, |(.., point)| point.accuracy_of_lasting)
        .percent("balanced on these / %", 1, |(.., point)| point.balanced_accuracy_of_lasting)
        .percent("majority on these / %", 1, |(.., point)| point.majority_baseline_of_lasting)
        .table("accuracy_by_samples", "Accuracy by samples since contact")
}
