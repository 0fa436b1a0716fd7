use underbrush_recording::vector::with_baseline;

use super::super::batch_scores::FeatureRows;
use super::super::network::{Network, Row, softmax};

/// Points in a square; the class is whether the signs of their coordinates differ, which no linear function can tell.
fn checkerboard() -> Vec<Row<2>> {
    let place = |index: usize| ((index as f64 + 0.5) / 20.0) * 2.0 - 1.0;
    let points = (0..400).map(|index| [place(index % 20), place(index / 20)]);
    let row = |features: [f64; 2]| Row { features, class: usize::from(features[0] * features[1] < 0.0), weight: 1.0 };
    points.map(row).collect()
}

/// Tests that a network learns what a linear classifier cannot, and that a fit depends only on its rows, not on the
/// instructions that a processor has.
#[test]
fn a_network_learns_a_checkerboard() {
    let rows = checkerboard();
    let network = Network::fit(&rows, 2);
    let right = rows.iter().filter(|row| {
        let scores = network.scores(&row.features);
        (scores[1] > scores[0]) == (row.class == 1)
    });
    let right = right.count();
    assert!(right >= 380, "{right} of 400");
    assert_eq!(Network::fit(&rows, 2), network);
    assert_eq!(with_baseline(|| Network::fit(&rows, 2)), network);
    assert!(network.is_sound(2, 2) && !network.is_sound(3, 2) && !network.is_sound(2, 3));
}

/// Tests that a feature that never varies has no influence, and that weights of rows shift the odds: with the same
/// features for both classes, the probability is the share of the weights.
#[test]
fn weights_are_odds() {
    let rows: Vec<Row<2>> = (0..600)
        .map(|index| Row {
            features: [3.0, if index % 4 < 2 { 1.0 } else { -1.0 }],
            class: index % 2,
            weight: if index % 2 == 0 { 3.0 } else { 1.0 },
        })
        .collect();
    let network = Network::fit(&rows, 2);
    for second in [-1.0, 1.0] {
        let mut scores = network.scores(&[3.0, second]);
        assert_eq!(scores, network.scores(&[7.0, second]));
        softmax(&mut scores);
        // The penalty pulls the constant a little towards even odds, and the last steps leave some noise.
        assert!((scores[0] - 0.75).abs() < 0.03, "{scores:?}");
    }
}

/// Tests the scores against the sums that the model file describes, and that they have the same bits for one row and
/// for several side by side, and with the instructions of this processor and those that every processor has.
#[test]
fn rows_side_by_side_have_the_scores_of_one_row() {
    let rows = checkerboard();
    let network = Network::fit(&rows, 2);
    let file = serde_json::to_value(&network).unwrap();
    let number = |place: &serde_json::Value| place.as_f64().unwrap();
    let described = |features: &[f64; 2]| -> [f64; 2] {
        let standardized =
            |index: usize| (features[index] - number(&file["mean"][index])) * number(&file["scale"][index]);
        let inputs = [standardized(0).clamp(-5.0, 5.0), standardized(1).clamp(-5.0, 5.0), 1.0];
        let unit = |unit: usize| -> f64 {
            let sum: f64 = (0..3).map(|input| inputs[input] * number(&file["hidden"][input][unit])).sum();
            sum.max(0.0)
        };
        [0, 1].map(|class| {
            let weights = file["output"][class].as_array().unwrap().iter().enumerate();
            let sum: f64 = weights.map(|(index, weight)| number(weight) * unit(index)).sum();
            sum + number(&file["output_constant"][class])
        })
    };
    for count in 0..10 {
        let mut some = FeatureRows::with_capacity(count);
        let mut expected = Vec::new();
        for row in &rows[..count] {
            // Some rows are so far out that inputs are clamped.
            let features = row.features.map(|feature| feature * (1.0 + count as f64));
            some.push(&features);
            let scores = network.scores(&features);
            for (score, described) in scores.iter().zip(described(&features)) {
                // The sums have 24 terms in another order.
                assert!((score - described).abs() < 1e-12 * (1.0 + described.abs()), "{score} {described}");
            }
            expected.extend(scores);
        }
        let mut scores = Vec::new();
        network.scores_of(&some, &mut scores);
        assert_eq!(scores, expected);
        with_baseline(|| network.scores_of(&some, &mut scores));
        assert_eq!(scores, expected);
    }
}
