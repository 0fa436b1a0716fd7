//! What an object does when it is pushed: how stiff it is, and whether it gives way, comes back or stays.
//!
//! Both follow from where the contacts are in the world. Unlike the motion of the skin along its normal, a place does not
//! drift when a contact slides over taxels whose normals are 15° apart. The pose of the skin is sensed, so the arm's own
//! compliance does not enter.

use glam::DVec2;
use serde::Serialize;
use underbrush_recording::math;

use super::fit::{Fit, residual_m2};

/// Compliances that are compared, m/N: evenly spaced on a logarithmic scale.
const COMPLIANCES: usize = 61;
const LEAST_M_PER_N: f64 = 2e-5;
const MOST_M_PER_N: f64 = 0.2;
/// Mean and standard deviation of the logarithm of a compliance before anything is felt, in m/N. Choice: from a post that
/// hardly gives way to a soft leaf lie two of these deviations to each side.
const PRIOR: (f64, f64) = (2e-3, 1.5);
/// Mean and standard deviation of the radius of a touched surface before anything is felt, m. Choice: leaves to thick rolls.
const RADIUS_M: (f64, f64) = (0.015, 0.02);
/// Error of a place, m: the taxels are 1 cm apart, and a force rarely acts in the middle of one.
const PLACE_M: f64 = 3e-3;
/// Samples of the path that tell as much as one independent place. Choice, on 56 branches, stalks and rolls of seed 71000: the
/// path of a contact departs from that of a linear spring for seconds.
const SAMPLES: f64 = 300.0;
/// The tails of the posterior from which the interval is stretched, and by how much, on a logarithmic scale. Calibrated on 108
/// stalks, poles and rolls of the auxiliary scenes (seed 72000), so that the interval holds the truth for 90 % of them.
const TAIL: f64 = 0.03;
const STRETCH: f64 = 1.6;
/// Error of the displacement from the first touch to the largest force: this much, m, and this share of it. Choice, on the
/// objects of seed 71000.
const DISPLACEMENT: (f64, f64) = (5e-3, 0.2);

/// An interval of an object's stiffness where it was touched: force over how far the touched surface had given way when the
/// force was largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stiffness {
    /// Lower end of an interval that is meant to hold the true stiffness in nine of ten cases, N/m.
    pub low_n_per_m: f64,
    /// The median, N/m.
    pub median_n_per_m: f64,
    /// Its upper end, N/m. An object that hardly gives way may be much stiffer than the median.
    pub high_n_per_m: f64,
}

impl Stiffness {
    /// From the path of the contacts and the place up to the largest force, each sample of the path with the same weight; `None`
    /// without samples.
    ///
    /// A round surface of radius r that gives way like a spring is touched at c = o − r n + C F n ([`Fit`]). The posterior of
    /// the compliance C is computed on a grid, with the most likely r and o for each C and the noise of the best fit. What it
    /// gave way from the first touch to the largest force, C times the difference of F n, counts beside the path.
    pub(super) fn of(path: &Fit, place: &Place) -> Option<Self> {
        let moments = path.moments()?;
        let changes = place.changes();
        let [nn, np, _, cn, ..] = moments;
        let count = (path.weight / SAMPLES).max(1.0);
        let step = math::ln(MOST_M_PER_N / LEAST_M_PER_N) / (COMPLIANCES - 1) as f64;
        let compliance = |index: usize| LEAST_M_PER_N * math::exp(step * index as f64);
        let mut noise_m2 = PLACE_M * PLACE_M;
        let mut likelihoods = [0.0; COMPLIANCES];
        // The noise of the best fit decides how much the prior of the radius counts; three rounds settle it.
        for _ in 0..3 {
            let ridge = noise_m2 / (count * RADIUS_M.1 * RADIUS_M.1);
            let mut least_m2 = f64::INFINITY;
            for (index, likelihood) in likelihoods.iter_mut().enumerate() {
                let c = compliance(index);
                let radius_m = (c * np - cn + ridge * RADIUS_M.0) / (nn + ridge);
                let left_m2 = residual_m2(moments, radius_m, c);
                least_m2 = least_m2.min(left_m2);
                let unlikely = (radius_m - RADIUS_M.0) / RADIUS_M.1;
                let rare = math::ln(c / PRIOR.0) / PRIOR.1;
                let off = changes.map_or(0.0, |[center, normal, force]| {
                    let moved = center + radius_m * normal;
                    let error_m = DISPLACEMENT.1 * moved.length();
                    (moved - c * force).length_squared() / (DISPLACEMENT.0 * DISPLACEMENT.0 + error_m * error_m)
                });
                // Two coordinates of each place.
                *likelihood =
                    -count * math::ln(left_m2 + PLACE_M * PLACE_M) - 0.5 * (unlikely * unlikely + rare * rare + off);
            }
            noise_m2 = least_m2 + PLACE_M * PLACE_M;
        }
        let best = likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights = likelihoods.map(|likelihood| math::exp(likelihood - best));
        let all: f64 = weights.iter().sum();
        let quantile = |share: f64| {
            let mut below = 0.0;
            for (index, weight) in weights.iter().enumerate() {
                if below + weight >= share * all {
                    let part = (share * all - below) / weight;
                    return compliance(index) * math::exp(step * (part - 0.5));
                }
                below += weight;
            }
            MOST_M_PER_N
        };
        let median_n_per_m = 1.0 / quantile(0.5);
        let stretched = |tail: f64| median_n_per_m * math::powf(1.0 / (quantile(tail) * median_n_per_m), STRETCH);
        Some(Stiffness { low_n_per_m: stretched(1.0 - TAIL), median_n_per_m, high_n_per_m: stretched(TAIL) })
    }
}

