//! Table I as charts.

use crate::drawing::{Axis, Chart, Layer, Point, Shape, Style};
use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::feature::FeatureSet;

use super::{ASIDE, AUTHORS_STYLE, MAJORITY, MODERN_STYLE, PAPER};
use underbrush_experiments::campaign::{AUTHORS, MODERN};
use underbrush_experiments::measurement::{CellKey, unit_name};
use underbrush_experiments::results::Results;

/// States, accuracy in per cent, and its interval.
type StatesAccuracy = (usize, f64, Option<(f64, f64)>);

/// Accuracy of one unit and feature set over the number of states: a quarter of a table.
struct Quarter<'a> {
    name: String,
    title: String,
    /// Name, style and accuracies over states.
    series: Vec<(&'a str, Style, Vec<StatesAccuracy>)>,
    /// What the same verdict for every trial would reach, per cent.
    majority_baseline: f64,
}

const STATES: [usize; 3] = [5, 10, 20];
const QUARTERS: [(TableOneUnit, FeatureSet); 4] = [
    (TableOneUnit::Taxel, FeatureSet::FORCE),
    (TableOneUnit::Taxel, FeatureSet::FORCE_AND_MOTION),
    (TableOneUnit::Component, FeatureSet::FORCE),
    (TableOneUnit::Component, FeatureSet::FORCE_AND_MOTION),
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
        description += &format!(" Majority baseline: {:.1}.", self.majority_baseline);
        let ends = [-0.5, STATES.len() as f64 - 0.5].map(|x| (x, self.majority_baseline));
        layers.push(Layer::new("majority", MAJORITY, Shape::Line(ends.to_vec())));
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

/// A cell: what it is of, its recipe, its accuracy here and the paper's.
type Cell<'a> = ((TableOneUnit, FeatureSet), &'a str, StatesAccuracy, f64);

/// Four charts of the cells of a table; `suffix` follows each title.
fn quarters(table: &str, suffix: &str, cells: &[Cell], majority_baseline: impl Fn(TableOneUnit) -> f64) -> Vec<String> {
    let quarter = |of: (TableOneUnit, FeatureSet)| {
        let own = |recipe: &'static str| cells.iter().filter(move |cell| cell.0 == of && cell.1 == recipe);
        let here = |recipe| own(recipe).map(|cell| cell.2).collect();
        let paper = own(AUTHORS).map(|(_, _, (states, _, _), paper)| (*states, *paper, None));
        let (unit, features) = (unit_name(of.0), of.1);
        Quarter {
            name: format!("{table}-{unit}-{features}"),
            title: format!("{unit}, {features}{suffix}"),
            series: vec![
                ("authors' recipe", AUTHORS_STYLE, here(AUTHORS)),
                ("modern recipe", MODERN_STYLE, here(MODERN)),
                ("paper", PAPER, paper.collect()),
            ],
            majority_baseline: majority_baseline(of.0),
        }
        .chart()
    };
    QUARTERS.map(quarter).to_vec()
}

/// Table I in four charts.
pub fn table_1(results: &Results) -> Vec<String> {
    let table = &results.measurement.table_1;
    let cells = table.iter().map(|cell| {
        let own = &cell.accuracy;
        let accuracy = (cell.key.states, own.accuracy, Some((own.low, own.high)));
        (of(&cell.key), cell.key.recipe.as_str(), accuracy, cell.paper)
    });
    quarters("table-1", "", &cells.collect::<Vec<_>>(), |unit| {
        let cell = table.iter().find(|cell| cell.key.by == unit);
        cell.map_or(f64::NAN, |cell| cell.accuracy.majority_baseline)
    })
}

/// The mean of several campaigns in four charts, whiskers of one standard deviation.
pub fn campaigns(results: &Results) -> Vec<String> {
    let Some(campaigns) = &results.campaigns else {
        return Vec::new();
    };
    let table = &campaigns.table_1;
    let cells = table.iter().map(|cell| {
        let own = &cell.figures.accuracy;
        let deviation = own.standard_deviation.unwrap_or(0.0);
        let interval = (own.mean - deviation, own.mean + deviation);
        let accuracy = (cell.key.states, own.mean, Some(interval));
        (of(&cell.key), cell.key.recipe.as_str(), accuracy, cell.paper)
    });
    quarters("campaigns", ", mean of campaigns", &cells.collect::<Vec<_>>(), |unit| {
        let cell = table.iter().find(|cell| cell.key.by == unit);
        cell.map_or(f64::NAN, |cell| cell.figures.majority_baseline.mean)
    })
}

/// The quarter that a cell belongs to.
fn of(key: &CellKey) -> (TableOneUnit, FeatureSet) {
    (key.by, key.features)
}
