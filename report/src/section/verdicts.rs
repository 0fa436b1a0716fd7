//! What touches the skin: verdicts on objects and unknown objects found, then contacts of taxels, frames and calibration.

use underbrush_classifier::evaluate::touch::CalibrationBin;
use underbrush_classifier::evaluate::{Interval, ObjectVerdicts, UnknownFigures, share};
use underbrush_experiments::experiment::verdicts::{VerdictFigures, Verdicts};

use crate::style::FIRST;
use crate::{Cell, Layer, Point, Report, Rows, Shape, Table, joined, square_chart};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &VerdictFigures) {
    let Some(verdicts) = &outcome.verdicts else { return };
    report.section("verdicts", "verdicts on objects, contacts and taxels");
    report.page.paragraph(&format!(
        "A touch model sees the course of each contact: its forces, its size, and how far its object gave way. Contacts that begin \
         near each other count as one object. {} reaches of the training scenes and of a mixed scene are divided into three parts, \
         and each part is held out and judged by a model of the other two. The test reaches are judged by a model of all of them. \
         The truth is what presses, not the scene's label.",
        verdicts.training_reaches
    ));
    let objects = objects(verdicts);
    if !objects.rows.is_empty() {
        report.page.paragraph(&format!(
            "Balanced is the mean over the categories, of which always naming one has {:.0} %. Wrong is another category or unknown. \
             Intervals are 95 %, from resampling whole reaches.",
            100.0 / verdicts.categories.len() as f64
        ));
        report.printed(objects, usize::MAX);
    }
    let unknown = unknown(verdicts);
    report.terminal.extend(unknown.iter().map(|line| format!("{line}\n\n")));
    report.page.paragraph(unknown.as_deref().unwrap_or(
        "Figures on unknown objects are left out: they need auxiliary unknown objects in training, and an outlier to test on.",
    ));
    report.printed(figures(verdicts), 3);
    let caption = "How often the likeliest class was true, against its probability; on the dotted line probabilities mean what \
                   they say.";
    report.page.figure(caption, &[calibration_chart(&verdicts.held_out.calibration)]);
    report.numbers(calibration_table(&verdicts.held_out.calibration));
}

/// A share and its interval.
type ShareOf = fn(&ObjectVerdicts) -> (f64, Option<Interval>);

/// Known objects at each moment, in held-out reaches and in test reaches.
fn objects(verdicts: &Verdicts) -> Table {
    let sets = [("held-out", &verdicts.held_out_objects), ("test", &verdicts.test_objects)];
    let rows = sets.into_iter().flat_map(|(set, objects)| objects.iter().map(move |own| (set, own)));
    let mut rows = Rows::of(rows)
        .column("reaches", |(set, _)| set)
        .column("at", |(_, own)| own.at)
        .column("objects", |(_, own)| own.objects);
    let shares: [(&str, ShareOf); 3] = [
        ("right, balanced / %", |own| (own.balanced_right, own.right_interval)),
        ("wrong / %", |own| (own.wrong, own.wrong_interval)),
        ("uncertain / %", |own| (own.uncertain, own.uncertain_interval)),
    ];
    for (heading, of) in shares {
        rows = rows
            .percent(heading, 1, |(_, own)| of(own).0)
            .percent("from", 1, |(_, own)| of(own).1.map(|interval| interval.low))
            .percent("to", 1, |(_, own)| of(own).1.map(|interval| interval.high));
    }
    let caption = "Verdicts on objects of known categories, 0.1 and 0.3 s after the first touch, at the peak of force and at \
                   the end";
    rows.table("verdicts_on_objects", caption)
}

/// Unknown objects found and known ones called unknown, by object and by contact.
fn unknown(verdicts: &Verdicts) -> Option<String> {
    let own = verdicts.unknown?;
    let part = |part: usize, all: usize, interval: Option<Interval>| {
        let percent = share(part, all).map_or("–".into(), |share| format!("{:.1} %", 100.0 * share));
        let interval = interval.map(|own| format!("; {:.1} to {:.1}", 100.0 * own.low, 100.0 * own.high));
        format!("{percent} ({part} of {all}{})", interval.unwrap_or_default())
    };
    let of_outlier = |name: &str, own: Option<UnknownFigures>| {
        own.map(|own| format!("{} of {} of the {name}", own.found_objects, own.unknown_objects))
    };
    let outliers = [of_outlier("outlier", verdicts.outlier), of_outlier("second outlier", verdicts.second_outlier)];
    Some(format!(
        "Unknown objects found at their end: {}, {}; by contact {}. Known objects called unknown: {}; by contact {}. Area under the \
         ROC curve {}.",
        part(own.found_objects, own.unknown_objects, own.found_interval),
        joined(outliers.into_iter().flatten(), ", "),
        part(own.found_contacts, own.unknown_contacts, own.found_contacts_interval),
        part(own.false_alarm_objects, own.known_objects, own.false_alarm_interval),
        part(own.false_alarm_contacts, own.known_contacts, own.false_alarm_contacts_interval),
        Cell::optional(own.roc_area, 3).text()
    ))
}