/// What an object has done so far under the skin's push.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mobility {
    /// It has not moved by more than 2 cm. Contacts with fixed posts seem to move by as much, or by more if contacts with other
    /// objects are taken for theirs.
    #[default]
    Holds,
    /// It has moved, and the force has not fallen since.
    GivesWay,
    /// It has moved, and came back by half or more when the force fell to a third.
    ComesBack,
    /// It has moved, and stayed there when the force fell.
    Stays,
}

/// A surface is taken to lie this far from the axis that is followed, m: as for the prior above.
const AXIS_M: f64 = RADIUS_M.0;
/// Samples with less force say little of the place, N.
const FELT_N: f64 = 0.15;
/// Places are means over about so many samples, weighted by force.
const MEAN_SAMPLES: f64 = 15.0;
/// Nine of ten fixed trunks seem to move by less, m, if all contacts are theirs (seed 71000).
const HOLDS_M: f64 = 0.02;

/// A mean over samples, weighted by force.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    weight_n: f64,
    /// Sums of force times place, times normal, and times force along the normal.
    sums: [DVec2; 3],
}

impl Mean {
    /// With one sample more, and the others counting `kept` times as much as before.
    fn with(&self, kept: f64, force_n: f64, [center_world, normal_world]: [DVec2; 2]) -> Mean {
        let own = [center_world, normal_world, force_n * normal_world];
        let sums = std::array::from_fn(|index| kept * self.sums[index] + force_n * own[index]);
        Mean { weight_n: kept * self.weight_n + force_n, sums }
    }

    fn of(&self) -> [DVec2; 3] {
        self.sums.map(|sum| sum / self.weight_n)
    }
}

/// Follows where an object is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    samples: f64,
    /// Of the first samples and of the last ones.
    first: Mean,
    last: Mean,
    farthest_m: f64,
    largest_n: f64,
    /// The last force, N.
    force_n: f64,
}

impl Place {
    /// Takes in the contacts of one frame: the centre of their force, its mean outward normal, both horizontally, and its sum.
    pub(super) fn push(&mut self, center_world: DVec2, normal_world: DVec2, force_n: f64) {
        self.force_n = force_n;
        if force_n < FELT_N {
            return;
        }
        self.samples += 1.0;
        let contact = [center_world, normal_world];
        if self.samples <= MEAN_SAMPLES {
            self.first = self.first.with(1.0, force_n, contact);
        }
        self.last = self.last.with(1.0 - 1.0 / MEAN_SAMPLES, force_n, contact);
        self.largest_n = self.largest_n.max(force_n);
        self.farthest_m = self.farthest_m.max(self.moved_m());
    }

