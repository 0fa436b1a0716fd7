//! Tests of boosted trees, and of their text in model files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{Boosted, Loss, Row};

/// Fits trees to rows of features that are known objects (false) or the family (true), each class with half the weight.
fn fit(rows: &[(Vec<f32>, bool)]) -> Boosted {
    let count = |class: bool| rows.iter().filter(|row| row.1 == class).count() as f64;
    let weight = |class: bool| 0.5 / count(class);
    let rows: Vec<Row<'_>> = rows
        .iter()
        .map(|(features, is_family)| Row { features, target: f64::from(*is_family), weight: weight(*is_family) })
        .collect();
    Boosted::fit(Loss::Logistic, &rows, rows[0].features.len())
}

/// Tests the sum of all trees against a recursion by hand. A feature that is 0 for all of 40 known rows and 1 for all of 40 of the
/// family is cut there by every tree. In a leaf with 40 rows of weight 1, at log-odds s and probability p = 1 / (1 + exp(-s)),
/// each tree adds 0.06 · 40 (1 - p) / (40 p (1 - p) + 1).
#[test]
fn steps_are_those_of_newton() {
    let trees = fit(&(0..80).map(|row| (vec![f32::from(row % 2 == 1)], row % 2 == 1)).collect::<Vec<_>>());
    let mut expected = 0.0;
    for _ in 0..200 {
        let p: f64 = 1.0 / (1.0 + f64::exp(-expected));
        expected += 0.06 * 40.0 * (1.0 - p) / (40.0 * p * (1.0 - p) + 1.0);
    }
    // Each step is rounded to whole ten-thousandths.
    for (feature, expected) in [(1.0, expected), (0.0, -expected)] {
        assert!((trees.score(&[feature]) - expected).abs() < 0.01, "{}, expected {expected}", trees.score(&[feature]));
    }
}

/// Tests the squared loss by hand: of 40 rows at -1 and 40 at 2, each tree adds 0.06 of 40 times what is left, over 40 + 1.
#[test]
fn a_number_is_approached_by_its_share() {
    let features = [[0.0_f32], [1.0]];
    let row = |index: usize| Row { features: &features[index % 2], target: [-1.0, 2.0][index % 2], weight: 3.0 };
    let trees = Boosted::fit(Loss::Squared, &(0..80).map(row).collect::<Vec<_>>(), 1);
    let reached = 1.0 - (1.0 - 0.06 * 40.0 / 41.0_f64).powi(200);
    for (features, target) in features.iter().zip([-1.0, 2.0]) {
        // Each of 200 steps is rounded to whole ten-thousandths.
        assert!((trees.score(features) - target * reached).abs() < 0.01, "{}", trees.score(features));
    }
}

/// Tests the log-odds against those of an independent library: scikit-learn 1.9's `HistGradientBoostingClassifier` with
/// `max_iter=200`, `learning_rate=0.06`, `max_depth=4`, `max_leaf_nodes=None`, `min_samples_leaf=20`, `l2_regularization=1`,
/// `max_bins=64` and the same weights. Features have 32 values, so that both try the same cuts. Only the first trees
/// are compared: both round, here steps to whole ten-thousandths, there gradients to single precision, and cuts that gain nearly
/// the same lead to other trees later.
#[test]
fn scores_are_those_of_scikit_learn() {
    let steps = [0.618_033_988_7, 0.754_877_666_2, 0.569_840_291_0, 0.819_172_513_4];
    let row = |index: usize| {
        let features = steps.map(|step: f64| ((index as f64 * step).fract() * 32.0).floor() as f32 / 32.0);
        (features.to_vec(), (features[0] + features[1] >= 1.0) ^ index.is_multiple_of(10))
    };
    let trees = fit(&(0..2000).map(row).collect::<Vec<_>>());
    for (features, expected) in [
        ([0.2, 0.2, 0.5, 0.5], [-0.0940, -0.1825, -0.4216]),
        ([0.45, 0.45, 0.5, 0.5], [-0.0940, -0.1825, -0.4216]),
        ([0.52, 0.52, 0.5, 0.5], [0.0888, 0.1726, 0.3993]),
        ([0.55, 0.55, 0.2, 0.8], [0.0888, 0.1726, 0.3993]),
        ([0.8, 0.8, 0.5, 0.5], [0.0983, 0.1909, 0.4416]),
        ([0.1, 0.8, 0.3, 0.9], [-0.0692, -0.1344, -0.3012]),
    ] {
        for (count, expected) in [1, 2, 5].into_iter().zip(expected) {
            let first = Boosted { spans: trees.spans.clone(), trees: trees.trees[..count].to_vec() };
            let found = first.score(&features);
            assert!((found - expected).abs() < 5e-4, "{found} after {count} trees, {features:?}, expected {expected}");
        }
    }
}

