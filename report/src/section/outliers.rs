//! Outliers: the effect of thresholds on the outlier reaches (Fig. 15).

use std::collections::BTreeSet;

use underbrush_classifier::decision::Rule;
use underbrush_classifier::evaluate::{RocCurve, RocPoint, StreamFrame, ThresholdTargets};
use underbrush_experiments::experiment::outliers::{CHOSEN, Detection, OutlierThresholds};
use underbrush_experiments::frame_verdicts::{Classified, Online};
use underbrush_experiments::online_models::Thresholds;
use underbrush_recording::{Category, FRAME_PERIOD_S};

use crate::style::{CategoryLooks, FIRST, OUTLIER, REFERENCE};
use crate::{
    Axis, Cell, Dash, Layer, Report, Rows, Shape, Style, Table, chart, counted, fitting, joined, replayed, square_chart,
};

/// Share of taxel frames left uncertain above which the page says that a rule fails. Choice: such a rule decides on
/// fewer than one in ten.
const FAILING_UNCERTAIN_SHARE: f64 = 0.9;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &OutlierThresholds) {
    if report.results.definition.file.outlier.is_none() {
        return;
    }
    report.section("outliers", "outliers");
    report.page.paragraph(&format!(
        "By ground truth, {} of {} drawn {} the outlier first and then a known category.",
        outcome.figure_15.reaches,
        counted(outcome.figure_15.drawn, "reach", "reaches"),
        fitting(outcome.figure_15.reaches, "meets", "meet")
    ));
    let labels = report.results.definition.labels();
    let charts: Vec<String> =
        outcome.online.outlier.iter().map(|reach| reach_chart(reach, &labels, &report.looks)).collect();
    if !charts.is_empty() {
        let caption = "Taxels by verdict over time, means of half a second, stacked. The dotted line shows how many of them \
                       nothing presses on (spurious readings, creep, crosstalk). The strips below show when an object of each \
                       category truly touches the patch.";
        report.page.figure(caption, &charts);
        // The replay page begins with the general reach, if there is one.
        let first = usize::from(outcome.online.shown().is_some());
        let links = outcome.online.outlier.iter().enumerate().map(|(place, reach)| {
            (replayed::reach(replayed::TEST_FILE, first + place), format!("draw {}", reach.reach_index))
        });
        report.page.links("Replay these reaches in 3-D", links);
    }
    report.numbers(frames_table(&outcome.online));
    report.page.paragraph(&thresholds(&outcome.curves));
    report.page.paragraphs(chosen_rule_online(&outcome.figure_15.detection));
    if !outcome.figure_15.detection.is_empty() {
        report.printed(detection_table(outcome), usize::MAX);
    }
    let first = labels.first().copied().unwrap_or_default();
    let charts = roc_charts(&outcome.curves, first);
    if !charts.is_empty() {
        report.page.figure("The effect of every threshold.", &charts);
        report.numbers(roc_table(&outcome.curves, first));
    }
}

/// The chosen thresholds and their effect on held-out trials.
fn thresholds(thresholds: &Thresholds) -> String {
    let chosen = match &thresholds.chosen {
        Ok(chosen) => chosen,
        Err(why) => return format!("No thresholds could be chosen from the training data: {why}."),
    };
    let rule = match chosen.decision.rule {
        Rule::OutlierBand { uncertain_below, category_above } => {
            format!("uncertain below a margin of {uncertain_below:.1} nats, a category above {category_above:.1}")
        }
        other => format!("{other:?}"),
    };
    let rates = chosen.false_positive_rate.iter().map(|(category, rate)| {
        let found = chosen.true_positive_rate.get(category).copied().unwrap_or(f64::NAN);
        format!("{category}: {:.1} % of its own trials and {:.1} % of the others", 100.0 * found, 100.0 * rate)
    });
    let (trials, rates) = (chosen.trials, joined(rates, ", "));
    let ThresholdTargets { false_positive_rate, outlier_prior } = chosen.targets;
    let (uncertain, outlier) = (100.0 * chosen.uncertain, 100.0 * chosen.outlier);
    format!(
        "These thresholds were chosen from {trials} training trials held out by reach, for a false-positive rate of \
         {false_positive_rate} and an outlier prior of {outlier_prior}: {rule}. On these trials, each category is given to {rates}; \
         {uncertain:.1} % are uncertain, and {outlier:.1} % are called outliers although none is one."
    )
}

