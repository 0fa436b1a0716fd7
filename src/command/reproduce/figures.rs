//! The paper's figures from the results, as charts. Colours are told apart by the colour-blind too, and every layer has a
//! mark, dash or hatching of its own beside its colour.

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::report::{Axis, Chart, Dash, Layer, Mark, Point, Scale, Shape, Style};

use super::campaign::{AUTHORS, MODERN};
use super::online::{Classified, Online};
use super::results::{Results, features_name, unit_name};

pub const LEAF: &str = "#1b8a4b";
pub const TRUNK: &str = "#6b4423";
pub const OUTLIER: &str = "#c8102e";
pub const UNCERTAIN: &str = "#1f5fbf";
const CORRECT: &str = "#009e73";
const WRONG: &str = "#d55e00";
const INK: &str = "#222222";

/// States, accuracy in per cent, and its interval.
type Accuracy = (usize, f64, Option<(f64, f64)>);

/// Accuracy of one unit and feature set over the number of states: a quarter of a table.
struct Quarter<'a> {
    name: String,
    title: String,
    /// Name, style and accuracies over states.
    series: Vec<(&'a str, Style, Vec<Accuracy>)>,
}

const STATES: [usize; 3] = [5, 10, 20];
const QUARTERS: [(TableOneUnit, FeatureSet); 4] = [
    (TableOneUnit::Taxel, FeatureSet::Force),
    (TableOneUnit::Taxel, FeatureSet::ForceAndMotion),
    (TableOneUnit::Component, FeatureSet::Force),
    (TableOneUnit::Component, FeatureSet::ForceAndMotion),
];

impl Quarter<'_> {
    fn chart(self) -> String {
        let mut description = format!("Accuracy in per cent over hidden states, {}.", self.title);
        let mut layers = Vec::new();
        for (name, style, cells) in self.series {
            let points: Vec<Point> = cells
                .iter()
                .filter_map(|(states, accuracy, interval)| {
                    let x = STATES.iter().position(|own| own == states)? as f64;
                    Some(Point {
                        x,
                        y: *accuracy,
                        interval: *interval,
                    })
                })
                .collect();
            let values: Vec<String> = cells
                .iter()
                .map(|(states, accuracy, _)| format!("{states}: {accuracy:.1}"))
                .collect();
            description += &format!(" {name}: {}.", values.join(", "));
            layers.push(Layer::new(name, style, Shape::Points(points)));
        }
        let chart = Chart {
            name: self.name,
            title: self.title,
            description,
            x: Axis::names("hidden states", STATES.map(|states| states.to_string())),
            y: Axis::spanning("accuracy / %", 40.0, 100.0),
            layers,
        };
        chart.svg()
    }
}

const PAPER: Style = Style::marked(INK, Dash::Dotted, Mark::Diamond);
const AUTHORS_STYLE: Style = Style::marked("#0072b2", Dash::Solid, Mark::Circle);
const MODERN_STYLE: Style = Style::marked(WRONG, Dash::Dashed, Mark::Square);

/// Table I in four charts.
pub fn table_1(results: &Results) -> Vec<String> {
    let quarter = |(unit, features): (TableOneUnit, FeatureSet)| {
        let cells = |recipe: &str| {
            let own = results
                .table_1
                .iter()
                .filter(|cell| (cell.by, cell.features) == (unit, features) && cell.recipe == recipe);
            own.map(|cell| (cell.states, cell.accuracy, Some((cell.low, cell.high))))
                .collect()
        };
        let own = results
            .table_1
            .iter()
            .filter(|cell| (cell.by, cell.features) == (unit, features));
        let paper = own
            .filter(|cell| cell.recipe == AUTHORS)
            .map(|cell| (cell.states, cell.paper, None))
            .collect();
        Quarter {
            name: format!("table-1-{}-{}", unit_name(unit), features_name(features)),
            title: format!("{}, {}", unit_name(unit), features_name(features)),
            series: vec![
                ("authors' recipe", AUTHORS_STYLE, cells(AUTHORS)),
                ("modern recipe", MODERN_STYLE, cells(MODERN)),
                ("paper", PAPER, paper),
            ],
        }
        .chart()
    };
    QUARTERS.map(quarter).to_vec()
}

/// The mean of several campaigns in four charts, whiskers of one standard deviation.
pub fn campaigns(results: &Results) -> Vec<String> {
    let Some(campaigns) = &results.campaigns else {
        return Vec::new();
    };
    let quarter = |(unit, features): (TableOneUnit, FeatureSet)| {
        let own = || {
            campaigns
                .table_1
                .iter()
                .filter(move |cell| (cell.by, cell.features) == (unit, features))
        };
        let cells = |recipe: &str| {
            own()
                .filter(|cell| cell.recipe == recipe)
                .map(|cell| {
                    let deviation = cell.standard_deviation.unwrap_or(0.0);
                    (
                        cell.states,
                        cell.accuracy,
                        Some((cell.accuracy - deviation, cell.accuracy + deviation)),
                    )
                })
                .collect()
        };
        let paper = own()
            .filter(|cell| cell.recipe == AUTHORS)
            .map(|cell| (cell.states, cell.paper, None))
            .collect();
        Quarter {
            name: format!("campaigns-{}-{}", unit_name(unit), features_name(features)),
            title: format!("{}, {}, mean of campaigns", unit_name(unit), features_name(features)),
            series: vec![
                ("authors' recipe", AUTHORS_STYLE, cells(AUTHORS)),
                ("modern recipe", MODERN_STYLE, cells(MODERN)),
                ("paper", PAPER, paper),
            ],
        }
        .chart()
    };
    QUARTERS.map(quarter).to_vec()
}

