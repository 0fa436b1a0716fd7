//! What one taxel has felt since its contact began, to tell a touch from a spurious reading.

use super::compress::{compress, compress_count};
use super::course::Course;

/// Names of the features of a taxel, in order.
pub const TAXEL_FEATURES: [&str; 16] = [
    "samples",
    "force",
    "first force",
    "largest force so far",
    "mean force",
    "deviation of force",
    "recent change of force",
    "force over largest force",
    "share of the region's strongest taxel",
    "force of the strongest neighbour",
    "taxels in the region",
    "force in the region",
    "way of the skin",
    "way of the skin in the region's contact",
    "recent change of the region's force",
    "slope of force over press",
];

/// Number of features of a taxel.
pub const TAXEL_FEATURE_COUNT: usize = TAXEL_FEATURES.len();

/// As for regions; changes of a steady reading are noise of some millinewtons.
const FORCE_KNEE_N: f64 = 0.05;
const CHANGE_KNEE_N: f64 = 0.002;
const MOTION_KNEE_M: f64 = 5e-4;
const STIFFNESS_KNEE_N_PER_M: f64 = 10.0;
const RECENT_SHARE: f64 = 0.1;

/// Running statistics of a taxel.
#[derive(Clone, Copy, Debug, Default)]
pub struct TaxelCourse {
    count: f64,
    first_n: f64,
    last_n: f64,
    largest_n: f64,
    mean_n: f64,
    squares: f64,
    change_n: f64,
    press_m: f64,
    way_m: f64,
    press_squares: f64,
    force_press: f64,
    press_mean_m: f64,
}

impl TaxelCourse {
    /// Number of samples since the taxel's contact began.
    pub fn samples(&self) -> usize {
        self.count as usize
    }

    /// Adds a sample: force, and how far the skin moved along its outward normal and altogether since the last frame.
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
        let deviation = force_n - self.mean_n;
        self.mean_n += deviation / self.count;
        self.squares += deviation * (force_n - self.mean_n);
        let press_deviation = self.press_m - self.press_mean_m;
        self.press_mean_m += press_deviation / self.count;
        self.press_squares += press_deviation * (self.press_m - self.press_mean_m);
        self.force_press += press_deviation * (force_n - self.mean_n);
    }

    /// The features of the taxel's contact so far, in the order of [`TAXEL_FEATURES`], within its region.
    pub fn features(&self, region: &Course, strongest_neighbour_n: f64) -> [f64; TAXEL_FEATURE_COUNT] {
        let force = |newtons: f64| compress(newtons, FORCE_KNEE_N);
        let motion = |metres: f64| compress(metres, MOTION_KNEE_M);
        let now = region.now();
        [
            compress_count(self.count),
            force(self.last_n),
            force(self.first_n),
            force(self.largest_n),
            force(self.mean_n),
            compress((self.squares.max(0.0) / self.count.max(1.0)).sqrt(), CHANGE_KNEE_N),
            compress(self.change_n, CHANGE_KNEE_N),
            self.last_n / self.largest_n.max(f64::MIN_POSITIVE),
            self.last_n / now.largest_force_n.max(f64::MIN_POSITIVE),
            force(strongest_neighbour_n),
            compress_count(now.taxels),
            force(now.force_n),
            motion(self.way_m),
            motion(region.way_m()),
            region.roughness(),
            compress(
                self.force_press / (self.press_squares + self.count * MOTION_KNEE_M * MOTION_KNEE_M),
                STIFFNESS_KNEE_N_PER_M,
            ),
        ]
    }
}
