//! Verdicts over time: Figs. 8, 9, 10 and 15.

use crate::drawing::{Axis, Chart, Dash, Layer, Shape, Style};
use underbrush_classifier::evaluate::StreamFrame;

use underbrush_recording::FRAME_PERIOD_S;

use super::{AUTHORS_STYLE, CORRECT, INK, LEAF, OUTLIER, TRUNK, UNCERTAIN, UNTOUCHED, WRONG};
use underbrush_experiments::online::{Classified, Online};
use underbrush_experiments::results::Results;

/// A level line over the whole time of a reach.
fn level(name: &str, value: f64, reach: &Classified) -> Layer {
    let ends = [reach.stream.frames.first(), reach.stream.frames.last()];
    let points = ends.into_iter().flatten().map(|frame| (frame.time_s, value)).collect();
    Layer::new(name, Style::line(INK, Dash::Dotted), Shape::Line(points))
}

/// Computation time per 100 taxels in contact.
pub fn figure_8(reach: &Classified, results: &Results) -> String {
    let paper_s = results.timing.figure_8_paper_seconds_per_100_taxels;
    let points = reach
        .stream
        .frames
        .iter()
        .zip(&reach.stream.seconds)
        .map(|(frame, seconds)| {
            let per_100 = 100.0 * seconds / frame.in_contact as f64;
            (frame.time_s, if frame.in_contact > 0 { per_100 } else { f64::NAN })
        });
    let mean = results.timing.figure_8_seconds_per_100_taxels.unwrap_or(f64::NAN);
    let chart = Chart {
        name: "figure-8".into(),
        title: "Computation time per 100 taxels".into(),
        description: format!(
            "Mean {mean:.2e} s for a new sample of 100 taxels in contact; the paper's mean is {paper_s} s."
        ),
        x: Axis::from_zero("time / s"),
        y: Axis::logarithmic("time per 100 taxels / s"),
        layers: vec![
            Layer::new(
                "here",
                Style::line(AUTHORS_STYLE.colour, Dash::Solid),
                Shape::Line(points.collect()),
            ),
            level("paper's mean, 0.83 s", paper_s, reach),
        ],
    };
    chart.svg()
}

/// Samples used.
pub fn figure_9(reach: &Classified, results: &Results) -> String {
    let points = reach.stream.frames.iter().map(|frame| {
        let used = if frame.in_contact > 0 {
            frame.mean_samples_used
        } else {
            f64::NAN
        };
        (frame.time_s, used)
    });
    let mean = results.figure_9.mean_samples_used.unwrap_or(f64::NAN);
    let chart = Chart {
        name: "figure-9".into(),
        title: "Samples used for a verdict".into(),
        description: format!(
            "Mean over the taxels in contact; over the reach {mean:.1}, in the paper {}.",
            results.figure_9.paper
        ),
        x: Axis::from_zero("time / s"),
        y: Axis::from_zero("samples"),
        layers: vec![
            Layer::new(
                "here",
                Style::line(AUTHORS_STYLE.colour, Dash::Solid),
                Shape::Steps(points.collect()),
            ),
            level("paper's mean, 11.9", results.figure_9.paper, reach),
        ],
    };
    chart.svg()
}

/// Correct, misclassified and uncertain taxels over time, and those that nothing presses on, all on one scale.
pub fn figure_10(reach: &Classified) -> Vec<String> {
    type Of = fn(&underbrush_classifier::evaluate::Tally) -> usize;
    let kinds: [(&str, Style, Of); 4] = [
        ("correct", Style::line(CORRECT, Dash::Solid), |tally| tally.correct),
        ("misclassified", Style::line(WRONG, Dash::Solid), |tally| {
            tally.misclassified
        }),
        ("uncertain", Style::line(UNCERTAIN, Dash::Solid), |tally| {
            tally.uncertain
        }),
        (
            "that nothing presses on",
            Style::line(UNTOUCHED, Dash::Solid),
            |tally| tally.unknown,
        ),
    ];
    let frames = &reach.stream.frames;
    let highest = kinds
        .iter()
        .flat_map(|kind| frames.iter().map(|frame| kind.2(&frame.tally)))
        .max()
        .unwrap_or(1);
    let chart = |(name, style, of): (&str, Style, Of)| {
        let points: Vec<(f64, f64)> = frames
            .iter()
            .map(|frame| (frame.time_s, of(&frame.tally) as f64))
            .collect();
        let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
        let mean = points.iter().map(|point| point.1).sum::<f64>() / points.len().max(1) as f64;
        let chart = Chart {
            name: format!("figure-10-{}", name.replace(' ', "-")),
            title: format!("Taxels {name}"),
            description: format!("Over the reach {mean:.1} taxels on average, at most {most}."),
            x: Axis::from_zero("time / s"),
            y: Axis::spanning("taxels", 0.0, highest.max(1) as f64),
            layers: vec![Layer::new("", style, Shape::Steps(points))],
        };
        chart.svg()
    };
    kinds.map(chart).to_vec()
}

