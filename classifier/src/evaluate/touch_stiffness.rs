//! The stiffness of touched objects, compared with ground truth.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::math::median;

use super::touch_object::JudgedObject;

/// Objects that were pressed with less say little, N.
const PRESSED_N: f64 = 3.0;

/// How well the stiffness of the objects of one category is told. Only objects that were pressed with 3 N or more and gave way
/// by 1 mm or more count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StiffnessFigures {
    /// The category.
    pub truth: String,
    /// Number of objects.
    pub objects: usize,
    /// Share of which the median of the stiffness is between half and twice the truth.
    pub within_twice: f64,
    /// Share of which the interval holds the truth; 90 % is meant.
    pub held: f64,
    /// Median of the ratio of the told stiffness to the true one.
    pub median_ratio: f64,
}

impl StiffnessFigures {
    /// The figures of each category, in alphabetical order.
    pub(super) fn of(objects: &[JudgedObject]) -> Vec<Self> {
        let mut ratios: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
        for own in objects.iter().filter(|own| own.peak_force_n >= PRESSED_N) {
            let (Some(told), Some(truth_n_per_m)) = (own.stiffness, own.true_stiffness_n_per_m) else { continue };
            let is_held = (told.low_n_per_m..=told.high_n_per_m).contains(&truth_n_per_m);
            let ratio = told.median_n_per_m / truth_n_per_m;
            ratios.entry(&own.truth).or_default().push([ratio, f64::from(u8::from(is_held))]);
        }
        let figures = |(truth, ratios): (&str, Vec<[f64; 2]>)| {
            let count = ratios.len() as f64;
            StiffnessFigures {
                truth: truth.to_owned(),
                objects: ratios.len(),
                within_twice: ratios.iter().filter(|own| (0.5..=2.0).contains(&own[0])).count() as f64 / count,
                held: ratios.iter().map(|own| own[1]).sum::<f64>() / count,
                median_ratio: median(ratios.iter().map(|own| own[0]).collect()).unwrap_or(f64::NAN),
            }
        };
        ratios.into_iter().map(figures).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::Stiffness;

    fn judged(peak_force_n: f64, ratio: f64, truth_n_per_m: Option<f64>) -> JudgedObject {
        let told = |factor: f64| ratio * factor * 100.0;
        JudgedObject {
            truth: "stalk".into(),
            peak_force_n,
            stiffness: Some(Stiffness { low_n_per_m: told(0.5), median_n_per_m: told(1.0), high_n_per_m: told(1.5) }),
            true_stiffness_n_per_m: truth_n_per_m,
            ..JudgedObject::new(1)
        }
    }

    /// Tests the shares: weakly pressed and fixed objects do not count.
    #[test]
    fn only_objects_that_were_pressed_and_gave_way_count() {
        let truth = Some(100.0);
        let objects = [
            judged(5.0, 1.0, truth),
            judged(5.0, 1.8, truth),
            judged(5.0, 4.0, truth),
            judged(1.0, 9.0, truth),
            judged(9.0, 9.0, None),
        ];
        let figures = StiffnessFigures::of(&objects);
        assert_eq!(figures.len(), 1);
        assert_eq!((figures[0].objects, figures[0].median_ratio), (3, 1.8));
        assert_eq!(StiffnessFigures::of(&objects[1..3])[0].median_ratio, 2.9);
        assert!((figures[0].within_twice - 2.0 / 3.0).abs() < 1e-12 && (figures[0].held - 2.0 / 3.0).abs() < 1e-12);
    }
}
