//! Verdicts over time: Figs. 8, 9, 10 and 15.

use underbrush_classifier::report::{Axis, Chart, Dash, Layer, Shape, Style};

use super::super::online::{Classified, Online};
use super::super::results::Results;
use super::{AUTHORS_STYLE, CORRECT, INK, LEAF, OUTLIER, TRUNK, UNCERTAIN, WRONG};

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

/// Correct, misclassified and uncertain taxels over time, all three on one scale.
pub fn figure_10(reach: &Classified) -> Vec<String> {
    type Of = fn(&underbrush_classifier::evaluate::Tally) -> usize;
    let kinds: [(&str, Style, Of); 3] = [
        ("correct", Style::line(CORRECT, Dash::Solid), |tally| tally.correct),
        ("misclassified", Style::line(WRONG, Dash::Solid), |tally| {
            tally.misclassified
        }),
        ("uncertain", Style::line(UNCERTAIN, Dash::Solid), |tally| {
            tally.uncertain
        }),
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
            name: format!("figure-10-{name}"),
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

/// Verdicts over time in the outlier reaches, with what the forearm truly touches behind them.
pub fn figure_15(online: &Online) -> Vec<String> {
    online.outlier.iter().map(outlier_reach).collect()
}

fn outlier_reach(reach: &Classified) -> String {
    let stream = &reach.stream;
    let bands = |place: usize| {
        let mut bands: Vec<(f64, f64)> = Vec::new();
        let mut open = None;
        for frame in &stream.frames {
            match (frame.touched[place], open) {
                (true, None) => open = Some(frame.time_s),
                (false, Some(start)) => {
                    bands.push((start, frame.time_s));
                    open = None;
                }
                _ => {}
            }
        }
        bands.extend(open.zip(stream.frames.last()).map(|(start, last)| (start, last.time_s)));
        Shape::Bands(bands)
    };
    let mut layers = vec![
        Layer::new("touches the roll", Style::line(OUTLIER, Dash::Solid), bands(3)),
        Layer::new("a leaf", Style::line(LEAF, Dash::Dashed), bands(0)),
        Layer::new("a trunk", Style::line(TRUNK, Dash::Dotted), bands(1)),
    ];
    let mut description = String::from("Taxels by verdict over time; taxels times frames in all:");
    for (name, style) in [
        ("leaf", Style::line(LEAF, Dash::Solid)),
        ("trunk", Style::line(TRUNK, Dash::Dashed)),
        ("uncertain", Style::line(UNCERTAIN, Dash::Dotted)),
        ("outlier", Style::line(OUTLIER, Dash::Solid)),
    ] {
        let Some(column) = stream.verdicts.iter().position(|verdict| verdict == name) else {
            continue;
        };
        let points: Vec<(f64, f64)> = stream
            .frames
            .iter()
            .map(|frame| (frame.time_s, frame.by_verdict[column] as f64))
            .collect();
        description += &format!(" {name} {},", points.iter().map(|point| point.1).sum::<f64>());
        layers.push(Layer::new(format!("verdict {name}"), style, Shape::Steps(points)));
    }
    let chart = Chart {
        name: format!("figure-15-{}", reach.reach_index),
        title: format!("Outlier reach, draw {}", reach.reach_index),
        description: description.trim_end_matches(',').to_owned(),
        x: Axis::from_zero("time / s"),
        y: Axis::from_zero("taxels"),
        layers,
    };
    chart.svg()
}
