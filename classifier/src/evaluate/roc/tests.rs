use super::*;
use crate::decision::Decision;
use crate::evaluate::tests::scored;

#[test]
fn the_area_is_the_chance_to_rank_a_pair_rightly() {
    // Pins the area against counting all pairs, draws half, with ties and infinite scores.
    let positives = [3.0, 1.0, 1.0, f64::INFINITY, -2.0, 0.0];
    let negatives = [1.0, -2.0, -0.0, 0.5, f64::NEG_INFINITY];
    let mut ranked = 0.0;
    for positive in positives {
        for negative in negatives {
            ranked += if positive > negative {
                1.0
            } else if positive == negative {
                0.5
            } else {
                0.0
            };
        }
    }
    let curve = RocCurve::of(&positives, &negatives).unwrap();
    assert!((curve.area - ranked / 30.0).abs() < 1e-15, "{}", curve.area);
    let turned = RocCurve::of(&negatives, &positives).unwrap();
    assert!((curve.area + turned.area - 1.0).abs() < 1e-15);
}

#[test]
fn points_are_the_counts_at_their_thresholds() {
    // Pins both ends, that the curve never falls, and each point against counting what scores so much or more.
    let positives = [0.9, 0.8, 0.8, 0.3];
    let negatives = [0.8, 0.2, 0.1];
    let curve = RocCurve::of(&positives, &negatives).unwrap();
    let at_least = |scores: &[f64], threshold: f64| {
        scores.iter().filter(|score| **score >= threshold).count() as f64 / scores.len() as f64
    };
    assert_eq!(curve.points.len(), 6);
    for point in &curve.points {
        let threshold = point.threshold.unwrap_or(f64::INFINITY);
        assert_eq!(point.true_positive_rate, at_least(&positives, threshold));
        assert_eq!(point.false_positive_rate, at_least(&negatives, threshold));
    }
    let rates: Vec<_> = curve
        .points
        .iter()
        .map(|p| (p.false_positive_rate, p.true_positive_rate))
        .collect();
    assert!(rates.is_sorted_by(|a, b| a.0 <= b.0 && a.1 <= b.1));
    assert_eq!((rates[0], rates[5]), ((0.0, 0.0), (1.0, 1.0)));
    assert_eq!(RocCurve::of(&[], &negatives), None);
    assert_eq!(RocCurve::of(&[f64::NAN], &negatives), None);
}

#[test]
fn a_category_is_set_against_all_others() {
    // Pins the signed lead as score: leaf leads of 2, −1 and 0 (no category admits the trial) against 1 and −5.
    let never = f64::NEG_INFINITY;
    let evaluation = scored(&[
        ("leaf", [2.0, 0.0]),
        ("leaf", [0.0, 1.0]),
        ("leaf", [never, never]),
        ("trunk", [1.0, 0.0]),
        ("trunk", [0.0, 5.0]),
    ]);
    let curve = category_roc(&evaluation, "leaf").unwrap();
    assert_eq!(curve, RocCurve::of(&[2.0, -1.0, 0.0], &[1.0, -5.0]).unwrap());
    assert_eq!(category_roc(&evaluation, "foam"), None);
}

#[test]
fn outliers_lead_by_little_but_not_by_least() {
    // Pins which leads the curve sweeps: from the category threshold down, whichever category leads; above it none.
    let judge = Decision::argmax().prepare(&["leaf".into(), "trunk".into()]).unwrap();
    let evaluation = scored(&[
        ("leaf", [90.0, 0.0]),
        ("trunk", [0.0, 30.0]),
        ("trunk", [0.0, 200.0]),
        ("outlier", [60.0, 0.0]),
        ("outlier", [0.0, 85.0]),
    ]);
    let curve = outlier_roc(&evaluation, &judge, 80.0).unwrap();
    let never = f64::NEG_INFINITY;
    assert_eq!(curve, RocCurve::of(&[60.0, never], &[never, 30.0, never]).unwrap());
}