/// How many taxel frames of the outlier reaches the chosen thresholds leave undecided, and whether they fail.
pub fn chosen_rule_online(detection: &[Detection]) -> Option<String> {
    let chosen: Vec<&Detection> = detection.iter().filter(|row| row.rule.starts_with(CHOSEN)).collect();
    let frames: usize = chosen.iter().map(|row| row.taxel_frames).sum();
    if frames == 0 {
        return None;
    }
    let uncertain = chosen.iter().map(|row| row.percent_of("uncertain") * row.taxel_frames as f64);
    let percent = uncertain.sum::<f64>() / frames as f64;
    let failing = ": the rule fails there. Its thresholds are margins of whole trials. A margin grows with every sample, so a \
                   contact that still lasts seldom reaches them.";
    let verdict = if percent > 100.0 * FAILING_UNCERTAIN_SHARE { failing } else { "." };
    Some(format!(
        "Used frame by frame on the outlier reaches, the chosen thresholds leave {percent:.1} % uncertain{verdict}"
    ))
}

/// Length of the time intervals over which the charts average, s. A choice: verdicts change from frame to frame, and a
/// minute at 100 Hz has more frames than a chart has columns.
const INTERVAL_S: f64 = 0.5;
/// A lighter blue for areas of uncertain taxels, because the usual blue is as dark as the areas beside them.
const UNCERTAIN_AREA: &str = "#9cc2f0";

/// Verdicts over time in one reach, with what truly touches the patch below them.
pub fn reach_chart(reach: &Classified, labels: &[&str], looks: &CategoryLooks) -> String {
    let frames = &reach.stream.frames;
    let interval = |frame: &StreamFrame| (frame.time_s / INTERVAL_S).floor();
    // The mean of a number of taxels over the reach, and over each interval.
    let means = |count: &dyn Fn(&StreamFrame) -> usize| -> (f64, Vec<(f64, f64)>) {
        let mean = |frames: &[StreamFrame]| frames.iter().map(count).sum::<usize>() as f64 / frames.len() as f64;
        let intervals = frames.chunk_by(|a, b| interval(a) == interval(b));
        (mean(frames), intervals.map(|frames| (frames[0].time_s, mean(frames))).collect())
    };
    let mut description = format!("Mean number of taxels by verdict over intervals of {INTERVAL_S} s. Over the reach:");
    let mut layers = Vec::new();
    // Outliers at the bottom, then trunks; uncertain taxels on top.
    let mut verdicts: Vec<(usize, &str)> = reach.stream.verdicts.iter().map(String::as_str).enumerate().collect();
    verdicts.sort_by_key(|(_, name)| (*name != "outlier", *name != "trunk", *name == "uncertain"));
    for (column, name) in verdicts {
        let style = match name {
            "uncertain" => Style::line(UNCERTAIN_AREA, Dash::Solid),
            other => area_style(other, looks),
        };
        let (mean, mut points) = means(&|frame| frame.by_verdict[column]);
        // The last interval ends with the reach.
        let end = frames.last().zip(points.last().copied());
        points.extend(end.map(|(end, last)| (end.time_s, last.1)));
        description += &format!(" {name} {mean:.2},");
        layers.push(Layer::new(name, style, Shape::Areas(points)));
    }
    let (untouched, points) = means(&StreamFrame::without_truth);
    description += &format!(" without truth {untouched:.2}");
    layers.push(Layer::new("nothing presses", REFERENCE, Shape::Steps(points)));
    description = format!("{}. Truly touched in this share of the time:", description.trim_end_matches(','));
    for category in strips(reach, labels) {
        let (name, style) = (category.name(), area_style(category.name(), looks));
        let touched = |frame: &StreamFrame| touches(reach, frame, category);
        let runs = frames.chunk_by(|a, b| touched(a) == touched(b));
        let touching = runs.filter(|run| touched(&run[0]));
        let ends = |run: &[StreamFrame]| (run[0].time_s, run[run.len() - 1].time_s + FRAME_PERIOD_S);
        let share = frames.iter().filter(|frame| touched(frame)).count() as f64 / frames.len() as f64;
        description += &format!(" {name} {:.0} %,", 100.0 * share);
        layers.push(Layer::new(name, style, Shape::Bands(touching.map(ends).collect())));
    }
    let draw = reach.reach_index;
    let (name, title) = (format!("figure-15-{draw}"), format!("Outlier reach, draw {draw}"));
    let axes = (Axis::from_zero("time / s"), Axis::from_zero("taxels"));
    chart(name, title, format!("{}.", description.trim_end_matches(',')), axes, layers)
}

/// How an area or a strip is filled, by the name of its verdict or category. Leaves are dotted here, because they are drawn
/// beside filled outliers.
fn area_style(name: &str, looks: &CategoryLooks) -> Style {
    let look = looks.look(name);
    match name {
        "leaf" => Style::line(look.colour, Dash::Dotted),
        _ => look.line(),
    }
}

