//! What touches each taxel, frame by frame: accuracy, calibration, and outliers found.

use underbrush_classifier::evaluate::touch::CalibrationBin;
use underbrush_classifier::evaluate::{UnknownFigures, share};
use underbrush_experiments::experiment::verdicts::{VerdictFigures, Verdicts};

use crate::style::FIRST;
use crate::{Cell, Layer, Point, Report, Rows, Shape, Table, joined, square_chart};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &VerdictFigures) {
    let Some(verdicts) = &outcome.verdicts else { return };
    report.section("verdicts", "verdicts on every taxel, frame by frame");
    report.page.paragraph(&format!(
        "Small networks see the course of each contact region: its forces, its size, and how far its object gave way. They tell \
         whether anything presses on a taxel, and what. {} reaches of the training scenes and of a mixed scene are divided into \
         three parts, and each part is judged by networks fitted to the other two. The truth is what presses on the taxel, not \
         the scene's label.",
        verdicts.training_reaches
    ));
    report.page.paragraph(&accuracy(verdicts));
    if verdicts.outlier.is_none() {
        report.page.paragraph(
            "Figures on unknown objects are left out: they need auxiliary unknown objects in training, and an outlier to test on.",
        );
    }
    report.printed(figures(verdicts), 3);
    if !verdicts.scenes.is_empty() {
        report.printed(scenes(verdicts), usize::MAX);
    }
    let caption = "How often the likeliest class was true, against its probability; on the dotted line probabilities mean what \
                   they say.";
    report.page.figure(caption, &[calibration_chart(&verdicts.held_out.calibration)]);
    report.numbers(calibration_table(&verdicts.held_out.calibration));
}

fn accuracy(verdicts: &Verdicts) -> String {
    let percent = |share: Option<f64>| share.map_or("–".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let (contacts, categories) = (verdicts.contacts, verdicts.categories.len());
    let (whole, largest) = (percent(verdicts.touched_balanced_accuracy), percent(verdicts.largest_category_share));
    let early = percent(verdicts.first_tenth_second_balanced_accuracy);
    format!(
        "Of {contacts} contacts of taxels that a known category truly touched, {whole} are right by the likeliest category over the \
         whole contact and {early} by its first tenth of a second (means over the categories; naming the most frequent category \
         alone would be right for {largest} of the contacts, and for one category in {categories} on average)."
    )
}

/// One figure per row, with what it counts.
fn figures(verdicts: &Verdicts) -> Table {
    let contacts = "contacts of taxels that a known category touched";
    let spurious = "frames of untouched taxels";
    let touched = "taxel frames that a known category touches";
    let both = "taxel frames of nothing and known categories";
    let (unknown, known) = ("objects of no known category, test reaches", "objects of known categories, test reaches");
    let area = |own: Option<UnknownFigures>| own.and_then(|own| own.roc_area);
    let found = |own: Option<UnknownFigures>| own.and_then(|own| share(own.found_objects, own.unknown_objects));
    let (outlier, second) = (verdicts.outlier, verdicts.second_outlier);
    let false_alarms = outlier.and_then(|own| share(own.false_alarm_objects, own.known_objects));
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let samples = verdicts.median_samples_until_right;
    let rows = [
        ("balanced accuracy, whole contact / %", percent(verdicts.touched_balanced_accuracy), 1, contacts),
        ("balanced accuracy, first 0.1 s / %", percent(verdicts.first_tenth_second_balanced_accuracy), 1, contacts),
        ("right at some time / %", percent(verdicts.ever_right), 1, contacts),
        ("samples until then, median", samples, 0, contacts),
        ("called nothing / %", percent(verdicts.spurious_called_nothing), 1, spurious),
        ("called nothing by mistake / %", percent(verdicts.touches_lost), 1, touched),
        ("expected calibration error", verdicts.expected_calibration_error, 3, both),
        ("Brier score", verdicts.brier_score, 3, both),
        ("outlier, called unknown / %", percent(found(outlier)), 1, unknown),
        ("outlier, ROC area", area(outlier), 3, unknown),
        ("second outlier, called unknown / %", percent(found(second)), 1, unknown),
        ("second outlier, ROC area", area(second), 3, unknown),
        ("known ones called unknown / %", percent(false_alarms), 1, known),
    ];
    Rows::of(rows)
        .column("figure", |(name, ..)| name)
        .column("held-out reaches", |(_, value, decimals, _)| Cell::optional(value, decimals))
        .column("of", |(.., of)| of)
        .table("verdicts", "Verdicts on held-out reaches")
}

fn scenes(verdicts: &Verdicts) -> Table {
    Rows::of(&verdicts.scenes)
        .column("scene", |scene| scene.scene.as_str())
        .percent("right / %", 1, |scene| scene.right)
        .percent("wrong / %", 1, |scene| scene.wrong)
        .percent("uncertain / %", 1, |scene| scene.uncertain)
        .column("taxel frames", |scene| scene.taxel_frames)
        .table("verdicts_by_scene", "Verdicts on taxels that known categories touch, in the test reaches")
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
    use super::*;

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