/// Contacts of taxels and taxel frames: one figure per row, with what it counts.
fn figures(verdicts: &Verdicts) -> Table {
    let contacts = format!("{} contacts of taxels that a known category touched", verdicts.contacts);
    let contacts = contacts.as_str();
    let spurious = "frames of untouched taxels";
    let touched = "taxel frames that a known category touches";
    let both = "taxel frames of nothing and known categories";
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let rows = [
        ("balanced accuracy, whole contact / %", percent(verdicts.touched_balanced_accuracy), 1, contacts),
        ("majority baseline / %", percent(verdicts.largest_category_share), 1, contacts),
        ("right verdict at the end / %", percent(verdicts.right_verdict_at_end), 1, contacts),
        ("called nothing / %", percent(verdicts.spurious_called_nothing), 1, spurious),
        ("called nothing by mistake / %", percent(verdicts.touches_lost), 1, touched),
        ("expected calibration error", verdicts.expected_calibration_error, 3, both),
        ("Brier score", verdicts.brier_score, 3, both),
    ];
    Rows::of(rows)
        .column("figure", |(name, ..)| name)
        .column("held-out reaches", |(_, value, decimals, _)| Cell::optional(value, decimals))
        .column("of", |(.., of)| of)
        .table("verdicts", "Contacts of taxels and taxel frames in held-out reaches")
}

/// Mean probability of the likeliest class in a bin, and how often it was true, in per cent.
fn rates(bin: &CalibrationBin) -> Option<(f64, f64)> {
    let percent = |sum: f64| 100.0 * sum / bin.count as f64;
    (bin.count > 0).then(|| (percent(bin.probability), percent(bin.true_count as f64)))
}

fn calibration_chart(bins: &[CalibrationBin]) -> String {
    let rates = bins.iter().filter_map(rates);
    let points: Vec<Point> = rates.map(|(said, found)| Point { x: said, y: found, interval: None }).collect();
    let told = joined(points.iter().map(|Point { x, y, .. }| format!("{x:.0}: {y:.0}")), ", ");
    let description = format!("Per cent true by probability in per cent. {told}.");
    let axes = ("probability of the likeliest class / %", "it is true / %");
    let layers = vec![Layer::new("held-out reaches", FIRST, Shape::Points(points))];
    let names = ("verdict-calibration", "Do probabilities mean what they say?");
    square_chart(names, description, axes, "as it should be", layers)
}

fn calibration_table(bins: &[CalibrationBin]) -> Table {
    Rows::of(bins.iter().filter_map(|bin| Some((rates(bin)?, bin.count))))
        .number("probability_percent", 2, |((said, _), _)| said)
        .number("true_percent", 2, |((_, found), _)| found)
        .column("taxel_frames", |(_, count)| count)
        .table("verdict_calibration", "Calibration of the verdicts")
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::evaluate::touch::TouchEvaluation;

    use super::*;

    fn interval(low: f64, high: f64) -> Option<Interval> {
        Some(Interval { low, high })
    }

    fn verdicts() -> Verdicts {
        let at = |at, objects, balanced_right| ObjectVerdicts {
            at,
            objects,
            balanced_right,
            right_interval: interval(0.7, 0.9),
            right: 0.8,
            named: 0.95,
            wrong: 0.15,
            wrong_interval: interval(0.1, 0.2),
            uncertain: 0.05,
            uncertain_interval: None,
            called_unknown: 0.0,
        };
        let outlier = UnknownFigures {
            unknown_objects: 4,
            found_objects: 3,
            found_interval: interval(0.5, 1.0),
            known_objects: 40,
            false_alarm_objects: 2,
            false_alarm_interval: interval(0.0, 0.1),
            unknown_contacts: 10,
            found_contacts: 5,
            found_contacts_interval: interval(0.25, 0.75),
            known_contacts: 200,
            roc_area: Some(0.875),
            ..UnknownFigures::default()
        };
        Verdicts {
            held_out_objects: vec![at("0.1 s", 30, 0.75), at("end", 32, 0.825)],
            test_objects: vec![at("end", 9, 0.5)],
            unknown: Some(outlier),
            outlier: Some(outlier),
            second_outlier: None,
            touched_balanced_accuracy: Some(0.9),
            contacts: 300,
            largest_category_share: Some(0.7),
            right_verdict_at_end: None,
            spurious_called_nothing: None,
            touches_lost: None,
            expected_calibration_error: None,
            brier_score: None,
            training_reaches: 12,
            held_out: TouchEvaluation::default(),
            categories: vec!["leaf".into(), "trunk".into()],
        }
    }

    /// Tests that each figure on objects has its interval beside it, and that unknown objects take one line.
    #[test]
    fn objects_have_intervals() {
        let table = objects(&verdicts());
        let row = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(table.texts()[1], row("held-out end 32 82.5 70.0 90.0 15.0 10.0 20.0 5.0 – –"));
        assert_eq!(table.rows.len(), 3);
        let columns = table.with_own_headings().columns;
        assert!(columns[3..6] == ["right, balanced / %", "right, balanced / %: from", "right, balanced / %: to"]);
        let expected = "Unknown objects found at their end: 75.0 % (3 of 4; 50.0 to 100.0), 3 of 4 of the outlier; by contact 50.0 % (5 \
                        of 10; 25.0 to 75.0). Known objects called unknown: 5.0 % (2 of 40; 0.0 to 10.0); by contact 0.0 % (0 of 200). \
                        Area under the ROC curve 0.875.";
        assert_eq!(unknown(&verdicts()).unwrap(), expected);
        assert_eq!(unknown(&Verdicts { unknown: None, ..verdicts() }), None);
    }

    /// Tests that the curve has a mark for each bin with frames, as its legend says: the line between two marks is no
    /// measurement.
    #[test]
    fn the_calibration_chart_marks_its_bins() {
        let bins = [(4, 2.0, 1), (0, 0.0, 0), (10, 9.0, 9)].map(|(count, probability, true_count)| CalibrationBin {
            count,
            probability,
            true_count,
        });
        // One more is in the legend.
        assert_eq!(calibration_chart(&bins).matches("<circle").count(), 3);
    }
}
