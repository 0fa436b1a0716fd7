//! What one taxel has sensed since its contact began, to tell a touch from a spurious reading.

use super::compress::{COUNT_KNEE, PLAIN};
use super::contact_history::Course;
use crate::feature_table::features;
use crate::moments::Moments;

/// Knees as for regions. Changes of a steady reading are noise of about 2 mN.
const FORCE_KNEE_N: f64 = 0.05;
const CHANGE_KNEE_N: f64 = 0.002;
const MOTION_KNEE_M: f64 = 5e-4;
const STIFFNESS_KNEE_N_PER_M: f64 = 10.0;
const RECENT_SHARE: f64 = 0.1;

/// Names of the features of a taxel, in order.
pub const TAXEL_FEATURES: [&str; TAXEL_FEATURE_COUNT] = TaxelCourse::NAMES;

/// Number of features of a taxel.
pub const TAXEL_FEATURE_COUNT: usize = TaxelCourse::COUNT;

/// Running statistics of a taxel.
#[derive(Clone, Copy, Debug, Default)]
pub struct TaxelCourse {
    count: f64,
    first_n: f64,
    last_n: f64,
    largest_n: f64,
    force: Moments,
    change_n: f64,
    press_m: f64,
    way_m: f64,
    press: Moments,
    force_press: f64,
}

impl TaxelCourse {
    /// Number of samples since the taxel's contact began.
    pub fn samples(&self) -> usize {
        self.count as usize
    }

    /// Adds a sample: the force, and how far the skin moved since the last frame, along its outward normal (`press_m`)
    /// and in total (`way_m`).
    pub fn push(&mut self, force_n: f64, press_m: f64, way_m: f64) {
        self.count += 1.0;
        if self.count == 1.0 {
            self.first_n = force_n;
        } else {
            self.change_n += RECENT_SHARE * ((force_n - self.last_n).abs() - self.change_n);
            self.press_m += press_m;
            self.way_m += way_m;
        }
        self.last_n = force_n;
        self.largest_n = self.largest_n.max(force_n);
        self.force.push(self.count, force_n);
        let press_deviation = self.press.push(self.count, self.press_m);
        self.force_press += press_deviation * (force_n - self.force.mean);
    }

    features! {
        /// Their knees.
        const KNEES: f64;
        /// The features of the taxel's contact so far, in the order of [`TAXEL_FEATURES`], before they are compressed.
        /// `region` is the course of the region that the taxel belongs to.
        pub(super) fn values(&self, region: &Course, strongest_neighbour_n: f64) {
            let share = |part: f64, whole: f64| part / whole.max(f64::MIN_POSITIVE);
            let now = &region.now;
            let slope_n_per_m =
                self.force_press / (self.press.squares + self.count * MOTION_KNEE_M * MOTION_KNEE_M);
            ("samples", COUNT_KNEE, self.count),
            ("force", FORCE_KNEE_N, self.last_n),
            ("first force", FORCE_KNEE_N, self.first_n),
            ("largest force so far", FORCE_KNEE_N, self.largest_n),
            ("mean force", FORCE_KNEE_N, self.force.mean),
            ("deviation of force", CHANGE_KNEE_N, (self.force.squares.max(0.0) / self.count.max(1.0)).sqrt()),
            ("recent change of force", CHANGE_KNEE_N, self.change_n),
            ("force over largest force", PLAIN, share(self.last_n, self.largest_n)),
            ("share of the region's strongest taxel", PLAIN, share(self.last_n, now.largest_force_n)),
            ("force of the strongest neighbour", FORCE_KNEE_N, strongest_neighbour_n),
            ("taxels in the region", COUNT_KNEE, now.taxels),
            ("force in the region", FORCE_KNEE_N, now.force_n),
            ("way of the skin", MOTION_KNEE_M, self.way_m),
            ("way of the skin in the region's contact", MOTION_KNEE_M, region.way_m()),
            ("recent change of the region's force", PLAIN, region.roughness),
            ("slope of force over press", STIFFNESS_KNEE_N_PER_M, slope_n_per_m),
        }
    }
}
