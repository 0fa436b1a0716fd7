use super::*;
use crate::decision::Decision;
use crate::evaluate::tests::scored;

/// Tests the area against a count of all pairs, with ties counted half, on scores with ties and infinities.
#[test]
fn the_area_is_the_chance_to_rank_a_pair_rightly() {
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
    let swapped = RocCurve::of(&negatives, &positives).unwrap();
    assert!((curve.area + swapped.area - 1.0).abs() < 1e-15);
}

/// Tests that the interval of an area holds it, and that there is none for one reach, or without negatives.
#[test]
fn areas_have_intervals_over_reaches() {
    let pair = |reach: u8| {
        let [positive, negative] = [reach % 5, reach % 3].map(f64::from);
        [(usize::from(reach), true, positive), (usize::from(reach), false, negative)]
    };
    let things: Vec<_> = (0..20).flat_map(pair).collect();
    let scores = |of: bool| -> Vec<f64> { things.iter().filter(|own| own.1 == of).map(|own| own.2).collect() };
    let area = RocCurve::of(&scores(true), &scores(false)).unwrap().area;
    let interval = area_interval(things.clone()).unwrap();
    assert!(0.5 < interval.low && interval.low < area && area < interval.high && interval.high < 0.9, "{interval:?}");
    assert_eq!(area_interval(things[..2].to_vec()), None);
    assert_eq!(area_interval(things.into_iter().filter(|own| own.1).collect()), None);
}

/// Tests both ends of the curve, that it never decreases, and each point against a count of the scores at or above its
/// threshold.
#[test]
fn points_are_the_counts_at_their_thresholds() {
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
    let rates: Vec<_> = curve.points.iter().map(|p| (p.false_positive_rate, p.true_positive_rate)).collect();
    assert!(rates.is_sorted_by(|a, b| a.0 <= b.0 && a.1 <= b.1));
    assert_eq!((rates[0], rates[5]), ((0.0, 0.0), (1.0, 1.0)));
    assert_eq!(RocCurve::of(&[], &negatives), None);
    assert_eq!(RocCurve::of(&[f64::NAN], &negatives), None);
}

/// Tests the signed margin as score: leaf margins of 2, −1 and 0 (no category admits the trial) against 1 and −5.
#[test]
fn a_category_is_set_against_all_others() {
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

/// The false and true positive rates of a curve's points.
fn rates(curve: &RocCurve) -> Vec<(f64, f64)> {
    let points = curve.points.iter();
    points.map(|point| (point.false_positive_rate, point.true_positive_rate)).collect()
}

/// Tests that the smallest margins are called outliers first, on scores whose answer is worked out by hand.
#[test]
fn the_smallest_leads_are_called_outliers_first() {
    let judge = Decision::argmax().prepare(&["leaf".into(), "trunk".into()]).unwrap();
    // Margins: outliers 60 and 85, known 90, 30 and 200. The outlier has the smaller margin in 4 of the 2 · 3 pairs.
    let evaluation = scored(&[
        ("leaf", [90.0, 0.0]),
        ("trunk", [0.0, 30.0]),
        ("trunk", [0.0, 200.0]),
        ("outlier", [60.0, 0.0]),
        ("outlier", [0.0, 85.0]),
        // A block is neither and does not count.
        ("block", [1.0, 0.0]),
    ]);
    let curve = outlier_roc(&evaluation, &judge, 0.0).unwrap();
    assert!((curve.area - 4.0 / 6.0).abs() < 1e-15, "{}", curve.area);
    let third = 1.0 / 3.0;
    let by_hand = [(0.0, 0.0), (third, 0.0), (third, 0.5), (third, 1.0), (2.0 * third, 1.0), (1.0, 1.0)];
    assert_eq!(rates(&curve), by_hand);
    let thresholds: Vec<Option<f64>> = curve.points.iter().map(|point| point.threshold).collect();
    assert_eq!(thresholds, [None, Some(30.0), Some(60.0), Some(85.0), Some(90.0), Some(200.0)]);
    // Outliers with smaller margins than all others are found without a false alarm; with larger ones they never are.
    let apart = |outlier: f64, known: f64| scored(&[("outlier", [outlier, 0.0]), ("leaf", [known, 0.0])]);
    let area = |evaluation| outlier_roc(&evaluation, &judge, 0.0).unwrap().area;
    assert_eq!(area(apart(2.0, 50.0)), 1.0);
    assert_eq!(area(apart(50.0, 2.0)), 0.0);
    // No category admits the outlier, so there is no margin.
    let never = f64::NEG_INFINITY;
    let excluded = scored(&[("outlier", [never, never]), ("leaf", [1e-9, 0.0])]);
    assert_eq!(area(excluded), 1.0);
}

/// Tests that objects of a category that the classifier does not know count as the outliers do.
#[test]
fn unknown_categories_count_as_outliers() {
    let judge = Decision::argmax().prepare(&["leaf".into(), "trunk".into()]).unwrap();
    let curve = |unknown| {
        let rows = [("leaf", [90.0, 0.0]), ("trunk", [0.0, 30.0]), (unknown, [60.0, 0.0]), (unknown, [0.0, 20.0])];
        outlier_roc(&scored(&rows), &judge, 0.0)
    };
    // In 3 of the 4 pairs the unknown one has the smaller margin.
    assert_eq!(curve("stalk").map(|curve| curve.area), Some(0.75));
    assert_eq!(curve("stalk"), curve("outlier"));
    assert_eq!(curve("leaf"), None);
}

/// Tests that the curve passes through the verdicts of the paper's rule, and that uncertain trials are never found.
#[test]
fn the_curve_passes_through_the_rule() {
    let evaluation = scored(&[
        ("leaf", [90.0, 0.0]),
        ("trunk", [0.0, 30.0]),
        ("trunk", [0.0, 5.0]),
        ("outlier", [60.0, 0.0]),
        ("outlier", [0.0, 14.0]),
    ]);
    let judge = Decision::paper().prepare(&["leaf".into(), "trunk".into()]).unwrap();
    let curve = outlier_roc(&evaluation, &judge, 15.0).unwrap();
    let verdicts = |outlier: bool| {
        let own: Vec<_> =
            evaluation.predictions.iter().filter(|prediction| (prediction.category == "outlier") == outlier).collect();
        let called =
            own.iter().filter(|prediction| judge.choose(&prediction.scores) == crate::decision::Verdict::Outlier);
        called.count() as f64 / own.len() as f64
    };
    // The last point with a margin of at most 80 nats, the paper's upper threshold.
    let at_80 = curve.points.iter().rfind(|point| point.threshold.is_some_and(|margin| margin <= 80.0)).unwrap();
    assert_eq!((at_80.false_positive_rate, at_80.true_positive_rate), (verdicts(false), verdicts(true)));
    // A straight line from the last trial that is not uncertain to the end.
    assert_eq!(rates(&curve)[3..], [(2.0 / 3.0, 0.5), (1.0, 1.0)]);
}
