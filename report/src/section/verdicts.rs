//! What touches each taxel, frame by frame: accuracy, calibration, and outliers found.

use underbrush_classifier::evaluate::touch::CalibrationBin;
use underbrush_classifier::evaluate::{FALSE_ALARMS, RocCurve, RocPoint};
use underbrush_experiments::experiment::verdicts::{Outcome, Verdicts};

use crate::drawing::{Axis, Cell, Chart, Dash, Layer, Shape, Style, Table};
use crate::report::Report;
use crate::style::{FIRST, INK, OUTLIER};

/// A point of a curve is drawn if it is at least this far from the previous one, as a share of either axis.
const APART: f64 = 0.005;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let Some(verdicts) = &outcome.verdicts else {
        return;
    };
    report.section("verdicts", "verdicts on every taxel, frame by frame");
    report.page.paragraph(&format!(
        "Small networks see the course of each contact region: its forces, its size, and how far its object gave way. They tell \
         whether anything presses on a taxel, and what. {} reaches of the training scenes and of a mixed scene are divided into \
         three parts, and each part is judged by networks fitted to the other two. The truth is what presses on the taxel, not \
         the scene's label.",
        verdicts.training_reaches
    ));
    report.page.paragraph(&accuracy(verdicts));
    let table = figures(verdicts);
    report.print(&table, 3);
    report.table(table);
    if !verdicts.scenes.is_empty() {
        let table = scenes(verdicts);
        report.print(&table, table.columns.len());
        report.table(table);
    }
    let mut charts = vec![calibration_chart(&verdicts.held_out.calibration)];
    charts.extend(roc_chart(verdicts));
    let caption = "First chart: how often the likeliest class was true, against its probability; on the dotted line \
                   probabilities mean what they say. Second chart: contacts with unknown objects found against contacts with \
                   known ones mistaken for them, by taxel frames.";
    report.page.figure(caption, &charts);
    report.page.paragraph(
        "What a feature is worth is how much worse the probabilities are if its values are shuffled among the rows of held-out \
         reaches. A feature that others can stand in for is worth little by this measure.",
    );
    report.table(feature_worth(verdicts));
    report.numbers(calibration_table(&verdicts.held_out.calibration));
    report.numbers(roc_table(verdicts));
}

