//! What a contact region has sensed since its contact began.

use glam::DVec3;

use super::compress::{COUNT_KNEE, PLAIN, compress};
use crate::stream_feature::{Moments, features};
use underbrush_recording::math;

/// Forces and motion of a contact region in one frame. Motions are means over its taxels, weighted by their forces.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measure {
    /// Number of taxels.
    pub taxels: f64,
    /// Sum of the sensed forces, N.
    pub force_n: f64,
    /// The largest of the sensed forces, N.
    pub largest_force_n: f64,
    /// How far the skin moved along its outward normal since the last frame, m. The object that it touches must have
    /// given way by this much.
    pub press_m: f64,
    /// How far the skin moved sideways since the last frame, m.
    pub slide_m: f64,
    /// Standard deviation of the positions of the forces, m.
    pub extent_m: f64,
    /// Centre of the forces, link frame, m.
    pub center_link: DVec3,
    /// Centre of the forces, world frame, m.
    pub center_world: DVec3,
    /// Mean outward normal of the skin, world frame.
    pub normal_world: DVec3,
}

/// Values well below a knee are only multiplied by a factor; values above it are compressed logarithmically. Choices: a
/// contact force near the threshold, the motion of the arm in a frame, and the stiffness of the softest leaves.
pub(super) const FORCE_KNEE_N: f64 = 0.1;
pub(super) const MOTION_KNEE_M: f64 = 5e-4;
pub(super) const STIFFNESS_KNEE_N_PER_M: f64 = 10.0;
const RATE_KNEE_N_PER_S: f64 = 1.0;
const SPEED_KNEE_M_PER_S: f64 = 0.01;
pub(super) const WORK_KNEE_J: f64 = 1e-4;
/// Time constant of averages of the recent past, s. A verdict is wanted within a tenth of a second.
const RECENT_S: f64 = 0.1;
/// How many samples count as the beginning.
const FIRST_SAMPLES: f64 = 5.0;

/// Names of the features of a region, in order.
pub const REGION_FEATURES: [&str; REGION_FEATURE_COUNT] = Course::NAMES;

/// Number of features of a region.
pub const REGION_FEATURE_COUNT: usize = Course::COUNT;

/// Running statistics of a contact region.
#[derive(Clone, Copy, Debug, Default)]
pub struct Course {
    count: f64,
    start_s: f64,
    pub(super) last_s: f64,
    /// The last sample.
    pub now: Measure,
    first_force_n: f64,
    /// The largest force so far, N.
    pub(super) largest_force_n: f64,
    largest_taxel_force_n: f64,
    most_taxels: f64,
    pub(super) press_at_largest_m: f64,
    /// How far the skin has moved along its outward normal since the contact began, m.
    pub(super) press_m: f64,
    largest_press_m: f64,
    press_path_m: f64,
    slide_path_m: f64,
    skin_path_m: f64,
    first_link: DVec3,
    /// Where it began, m.
    pub(super) first_world: DVec3,
    work_j: f64,
    largest_step_n: f64,
    /// How much the force changed from sample to sample in the recent past, as a share of the force.
    pub(super) roughness: f64,
    first_press_m: f64,
    first_rise_n: f64,
    first_s: f64,
    force: Moments,
    press: Moments,
    time: Moments,
    /// Sums of the products of the deviations of force and press, and of force and time.
    force_press: f64,
    force_time: f64,
    /// Sums of squared steps of press, and of products of steps of press and force, in the recent past.
    recent_press_squares: f64,
    recent_force_press: f64,
}

impl Course {
    /// Number of samples since the contact began.
    pub fn samples(&self) -> usize {
        self.count as usize
    }

    /// Length of the skin's path along its normal plus the length of its path sideways, since the contact began, m.
    pub fn way_m(&self) -> f64 {
        self.press_path_m + self.slide_path_m
    }