/// Force and motion of one leaf and one trunk trial.
pub fn figure_5(results: &Results) -> Vec<String> {
    let of = |what: &str, label: &str, unit: &str, value: fn(&underbrush_recording::Sample) -> Option<f64>| {
        let mut description = format!("{what} over time since contact.");
        let mut layers = Vec::new();
        for example in &results.figure_5 {
            let start_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
            let points: Vec<(f64, f64)> = example
                .data
                .samples
                .iter()
                .filter_map(|sample| Some((sample.time_s - start_s, value(sample)?)))
                .collect();
            let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
            let lasts_s = points.last().map_or(0.0, |point| point.0);
            description += &format!(" {}: up to {most:.3} {unit} in {lasts_s:.2} s.", example.category);
            let style = match example.category {
                "leaf" => Style::line(LEAF, Dash::Solid),
                _ => Style::line(TRUNK, Dash::Dashed),
            };
            layers.push(Layer::new(example.category, style, Shape::Line(points)));
        }
        let chart = Chart {
            name: format!("figure-5-{what}"),
            title: format!("{what} of a taxel"),
            description,
            x: Axis::from_zero("time since contact / s"),
            y: Axis::from_zero(label),
            layers,
        };
        chart.svg()
    };
    vec![
        of("Force", "force / N", "N", |sample| Some(sample.force_n)),
        of("Motion", "motion / m", "m", |sample| sample.motion_m),
    ]
}

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

/// Shares of the ten engineered reaches.
pub fn figure_11(results: &Results) -> String {
    let mut description = String::from("Per cent correct, misclassified and uncertain.");
    let mut names = Vec::new();
    let mut heights = [const { Vec::new() }; 3];
    for (place, reach) in results.figure_11.iter().enumerate() {
        let letter = if reach.category == "leaf" { "L" } else { "T" };
        let name = format!("{}{letter}", place + 1);
        let shares = reach.shares.as_ref().map_or([f64::NAN; 3], |shares| {
            [
                shares.correct_percent,
                shares.misclassified_percent,
                shares.uncertain_percent,
            ]
        });
        description += &format!(" {name}: {:.0}, {:.0}, {:.0}.", shares[0], shares[1], shares[2]);
        heights.iter_mut().zip(shares).for_each(|(own, share)| own.push(share));
        names.push(name);
    }
    let [correct, wrong, uncertain] = heights;
    let chart = Chart {
        name: "figure-11".into(),
        title: "Verdicts in ten engineered reaches".into(),
        description,
        x: Axis::names("reach; L leaf only, T trunk only", names),
        y: Axis::spanning("taxels in contact / %", 0.0, 100.0),
        layers: vec![
            Layer::new("correct", Style::line(CORRECT, Dash::Solid), Shape::Bars(correct)),
            Layer::new("misclassified", Style::line(WRONG, Dash::Dashed), Shape::Bars(wrong)),
            Layer::new(
                "uncertain",
                Style::line(UNCERTAIN, Dash::Dotted),
                Shape::Bars(uncertain),
            ),
        ],
    };
    chart.svg()
}

/// Accuracy over the length to which trials are truncated.
pub fn figure_13(results: &Results) -> String {
    let mut names: Vec<String> = Vec::new();
    for point in &results.figure_13 {
        let name = point.max_samples.map_or("all".to_owned(), |most| most.to_string());
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut description = String::from("Accuracy in per cent by samples at most.");
    let mut layer = |states: usize, style: Style| {
        let points: Vec<Point> = results
            .figure_13
            .iter()
            .filter(|point| point.states == states)
            .enumerate()
            .map(|(place, point)| Point {
                x: place as f64,
                y: point.accuracy,
                interval: Some((point.low, point.high)),
            })
            .collect();
        let values: Vec<String> = names
            .iter()
            .zip(&points)
            .map(|(name, point)| format!("{name}: {:.1}", point.y))
            .collect();
        description += &format!(" {states} states: {}.", values.join(", "));
        Layer::new(format!("{states} states"), style, Shape::Points(points))
    };
    let layers = vec![layer(10, AUTHORS_STYLE), layer(20, MODERN_STYLE)];
    let chart = Chart {
        name: "figure-13".into(),
        title: "Accuracy on truncated trials".into(),
        description,
        x: Axis {
            label: "samples at most".into(),
            scale: Scale::Names(names),
        },
        y: Axis::spanning("accuracy / %", 40.0, 100.0),
        layers,
    };
    chart.svg()
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