/// The categories that get a strip: outliers, categories with a label, and all others that the patch touches, except
/// the foam blocks on which objects stand. Outliers come first.
fn strips(reach: &Classified, labels: &[&str]) -> Vec<Category> {
    let shown = |category: &Category| {
        let touched = || reach.stream.frames.iter().any(|frame| touches(reach, frame, *category));
        let named = *category == Category::OUTLIER || labels.contains(&category.name());
        *category != Category::BLOCK && (named || touched())
    };
    let mut strips: Vec<Category> = reach.stream.truths.iter().copied().filter(shown).collect();
    strips.sort_by_key(|category| (*category != Category::OUTLIER, std::cmp::Reverse(*category)));
    strips
}

/// Whether an object of a category truly presses on the patch.
fn touches(reach: &Classified, frame: &StreamFrame, category: Category) -> bool {
    let place = reach.stream.truths.iter().position(|truth| *truth == category);
    place.and_then(|place| frame.touched.get(place)).copied().unwrap_or(false)
}

/// All outlier reaches, frame by frame.
pub fn frames_table(online: &Online) -> Table {
    let verdicts = online.outlier.first().map_or(&[][..], |reach| &reach.stream.verdicts);
    let truths = online.outlier.iter().flat_map(|reach| &reach.stream.truths);
    let truths: BTreeSet<Category> = truths.chain(&Category::BUILT_IN).copied().collect();
    let frames = online.outlier.iter().flat_map(|reach| reach.stream.frames.iter().map(move |frame| (reach, frame)));
    Rows::of(frames)
        .column("reach_index", |(reach, _)| reach.reach_index as usize)
        .number("time_s", 2, |(_, frame)| frame.time_s)
        .columns(verdicts, |(_, frame)| frame.by_verdict.iter().copied())
        .column("without_truth", |(_, frame)| frame.without_truth())
        .columns(truths.iter().map(|truth| format!("touches_{}", truth.name())), |(reach, frame)| {
            truths.iter().map(move |truth| usize::from(touches(reach, frame, *truth)))
        })
        .table("figure_15", "Verdicts in the outlier reaches")
}

fn detection_table(outcome: &OutlierThresholds) -> Table {
    let verdicts = outcome.online.outlier.first().map_or(&[][..], |reach| &reach.stream.verdicts);
    Rows::of(&outcome.figure_15.detection)
        .column("thresholds", |row| row.rule.as_str())
        .column("truth", |row| row.truth)
        .column("taxel frames", |row| row.taxel_frames)
        .columns(verdicts.iter().map(|verdict| format!("{verdict} / %")), |row| {
            verdicts.iter().map(move |verdict| Cell::Number(row.percent_of(verdict), 1))
        })
        .table("outlier_detection", "Verdicts by what truly presses, over all frames of the outlier reaches")
}

/// The curve of the first label against the others, and the curve of outliers against known categories.
fn roc_charts(thresholds: &Thresholds, first: &str) -> Vec<String> {
    let category = thresholds.category_roc.as_ref().map(|curve| {
        let title = format!("{first} against the others, held-out trials");
        (first, title, format!("other trials taken for {first} / %"), FIRST.colour, curve)
    });
    let outlier = thresholds.outlier_roc.as_ref().map(|curve| {
        let x = "trials of known categories taken for outliers / %".to_owned();
        ("outlier", "Outliers against known categories".to_owned(), x, OUTLIER, curve)
    });
    let chart = |(name, title, x, colour, curve): (&str, String, String, _, &RocCurve)| {
        let description = format!("Area under the curve {:.3}; 0.5 is chance.", curve.area);
        let percents = |point: &RocPoint| (100.0 * point.false_positive_rate, 100.0 * point.true_positive_rate);
        let points = curve.points.iter().map(percents).collect();
        let layer =
            Layer::new(format!("area {:.3}", curve.area), Style::line(colour, Dash::Solid), Shape::Line(points));
        let y = format!("{name} trials found / %");
        square_chart((&format!("roc-{name}"), &title), description, (&x, &y), "chance", vec![layer])
    };
    category.into_iter().chain(outlier).map(chart).collect()
}

/// The points of both curves.
fn roc_table(thresholds: &Thresholds, first: &str) -> Table {
    let category = format!("{first} against the others");
    let curves = [(category.as_str(), &thresholds.category_roc), ("outlier", &thresholds.outlier_roc)];
    let points = curves.iter().flat_map(|(name, curve)| curve.iter().map(move |curve| (*name, curve)));
    let points = points.flat_map(|(name, curve)| curve.points.iter().map(move |point| (name, point)));
    Rows::of(points)
        .column("curve", |(curve, _)| curve)
        .number("margin_nats", 2, |(_, point)| point.threshold)
        .number("false_positive_rate", 4, |(_, point)| point.false_positive_rate)
        .number("true_positive_rate", 4, |(_, point)| point.true_positive_rate)
        .table("roc", "Receiver operating characteristics")
}
