//! Table I as charts.

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::report::{Axis, Chart, Layer, Point, Shape, Style};

use super::super::campaign::{AUTHORS, MODERN};
use super::super::results::{Results, features_name, unit_name};
use super::{ASIDE, AUTHORS_STYLE, MODERN_STYLE, PAPER};

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
            let aside = match style {
                AUTHORS_STYLE => -ASIDE,
                MODERN_STYLE => ASIDE,
                _ => 0.0,
            };
            let points: Vec<Point> = cells
                .iter()
                .filter_map(|(states, accuracy, interval)| {
                    let x = STATES.iter().position(|own| own == states)? as f64 + aside;
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
