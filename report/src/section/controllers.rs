//! Goals and forces by controller.

use underbrush_experiments::experiment::controllers::{ComparedControllers, ControllerFigures};
use underbrush_experiments::resampled::Estimate;

use crate::style::FIRST;
use crate::{Axis, Cell, Dash, Layer, Point, Report, Rows, Shape, Style, Table, chart, counted, joined};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ComparedControllers) {
    if outcome.controllers.is_empty() {
        return;
    }
    report.section("controllers", "What a map of touched trunks gains");
    report.page.paragraph(&format!(
        "{} of {}, the same for all controllers. The published controller pushes on until it is stuck. The mapped \
         one remembers what stopped it, or what is called a trunk, and plans a way round it.",
        counted(outcome.reaches, "reach", "reaches"),
        outcome.scene
    ));
    let caption = "Goals that were reached, and the largest force on a trunk in a reach, with 95 % intervals from resampling reaches.";
    let charts = [
        compared(outcome, ["controllers-goals", "Goals"], "goals reached / %", 100.0, |own| own.reached),
        compared(outcome, ["controllers-force", "Force"], "peak on trunks / N", 1.0, |own| own.trunk_peak_n),
    ];
    report.page.figure(caption, &charts);
    report.printed(table(outcome), usize::MAX);
}

/// A point with its interval for each controller.
fn compared(
    outcome: &ComparedControllers,
    [name, title]: [&str; 2],
    label: &str,
    scale: f64,
    of: fn(&ControllerFigures) -> Estimate,
) -> String {
    let points = outcome.controllers.iter().enumerate().filter_map(|(place, own)| {
        let Estimate { value, interval } = of(own);
        let interval = interval.map(|[low, high]| (scale * low, scale * high));
        Some((own.name.as_str(), Point { x: place as f64, y: scale * value?, interval }))
    });
    let (names, points): (Vec<&str>, Vec<Point>) = points.unzip();
    let told = names.iter().zip(&points).map(|(name, point)| format!("{name}: {:.1}", point.y));
    let description = format!("{label}. {}.", joined(told, "; "));
    let names = (1..=outcome.controllers.len()).map(|number| number.to_string());
    let axes = (Axis::names("controller, by its row in the table", names), Axis::from_zero(label));
    let style = Style { dash: Dash::Dotted, ..FIRST };
    chart(name, title, description, axes, vec![Layer::new("", style, Shape::Points(points))])
}

fn table(outcome: &ComparedControllers) -> Table {
    let with_interval = |own: Estimate, scale: f64| match own.interval {
        Some(_) => Cell::from(own.text(scale, 1)),
        None => Cell::optional(own.value.map(|value| scale * value), 1),
    };
    Rows::of(outcome.controllers.iter().enumerate())
        .column("", |(place, _)| place + 1)
        .column("controller", |(_, own)| own.name.as_str())
        .column("goals / %", |(_, own)| with_interval(own.reached, 100.0))
        .column("s a goal", |(_, own)| with_interval(own.goal_s, 1.0))
        .column("peak on trunks / N", |(_, own)| with_interval(own.trunk_peak_n, 1.0))
        .column("safety stops", |(_, own)| own.safety_stops)
        .table("controllers", "Controllers on the same reaches")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the description of a chart gives each value to its own controller if that of an earlier one is not
    /// known.
    #[test]
    fn a_description_names_the_controller_of_each_value() {
        let controller = |name: &str, value| ControllerFigures {
            name: name.into(),
            reached: Estimate::default(),
            goal_s: Estimate::default(),
            trunk_peak_n: Estimate { value, interval: None },
            safety_stops: 0,
        };
        let controllers = vec![controller("published", None), controller("mapped", Some(2.0))];
        let outcome = ComparedControllers { scene: "row".into(), reaches: 1, controllers };
        let svg = compared(&outcome, ["force", "Force"], "peak / N", 1.0, |own| own.trunk_peak_n);
        assert!(svg.contains("peak / N. mapped: 2.0."), "{svg}");
    }
}