    /// By how much the place of the contact, m, its normal, and the force on the object, N, have changed since it was first felt,
    /// horizontally.
    fn changes(&self) -> Option<[DVec2; 3]> {
        let (last, first) = (self.last.of(), self.first.of());
        (self.samples > MEAN_SAMPLES).then(|| std::array::from_fn(|index| last[index] - first[index]))
    }

    /// How far it is from where it was first felt, horizontally, m.
    pub(super) fn moved_m(&self) -> f64 {
        self.changes().map_or(0.0, |[center, normal, _]| (center + AXIS_M * normal).length())
    }

    pub(super) fn mobility(&self) -> Mobility {
        if self.farthest_m <= HOLDS_M {
            Mobility::Holds
        } else if self.force_n > self.largest_n / 3.0 {
            Mobility::GivesWay
        } else if self.moved_m() <= 0.5 * self.farthest_m {
            Mobility::ComesBack
        } else {
            Mobility::Stays
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The path of the contact with a round post of radius 3 cm that gives way by `compliance` times the force, along which the
    /// arm slides, with the places rounded to a grid of 5 mm.
    fn path(compliance_m_per_n: f64) -> (Fit, Place) {
        let (mut fit, mut all) = (Fit::default(), Place::default());
        for step in 0..300 {
            let angle = 0.004 * f64::from(step);
            let force_n = 0.2 + 4.0 * (0.005 * f64::from(step)).sin();
            let normal = DVec2::from_angle(angle);
            let place = DVec2::new(0.4, -0.2) - 0.03 * normal + compliance_m_per_n * force_n * normal;
            let place = (place / 0.005).round() * 0.005;
            fit.push(place, normal, force_n, 1.0);
            all.push(place, normal, force_n);
        }
        (fit, all)
    }

    /// Tests that the interval holds the stiffness of springy posts along which the arm slides.
    #[test]
    fn the_interval_holds_the_stiffness_of_a_springy_post() {
        for compliance_m_per_n in [2e-3, 5e-3, 2e-2] {
            let (path, place) = path(compliance_m_per_n);
            let found = Stiffness::of(&path, &place).unwrap();
            let truth = 1.0 / compliance_m_per_n;
            assert!(found.low_n_per_m < truth && truth < found.high_n_per_m, "{truth}: {found:?}");
            assert!((0.5..2.0).contains(&(found.median_n_per_m / truth)), "{truth}: {found:?}");
        }
    }

    /// Tests that a fixed post is stiffer than any that gives way visibly, and that nothing is known without samples.
    #[test]
    fn a_fixed_post_is_stiff() {
        let (path, place) = path(0.0);
        let found = Stiffness::of(&path, &place).unwrap();
        // One that gives way by two centimetres under these 4 N has 200 N/m.
        assert!(found.low_n_per_m > 200.0, "{found:?}");
        assert_eq!(Stiffness::of(&Fit::default(), &Place::default()), None);
    }

    /// A push that rises to 3 N while the object moves by 6 cm and falls while it moves back by this much, m.
    fn pushed(back_m: f64) -> Place {
        let mut place = Place::default();
        let mut push = |x: f64, force_n: f64| place.push(DVec2::new(x, 0.0), DVec2::X, force_n);
        for step in 0..=100 {
            push(0.0006 * f64::from(step), 0.2 + 0.028 * f64::from(step));
        }
        for step in 0..=100 {
            push(0.06 - 0.01 * back_m * f64::from(step), 3.0 - 0.025 * f64::from(step));
        }
        place
    }

    /// Tests the four kinds of mobility and the distance on known motions.
    #[test]
    fn an_object_that_comes_back_is_told_from_one_that_stays() {
        assert_eq!(pushed(0.06).mobility(), Mobility::ComesBack);
        assert_eq!(pushed(0.0).mobility(), Mobility::Stays);
        assert!((pushed(0.0).moved_m() - 0.06).abs() < 0.01);
        let mut place = Place::default();
        for step in 0..60 {
            assert_eq!(place.mobility(), Mobility::Holds);
            place.push(DVec2::new(0.0002 * f64::from(step), 0.0), DVec2::X, 1.0);
        }
        for step in 0..60 {
            place.push(DVec2::new(0.012 + 0.001 * f64::from(step), 0.0), DVec2::X, 1.5);
        }
        assert_eq!(place.mobility(), Mobility::GivesWay);
    }
}
