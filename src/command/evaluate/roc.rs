//! ROC curves as CSV.

use underbrush_classifier::decision::{Decision, Rule};
use underbrush_classifier::evaluate::{Evaluation, RocCurve, category_roc, outlier_roc};
use underbrush_recording::Category;

use crate::failure::Failure;
use crate::output;

/// One row per point of each curve. An empty threshold classifies nothing as positive.
pub(super) fn csv(evaluation: &Evaluation, decision: &Decision) -> Result<Vec<u8>, Failure> {
    let mut rows = Vec::new();
    let mut add = |positives: &str, curve: Option<RocCurve>| {
        for point in curve.iter().flat_map(|curve| &curve.points) {
            let threshold = point.threshold.map_or(String::new(), |threshold| threshold.to_string());
            let (false_rate, true_rate) = (point.false_positive_rate, point.true_positive_rate);
            rows.push(vec![positives.to_string(), threshold, false_rate.to_string(), true_rate.to_string()]);
        }
    };
    for category in evaluation.known_categories() {
        add(category, category_roc(evaluation, category));
    }
    if let Rule::OutlierBand { uncertain_below, .. } = decision.rule {
        let judge = decision.prepare(evaluation.known_categories())?;
        add(Category::OUTLIER.name(), outlier_roc(evaluation, &judge, uncertain_below));
    }
    let header = ["positives", "threshold_nats", "false_positive_rate", "true_positive_rate"];
    output::csv_bytes(&header, rows)
}
