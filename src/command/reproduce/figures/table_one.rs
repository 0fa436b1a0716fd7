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

/// A cell: what it is of, its recipe, its accuracy here and the paper's.
type Cell<'a> = ((TableOneUnit, FeatureSet), &'a str, Accuracy, f64);

/// Four charts of the cells of a table; `suffix` follows each title.
fn quarters(table: &str, suffix: &str, cells: &[Cell]) -> Vec<String> {
    let quarter = |of: (TableOneUnit, FeatureSet)| {
        let own = |recipe: &'static str| cells.iter().filter(move |cell| cell.0 == of && cell.1 == recipe);
        let here = |recipe| own(recipe).map(|cell| cell.2).collect();
        let paper = own(AUTHORS).map(|(_, _, (states, _, _), paper)| (*states, *paper, None));
        let (unit, features) = (unit_name(of.0), features_name(of.1));
        Quarter {
            name: format!("{table}-{unit}-{features}"),
            title: format!("{unit}, {features}{suffix}"),
            series: vec![
                ("authors' recipe", AUTHORS_STYLE, here(AUTHORS)),
                ("modern recipe", MODERN_STYLE, here(MODERN)),
                ("paper", PAPER, paper.collect()),
            ],
        }
        .chart()
    };
    QUARTERS.map(quarter).to_vec()
}

/// Table I in four charts.
pub fn table_1(results: &Results) -> Vec<String> {
    let cells = results.measurement.table_1.iter().map(|cell| {
        let accuracy = (cell.states, cell.accuracy, Some((cell.low, cell.high)));
        ((cell.by, cell.features), cell.recipe.as_str(), accuracy, cell.paper)
    });
    quarters("table-1", "", &cells.collect::<Vec<_>>())
}

/// The mean of several campaigns in four charts, whiskers of one standard deviation.
pub fn campaigns(results: &Results) -> Vec<String> {
    let Some(campaigns) = &results.campaigns else {
        return Vec::new();
    };
    let cells = campaigns.table_1.iter().map(|cell| {
        let deviation = cell.standard_deviation.unwrap_or(0.0);
        let interval = (cell.accuracy - deviation, cell.accuracy + deviation);
        let accuracy = (cell.states, cell.accuracy, Some(interval));
        ((cell.by, cell.features), cell.recipe.as_str(), accuracy, cell.paper)
    });
    quarters("campaigns", ", mean of campaigns", &cells.collect::<Vec<_>>())
}