/// Number of features of trees that are written to files.
const FEATURES: usize = 30;

/// Trees of 200 rows.
fn large() -> Boosted {
    let row = |index: usize| {
        let feature = |feature: usize| ((index * (feature + 3)) as f32 * 0.618_034).fract();
        ((0..FEATURES).map(feature).collect::<Vec<f32>>(), index.is_multiple_of(3))
    };
    fit(&(0..200).map(row).collect::<Vec<_>>())
}

/// What a tree adds, read from its bytes as docs/classifiers.md describes them, and the bytes after the tree.
fn walk<'a>(bytes: &'a [u8], features: &[f32], spans: &[[f64; 2]]) -> (f64, &'a [u8]) {
    let (rest, number) = (&bytes[3..], [bytes[1], bytes[2]]);
    if bytes[0] == 255 {
        return (f64::from(i16::from_le_bytes(number)) * 1e-4, rest);
    }
    let [low, high] = spans[usize::from(bytes[0])];
    let cut = low + (high - low) * f64::from(u16::from_le_bytes(number)) / 65_535.0;
    let (left, rest) = walk(rest, features, spans);
    let (right, rest) = walk(rest, features, spans);
    (if f64::from(features[usize::from(bytes[0])]) <= cut { left } else { right }, rest)
}

/// Tests that a file holds the same trees, and that a reader of its text that shares no code finds the same log-odds.
#[test]
fn files_hold_the_trees() {
    let boosted = large();
    let value = serde_json::to_value(&boosted).unwrap();
    assert_eq!(serde_json::from_value::<Boosted>(value.clone()).unwrap(), boosted);
    let spans: Vec<[f64; 2]> = serde_json::from_value(value["spans"].clone()).unwrap();
    let trees: Vec<String> = serde_json::from_value(value["trees"].clone()).unwrap();
    for index in 0..20 {
        let features: Vec<f32> =
            (0..FEATURES).map(|feature| ((index * 7 + feature * 5) as f32 * 0.414_2).fract()).collect();
        let steps = trees.iter().map(|tree| {
            let bytes = STANDARD.decode(tree).unwrap();
            let (step, rest) = walk(&bytes, &features, &spans);
            assert!(rest.is_empty());
            step
        });
        let expected = steps.sum::<f64>();
        assert!((boosted.score(&features) - expected).abs() < 1e-9);
    }
}

/// Tests that text that is no tree is refused: bytes that are missing, too many, or name a feature that does not exist, and
/// ranges that do not fit.
#[test]
fn damaged_trees_are_refused() {
    let value = serde_json::to_value(large()).unwrap();
    for (tree, what) in [
        (&[][..], "nothing"),
        (&[255, 9][..], "a leaf without its second byte"),
        (&[0, 1, 1, 255, 9, 0][..], "a cut with one child"),
        (&[255, 9, 0, 255, 9, 0][..], "two trees"),
        (&[FEATURES as u8, 1, 1, 255, 9, 0, 255, 9, 0][..], "a feature that does not exist"),
    ] {
        let mut damaged = value.clone();
        damaged["trees"][1] = STANDARD.encode(tree).into();
        assert!(serde_json::from_value::<Boosted>(damaged).is_err(), "{what}");
    }
    for damage in [serde_json::json!([]), serde_json::json!([[1.0, 0.0]])] {
        let mut damaged = value.clone();
        damaged["spans"] = damage;
        assert!(serde_json::from_value::<Boosted>(damaged).is_err());
    }
}
