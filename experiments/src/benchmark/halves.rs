//! The two halves of a track: public reaches, which anyone can simulate before a model is trained, and reaches whose seed
//! follows from the model itself.

use serde::{Deserialize, Serialize};

use crate::resampled::Estimate;

/// The figures of a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Halves<T> {
    /// The figure that ranks entries.
    pub ranking: Ranking,
    /// The figures of the public half.
    pub public: T,
    /// The figures of the audit half.
    pub audit: T,
}

/// The figure that ranks the entries of a track: that of the audit half.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ranking {
    /// In the audit half.
    pub audit: Estimate,
    /// In the public half.
    pub public: Estimate,
    /// That of the public half minus that of the audit half.
    pub difference: Estimate,
}

impl Ranking {
    /// Computes the statistic of both halves, each given as groups of reaches, and their difference. Each group is resampled
    /// on its own.
    pub(super) fn of<R: Sync>(
        [public, audit]: [&[Vec<R>]; 2],
        statistic: impl Fn(&[Vec<&R>]) -> Option<f64> + Sync,
    ) -> Self {
        let [own_public, own_audit] = [public, audit].map(|half| half.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let both: Vec<&[R]> = own_public.iter().chain(&own_audit).copied().collect();
        Ranking {
            audit: Estimate::of_groups(&own_audit, &statistic),
            public: Estimate::of_groups(&own_public, &statistic),
            difference: Estimate::of_groups(&both, |groups| {
                let (public, audit) = groups.split_at(own_public.len());
                Some(statistic(public)? - statistic(audit)?)
            }),
        }
    }

    /// Whether the halves differ by more than chance explains: the 95 % interval of the difference excludes 0. `None` if it
    /// has no interval.
    pub fn halves_differ(&self) -> Option<bool> {
        self.difference.interval.map(|[low, high]| low > 0.0 || high < 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(groups: &[Vec<&f64>]) -> Option<f64> {
        let all: Vec<f64> = groups.iter().flatten().map(|own| **own).collect();
        Some(all.iter().sum::<f64>() / all.len() as f64)
    }

    /// Tests that halves that differ are told from halves that do not, and which difference it is.
    #[test]
    fn halves_that_differ_are_found() {
        let half = |shift: f64| vec![(0..60).map(|index| shift + f64::from(index % 7)).collect::<Vec<f64>>()];
        let same = Ranking::of([&half(0.0), &half(0.0)], mean);
        assert_eq!((same.difference.value, same.halves_differ()), (Some(0.0), Some(false)));
        let other = Ranking::of([&half(2.0), &half(0.0)], mean);
        assert!((other.difference.value.unwrap() - 2.0).abs() < 1e-12);
        assert_eq!((other.halves_differ(), other.audit.value), (Some(true), same.audit.value));
    }
}