fn accuracy(verdicts: &Verdicts) -> String {
    let percent = |share: Option<f64>| share.map_or("–".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    format!(
        "Of {} contacts of taxels that a known category truly touched, {} are right by the likeliest category over the whole \
         contact and {} by its first tenth of a second (means over the categories; naming the most frequent category alone would \
         be right for {} of the contacts, and for one category in {} on average).",
        verdicts.contacts,
        percent(verdicts.touched_balanced_accuracy),
        percent(verdicts.first_tenth_second_balanced_accuracy),
        percent(verdicts.largest_category_share),
        verdicts.categories.len()
    )
}

/// One figure per row, with what it counts.
fn figures(verdicts: &Verdicts) -> Table {
    let columns = ["figure", "held-out reaches", "of"];
    let mut table = Table::new("verdicts", "Verdicts on held-out reaches", &columns);
    let mut add = |name: &str, value: Option<f64>, decimals: usize, of: &str| {
        table.rows.push(vec![name.into(), Cell::optional(value, decimals), of.into()]);
    };
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let outlier = &verdicts.outlier;
    let contacts = "contacts of taxels that a known category touched";
    add("balanced accuracy, whole contact / %", percent(verdicts.touched_balanced_accuracy), 1, contacts);
    add("balanced accuracy, first 0.1 s / %", percent(verdicts.first_tenth_second_balanced_accuracy), 1, contacts);
    add("right at some time / %", percent(verdicts.ever_right), 1, contacts);
    add("samples until then, median", verdicts.median_samples_until_right.map(|samples| samples as f64), 0, contacts);
    add("called nothing / %", percent(verdicts.spurious_called_nothing), 1, "taxel frames that nothing presses on");
    add(
        "called nothing by mistake / %",
        percent(verdicts.touches_lost),
        1,
        "taxel frames that a known category touches",
    );
    let both = "taxel frames of nothing and known categories";
    add("expected calibration error", verdicts.expected_calibration_error, 3, both);
    add("Brier score", verdicts.brier_score, 3, both);
    let frames = "taxel frames of test reaches";
    add("outlier, ROC area", outlier.outlier_roc_area, 3, frames);
    let found = format!("outlier, found at {:.0} % false alarms / %", 100.0 * FALSE_ALARMS);
    add(&found, percent(outlier.outliers_found), 1, frames);
    add("second outlier, ROC area", outlier.second_outlier_roc_area, 3, frames);
    add(&format!("second {found}"), percent(outlier.second_outliers_found), 1, frames);
    table
}

/// What each feature is worth.
fn feature_worth(verdicts: &Verdicts) -> Table {
    let columns = ["network", "feature", "rise of log loss / nats", "fall of balanced accuracy / %"];
    let mut table = Table::new("verdict_features", "What each feature is worth", &columns);
    for own in &verdicts.feature_worth {
        table.rows.push(vec![
            own.network.into(),
            own.feature.into(),
            Cell::optional(Some(own.log_loss_rise_nats), 4),
            Cell::optional(Some(100.0 * own.balanced_accuracy_fall), 2),
        ]);
    }
    table
}

fn scenes(verdicts: &Verdicts) -> Table {
    let columns = ["scene", "right / %", "wrong / %", "uncertain / %", "taxel frames"];
    let caption = "Verdicts on taxels that known categories touch, in the test reaches";
    let mut table = Table::new("verdicts_by_scene", caption, &columns);
    for scene in &verdicts.scenes {
        table.rows.push(vec![
            scene.scene.as_str().into(),
            Cell::Number(100.0 * scene.right, 1),
            Cell::Number(100.0 * scene.wrong, 1),
            Cell::Number(100.0 * scene.uncertain, 1),
            scene.taxel_frames.into(),
        ]);
    }
    table
}

/// Mean probability of the likeliest class in a bin, and how often it was true, in per cent.
fn rates(bin: &CalibrationBin) -> Option<(f64, f64)> {
    let percent = |sum: f64| 100.0 * sum / bin.count as f64;
    (bin.count > 0).then(|| (percent(bin.probability), percent(bin.true_count as f64)))
}

fn calibration_chart(bins: &[CalibrationBin]) -> String {
    let points: Vec<(f64, f64)> = bins.iter().filter_map(rates).collect();
    let told: Vec<String> = points.iter().map(|(said, found)| format!("{said:.0}: {found:.0}")).collect();
    let chart = Chart {
        name: "verdict-calibration".into(),
        title: "Do probabilities mean what they say?".into(),
        description: format!("Per cent true by probability in per cent. {}.", told.join(", ")),
        x: Axis::spanning("probability of the likeliest class / %", 0.0, 100.0),
        y: Axis::spanning("it is true / %", 0.0, 100.0),
        layers: vec![
            Layer::new(
                "as it should be",
                Style::line(INK, Dash::Dotted),
                Shape::Line(vec![(0.0, 0.0), (100.0, 100.0)]),
            ),
            Layer::new("held-out reaches", FIRST, Shape::Line(points)),
        ],
    };
    chart.svg()
}

fn calibration_table(bins: &[CalibrationBin]) -> Table {
    let columns = ["probability_percent", "true_percent", "taxel_frames"];
    let mut table = Table::new("verdict_calibration", "Calibration of the verdicts", &columns);
    for bin in bins {
        if let Some((said, found)) = rates(bin) {
            table.rows.push(vec![Cell::Number(said, 2), Cell::Number(found, 2), bin.count.into()]);
        }
    }
    table
}

/// The curves of both outliers, by name.
fn curves(verdicts: &Verdicts) -> impl Iterator<Item = (&'static str, &RocCurve)> {
    let named = ["outlier", "second outlier"].into_iter().zip(&verdicts.curves);
    named.filter_map(|(name, curve)| Some((name, curve.as_ref()?)))
}

/// The points of a curve that are at least `APART` from each other, and its ends.
fn drawn(curve: &RocCurve) -> Vec<RocPoint> {
    let mut drawn: Vec<RocPoint> = Vec::new();
    let last = curve.points.len().saturating_sub(1);
    for (index, point) in curve.points.iter().enumerate() {
        let is_apart = drawn.last().is_none_or(|before| {
            point.false_positive_rate - before.false_positive_rate >= APART
                || point.true_positive_rate - before.true_positive_rate >= APART
        });
        if is_apart || index == last {
            drawn.push(*point);
        }
    }
    drawn
}

fn roc_chart(verdicts: &Verdicts) -> Option<String> {
    let mut layers =
        vec![Layer::new("chance", Style::line(INK, Dash::Dotted), Shape::Line(vec![(0.0, 0.0), (100.0, 100.0)]))];
    let mut told = Vec::new();
    for ((name, curve), dash) in curves(verdicts).zip([Dash::Solid, Dash::Dashed]) {
        let point = |point: &RocPoint| (100.0 * point.false_positive_rate, 100.0 * point.true_positive_rate);
        let points = drawn(curve).iter().map(point).collect();
        told.push(format!("{name}: area under the curve {:.3}", curve.area));
        let label = format!("{name}, area {:.3}", curve.area);
        layers.push(Layer::new(label, Style::line(OUTLIER, dash), Shape::Line(points)));
    }
    (layers.len() > 1).then(|| {
        let chart = Chart {
            name: "verdict-roc".into(),
            title: "Unknown objects against known categories".into(),
            description: format!("{}; 0.5 is chance.", told.join("; ")),
            x: Axis::spanning("known ones taken for unknown / %", 0.0, 100.0),
            y: Axis::spanning("unknown ones found / %", 0.0, 100.0),
            layers,
        };
        chart.svg()
    })
}

fn roc_table(verdicts: &Verdicts) -> Table {
    let columns = ["curve", "distance", "false_positive_rate", "true_positive_rate"];
    let mut table = Table::new("verdict_roc", "Unknown objects against known categories", &columns);
    for (name, curve) in curves(verdicts) {
        for point in drawn(curve) {
            table.rows.push(vec![
                name.into(),
                Cell::optional(point.threshold, 3),
                Cell::Number(point.false_positive_rate, 4),
                Cell::Number(point.true_positive_rate, 4),
            ]);
        }
    }
    table
}