    pub(super) fn push(&mut self, measure: &Measure, time_s: f64) {
        self.count += 1.0;
        let force_n = measure.force_n;
        let since_last_s = if self.count == 1.0 { 0.0 } else { (time_s - self.last_s).max(0.0) };
        if self.count == 1.0 {
            self.start_s = time_s;
            self.first_force_n = force_n;
            self.first_link = measure.center_link;
            self.first_world = measure.center_world;
        } else {
            let step_n = force_n - self.now.force_n;
            self.press_m += measure.press_m;
            self.press_path_m += measure.press_m.abs();
            self.slide_path_m += measure.slide_m;
            self.skin_path_m += measure.center_link.distance(self.now.center_link);
            self.work_j += 0.5 * (force_n + self.now.force_n) * measure.press_m;
            self.largest_step_n = self.largest_step_n.max(step_n.abs());
            let kept = math::exp(-since_last_s / RECENT_S);
            self.roughness = kept * self.roughness + (1.0 - kept) * step_n.abs() / (force_n + FORCE_KNEE_N);
            self.recent_press_squares = kept * self.recent_press_squares + measure.press_m * measure.press_m;
            self.recent_force_press = kept * self.recent_force_press + measure.press_m * step_n;
        }
        self.last_s = time_s;
        let elapsed_s = time_s - self.start_s;
        if force_n > self.largest_force_n {
            self.largest_force_n = force_n;
            self.press_at_largest_m = self.press_m;
        }
        self.largest_taxel_force_n = self.largest_taxel_force_n.max(measure.largest_force_n);
        self.most_taxels = self.most_taxels.max(measure.taxels);
        self.largest_press_m = self.largest_press_m.max(self.press_m);
        if self.count <= FIRST_SAMPLES {
            self.first_press_m = self.press_m;
            self.first_rise_n = force_n - self.first_force_n;
            self.first_s = elapsed_s;
        }
        self.force.push(self.count, force_n);
        let press_deviation = self.press.push(self.count, self.press_m);
        let time_deviation = self.time.push(self.count, elapsed_s);
        self.force_press += press_deviation * (force_n - self.force.mean);
        self.force_time += time_deviation * (force_n - self.force.mean);
        self.now = *measure;
    }

    /// The features of the contact so far, in the order of [`REGION_FEATURES`].
    pub fn features(&self) -> [f64; REGION_FEATURE_COUNT] {
        compress(self.values(), &Course::KNEES)
    }

    features! {
        /// The knees of the features of a region, in order.
        const KNEES: f64;
        /// The features before they are compressed.
        pub(super) fn values(&self) {
            let square = MOTION_KNEE_M * MOTION_KNEE_M;
            let per_time = |value: f64, time_s: f64| if time_s > 0.0 { value / time_s } else { 0.0 };
            let deviation_n = (self.force.squares.max(0.0) / self.count.max(1.0)).sqrt();
            let correlation = self.force_press
                / (self.force.squares.max(1e-6) * (self.press.squares + self.count * 1e-2 * square)).sqrt();
            let stiffness_n_per_m = self.largest_force_n / (self.press_at_largest_m.max(0.0) + MOTION_KNEE_M);
            let slope_n_per_m = self.force_press / (self.press.squares + self.count * square);
            let recent_n_per_m = self.recent_force_press / (self.recent_press_squares + square);
            ("samples", COUNT_KNEE, self.count),
            ("force", FORCE_KNEE_N, self.now.force_n),
            ("largest force so far", FORCE_KNEE_N, self.largest_force_n),
            ("mean force", FORCE_KNEE_N, self.force.mean),
            ("first force", FORCE_KNEE_N, self.first_force_n),
            ("taxel force", FORCE_KNEE_N, self.now.largest_force_n),
            ("largest taxel force so far", FORCE_KNEE_N, self.largest_taxel_force_n),
            ("taxels", COUNT_KNEE, self.now.taxels),
            ("most taxels so far", COUNT_KNEE, self.most_taxels),
            ("extent", MOTION_KNEE_M, self.now.extent_m),
            ("press", MOTION_KNEE_M, self.press_m),
            ("largest press so far", MOTION_KNEE_M, self.largest_press_m),
            ("path of press", MOTION_KNEE_M, self.press_path_m),
            ("path of slide", MOTION_KNEE_M, self.slide_path_m),
            ("path on the skin", MOTION_KNEE_M, self.skin_path_m),
            ("distance on the skin", MOTION_KNEE_M, self.now.center_link.distance(self.first_link)),
            ("distance in the world", MOTION_KNEE_M, self.now.center_world.distance(self.first_world)),
            ("stiffness at the largest force", STIFFNESS_KNEE_N_PER_M, stiffness_n_per_m),
            ("slope of force over press", STIFFNESS_KNEE_N_PER_M, slope_n_per_m),
            ("correlation of force and press", PLAIN, correlation),
            ("recent slope of force over press", STIFFNESS_KNEE_N_PER_M, recent_n_per_m),
            ("slope of force over time", RATE_KNEE_N_PER_S, per_time(self.force_time, self.time.squares)),
            ("recent roughness", PLAIN, self.roughness),
            ("largest step of force", FORCE_KNEE_N, self.largest_step_n),
            ("force over largest force", PLAIN, self.now.force_n / self.largest_force_n.max(f64::MIN_POSITIVE)),
            ("work", WORK_KNEE_J, self.work_j),
            ("variation of force", FORCE_KNEE_N, deviation_n),
            ("speed of press at first", SPEED_KNEE_M_PER_S, per_time(self.first_press_m, self.first_s)),
            ("rise of force at first", RATE_KNEE_N_PER_S, per_time(self.first_rise_n, self.first_s)),
            ("share of the strongest taxel", PLAIN, self.now.largest_force_n / self.now.force_n.max(f64::MIN_POSITIVE)),
        }
    }
}
