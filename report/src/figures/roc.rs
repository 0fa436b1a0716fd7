//! Receiver operating characteristics.

use crate::drawing::{Axis, Chart, Dash, Layer, Shape, Style};
use underbrush_classifier::evaluate::RocCurve;

use super::{AUTHORS_STYLE, INK, OUTLIER};
use underbrush_experiments::thresholds::Thresholds;

/// The curve of leaf against trunk, and that of the outlier against both.
pub fn roc(thresholds: &Thresholds) -> Vec<String> {
    let category = thresholds.category_roc.as_ref().map(|curve| {
        let style = Style::line(AUTHORS_STYLE.colour, Dash::Solid);
        chart(
            "leaf",
            "Leaf against trunk, held-out trials",
            "trunk trials taken for leaf / %",
            style,
            curve,
        )
    });
    let outlier = thresholds.outlier_roc.as_ref().map(|curve| {
        let style = Style::line(OUTLIER, Dash::Solid);
        chart(
            "outlier",
            "Foam roll against leaf and trunk",
            "leaf and trunk trials taken for outliers / %",
            style,
            curve,
        )
    });
    category.into_iter().chain(outlier).collect()
}

fn chart(name: &str, title: &str, x: &str, style: Style, curve: &RocCurve) -> String {
    let point = |point: &underbrush_classifier::evaluate::RocPoint| {
        (100.0 * point.false_positive_rate, 100.0 * point.true_positive_rate)
    };
    let chart = Chart {
        name: format!("roc-{name}"),
        title: title.into(),
        description: format!("Area under the curve {:.3}; 0.5 is chance.", curve.area),
        x: Axis::spanning(x, 0.0, 100.0),
        y: Axis::spanning(format!("{name} trials found / %"), 0.0, 100.0),
        layers: vec![
            Layer::new(
                "chance",
                Style::line(INK, Dash::Dotted),
                Shape::Line(vec![(0.0, 0.0), (100.0, 100.0)]),
            ),
            Layer::new(
                format!("area {:.3}", curve.area),
                style,
                Shape::Line(curve.points.iter().map(point).collect()),
            ),
        ],
    };
    chart.svg()
}
