use super::super::network::{Network, Row, softmax};

/// Points in a square; the class is whether the signs of their coordinates differ, which no linear function tells.
fn checkerboard() -> Vec<Row<2>> {
    let place = |index: usize| ((index as f64 + 0.5) / 20.0) * 2.0 - 1.0;
    let points = (0..400).map(|index| [place(index % 20), place(index / 20)]);
    let row = |features: [f64; 2]| Row {
        features,
        class: usize::from(features[0] * features[1] < 0.0),
        weight: 1.0,
    };
    points.map(row).collect()
}

/// Pins that a network learns what a linear classifier cannot, and that a fit depends on nothing but its rows.
#[test]
fn a_network_learns_a_checkerboard() {
    let rows = checkerboard();
    let network = Network::fit(&rows, 2);
    let right = rows.iter().filter(|row| {
        let mut scores = [0.0; 2];
        network.scores(&row.features, &mut scores);
        (scores[1] > scores[0]) == (row.class == 1)
    });
    let right = right.count();
    assert!(right >= 380, "{right} of 400");
    assert_eq!(Network::fit(&rows, 2), network);
    assert!(network.is_sound(2, 2) && !network.is_sound(3, 2) && !network.is_sound(2, 3));
}

/// Pins that a feature that never varies has no influence, and that weights of rows shift the odds: with the same features for
/// both classes, the probability is the share of the weights.
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
        let mut scores = [0.0; 2];
        network.scores(&[3.0, second], &mut scores);
        let mut other = [0.0; 2];
        network.scores(&[7.0, second], &mut other);
        assert_eq!(scores, other);
        softmax(&mut scores);
        // The penalty pulls the constant a little towards even odds, and the last steps leave some noise.
        assert!((scores[0] - 0.75).abs() < 0.03, "{scores:?}");
    }
}