/// Verdicts over time in the outlier reaches, with what the forearm truly touches under them.
pub fn figure_15(online: &Online) -> Vec<String> {
    online.outlier.iter().map(outlier_reach).collect()
}

/// Length of the pieces of time over which Fig. 15 averages, s. A choice: verdicts change from frame to frame, and a
/// minute at 100 Hz has more frames than a chart has columns.
const PIECE_S: f64 = 0.5;
/// The blue of uncertain taxels, made light: an area beside others that are as dark.
const UNCERTAIN_AREA: &str = "#9cc2f0";

fn outlier_reach(reach: &Classified) -> String {
    let frames = &reach.stream.frames;
    let piece = |frame: &StreamFrame| (frame.time_s / PIECE_S).floor();
    let mut description = format!("Mean number of taxels by verdict over pieces of {PIECE_S} s; over the reach:");
    let mut layers = Vec::new();
    for (name, style) in [
        ("outlier", Style::line(OUTLIER, Dash::Solid)),
        ("trunk", Style::line(TRUNK, Dash::Dashed)),
        ("leaf", Style::line(LEAF, Dash::Dotted)),
        ("uncertain", Style::line(UNCERTAIN_AREA, Dash::Solid)),
    ] {
        let Some(column) = reach.stream.verdicts.iter().position(|verdict| verdict == name) else {
            continue;
        };
        let mean = |frames: &[StreamFrame]| {
            let sum: usize = frames.iter().map(|frame| frame.by_verdict[column]).sum();
            sum as f64 / frames.len() as f64
        };
        let pieces = frames.chunk_by(|a, b| piece(a) == piece(b));
        let mut points: Vec<(f64, f64)> = pieces.map(|frames| (frames[0].time_s, mean(frames))).collect();
        // The last piece ends with the reach.
        points.extend(
            frames
                .last()
                .zip(points.last().copied())
                .map(|(end, last)| (end.time_s, last.1)),
        );
        description += &format!(" {name} {:.2},", mean(frames));
        layers.push(Layer::new(name, style, Shape::Areas(points)));
    }
    let untouched = |frames: &[StreamFrame]| {
        let sum: usize = frames.iter().map(|frame| frame.tally.unknown).sum();
        sum as f64 / frames.len() as f64
    };
    let pieces = frames.chunk_by(|a, b| piece(a) == piece(b));
    let points = pieces.map(|frames| (frames[0].time_s, untouched(frames))).collect();
    description += &format!(" without truth {:.2}", untouched(frames));
    layers.push(Layer::new(
        "nothing presses",
        Style::line(INK, Dash::Dotted),
        Shape::Steps(points),
    ));
    description = format!(
        "{}. Truly touched in a share of the time:",
        description.trim_end_matches(',')
    );
    for (name, place, style) in [
        ("roll", 3, Style::line(OUTLIER, Dash::Solid)),
        ("trunk", 1, Style::line(TRUNK, Dash::Dashed)),
        ("leaf", 0, Style::line(LEAF, Dash::Dotted)),
    ] {
        let runs = frames.chunk_by(|a, b| a.touched[place] == b.touched[place]);
        let touching = runs.filter(|run| run[0].touched[place]);
        let ends = |run: &[StreamFrame]| (run[0].time_s, run[run.len() - 1].time_s + FRAME_PERIOD_S);
        let share = frames.iter().filter(|frame| frame.touched[place]).count() as f64 / frames.len() as f64;
        description += &format!(" {name} {:.0} %,", 100.0 * share);
        layers.push(Layer::new(name, style, Shape::Bands(touching.map(ends).collect())));
    }
    let chart = Chart {
        name: format!("figure-15-{}", reach.reach_index),
        title: format!("Outlier reach, draw {}", reach.reach_index),
        description: format!("{}.", description.trim_end_matches(',')),
        x: Axis::from_zero("time / s"),
        y: Axis::from_zero("taxels"),
        layers,
    };
    chart.svg()
}
