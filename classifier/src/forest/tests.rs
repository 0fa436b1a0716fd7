//! Tests of forests, and of their text in model files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{Forest, ForestRow};

/// Fits a forest to rows of features that are known objects (false) or the family (true), each class with half the weight.
fn fit(rows: &[(Vec<f32>, bool)]) -> Forest {
    let count = |class: bool| rows.iter().filter(|row| row.1 == class).count() as f64;
    let weight = |class: bool| 0.5 / count(class);
    let rows: Vec<ForestRow<'_>> = rows
        .iter()
        .map(|(features, is_family)| ForestRow { features, is_family: *is_family, weight: weight(*is_family) })
        .collect();
    Forest::fit(&rows, rows[0].features.len(), 0.0, 7)
}

/// Tests the probability against a closed form. Of eight rows with one feature, four known ones at 0, and three at 1 and one
/// at 3 of the family, only a cut between 0 and 1 leaves four rows on both sides, and a cut that is uniform from 0 to 3 lies
/// there in a third of the trees. The other trees have one leaf, in which both classes weigh the same.
#[test]
fn cuts_are_uniform() {
    let row = |value: f32| (vec![value], value > 0.5);
    let forest = fit(&[0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0].map(row));
    // Four standard deviations of the mean of 100 trees, each 0 or a half from the closed form.
    let error = 4.0 * 0.5 * (1.0 / 3.0 * 2.0 / 3.0 / 100.0f64).sqrt();
    assert!((forest.probability(&[0.0]) - 1.0 / 3.0).abs() < error, "{}", forest.probability(&[0.0]));
    assert!((forest.probability(&[1.0]) - 2.0 / 3.0).abs() < error, "{}", forest.probability(&[1.0]));
    let sum = forest.probability(&[0.0]) + forest.probability(&[2.0]);
    assert!((sum - 1.0).abs() < 0.005, "{sum}");
}

/// Tests the probabilities against those of an independent library: scikit-learn 1.7's `ExtraTreesClassifier` with 4,000
/// trees, `min_samples_leaf=4`, `max_depth=14`, `max_features=2` and the same weights. There, forests of 100 trees differ
/// from it by 0.01 to 0.03 (standard deviation).
#[test]
fn probabilities_are_those_of_scikit_learn() {
    let steps = [0.618_033_988_7, 0.754_877_666_2, 0.569_840_291_0, 0.819_172_513_4];
    let row = |index: usize| {
        let features = steps.map(|step: f64| (index as f64 * step).fract() as f32);
        (features.to_vec(), (features[0] + features[1] > 1.0) ^ index.is_multiple_of(10))
    };
    let forest = fit(&(0..400).map(row).collect::<Vec<_>>());
    for (features, expected) in [
        ([0.2, 0.2, 0.5, 0.5], 0.103),
        ([0.45, 0.45, 0.5, 0.5], 0.539),
        ([0.5, 0.5, 0.5, 0.5], 0.633),
        ([0.55, 0.55, 0.2, 0.8], 0.672),
        ([0.8, 0.8, 0.5, 0.5], 0.885),
        ([0.1, 0.8, 0.3, 0.9], 0.240),
    ] {
        let found = forest.probability(&features);
        assert!((found - expected).abs() < 0.09, "{found} for {features:?}, expected {expected}");
    }
}

/// Features of a large forest.
const FEATURES: usize = 30;

/// A forest of 200 rows.
fn large_forest() -> Forest {
    let row = |index: usize| {
        let feature = |feature: usize| ((index * (feature + 3)) as f32 * 0.618_034).fract();
        ((0..FEATURES).map(feature).collect::<Vec<f32>>(), index.is_multiple_of(3))
    };
    fit(&(0..200).map(row).collect::<Vec<_>>())
}

/// The share of the family, read from the bytes of a tree as docs/classifiers.md describes them, and the bytes after the tree.
fn walk<'a>(bytes: &'a [u8], features: &[f32], spans: &[[f64; 2]]) -> (f64, &'a [u8]) {
    if bytes[0] == 255 {
        return (f64::from(bytes[1]) / 255.0, &bytes[2..]);
    }
    let [low, high] = spans[usize::from(bytes[0])];
    let cut = low + (high - low) * f64::from(u16::from_le_bytes([bytes[1], bytes[2]])) / 65_535.0;
    let (left, rest) = walk(&bytes[3..], features, spans);
    let (right, rest) = walk(rest, features, spans);
    (if f64::from(features[usize::from(bytes[0])]) <= cut { left } else { right }, rest)
}

/// Tests that a file holds the same forest, and that a reader of its text that shares no code finds the same probabilities.
#[test]
fn files_hold_the_forest() {
    let forest = large_forest();
    let value = serde_json::to_value(&forest).unwrap();
    assert_eq!(serde_json::from_value::<Forest>(value.clone()).unwrap(), forest);
    let spans: Vec<[f64; 2]> = serde_json::from_value(value["spans"].clone()).unwrap();
    let trees: Vec<String> = serde_json::from_value(value["trees"].clone()).unwrap();
    for index in 0..20 {
        let features: Vec<f32> =
            (0..FEATURES).map(|feature| ((index * 7 + feature * 5) as f32 * 0.414_2).fract()).collect();
        let shares = trees.iter().map(|tree| {
            let bytes = STANDARD.decode(tree).unwrap();
            let (share, rest) = walk(&bytes, &features, &spans);
            assert!(rest.is_empty());
            share
        });
        let expected = shares.sum::<f64>() / trees.len() as f64;
        assert!((forest.probability(&features) - expected).abs() < 1e-9);
    }
}

/// Tests that text that is no tree is refused: bytes that are missing, too many, or name a feature that does not exist, and
/// ranges that do not fit.
#[test]
fn damaged_trees_are_refused() {
    let value = serde_json::to_value(large_forest()).unwrap();
    for (tree, what) in [
        (&[][..], "nothing"),
        (&[255][..], "a leaf without its share"),
        (&[0, 1, 1, 255, 9][..], "a cut with one child"),
        (&[255, 9, 255, 9][..], "two trees"),
        (&[FEATURES as u8, 1, 1, 255, 9, 255, 9][..], "a feature that does not exist"),
    ] {
        let mut damaged = value.clone();
        damaged["trees"][1] = STANDARD.encode(tree).into();
        assert!(serde_json::from_value::<Forest>(damaged).is_err(), "{what}");
    }
    for damage in [serde_json::json!([]), serde_json::json!([[1.0, 0.0]])] {
        let mut damaged = value.clone();
        damaged["spans"] = damage;
        assert!(serde_json::from_value::<Forest>(damaged).is_err());
    }
}
