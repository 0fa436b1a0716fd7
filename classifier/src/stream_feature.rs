//! Features of a contact so far, updated sample by sample: what a classifier can know while the contact lasts.
//!
//! All are recursive: a sample costs the same whether it is the second or the thousandth, and none looks ahead. Forces,
//! motions and rates span decades, from grazes to full contacts, so they enter on a logarithmic scale (see `compress`).

use serde::{Deserialize, Serialize};
use underbrush_recording::{Sample, Trial};

use crate::feature::FeatureError;

/// Which features.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StreamFeatureSet {
    /// What the taxel (or the component) feels by itself: force and contact motion.
    Taxel,
    /// And the contact region that it is part of at the same instant ([`underbrush_recording::Region`]).
    TaxelAndRegion,
}

/// Names of the features, in order; the first [`TAXEL_FEATURES`] need no region.
pub const NAMES: [&str; 27] = [
    "samples",
    "force",
    "first force",
    "largest force",
    "mean force",
    "deviation of force",
    "variation of force per second",
    "largest step of force",
    "slope of force over time",
    "slope of force over motion",
    "motion",
    "largest motion",
    "path per second",
    "slope of region's largest force over time",
    "slope of region's largest force over motion",
    "region's largest force",
    "first region's largest force",
    "largest region's largest force",
    "mean region's largest force",
    "deviation of region's largest force",
    "variation of region's largest force per second",
    "region's taxels",
    "mean region's taxels",
    "largest region's taxels",
    "region's force",
    "mean region's force",
    "mean share of region's largest force",
];

/// How many features [`StreamFeatureSet::Taxel`] has.
pub const TAXEL_FEATURES: usize = 13;

/// Below these, differences count in full; above, as their logarithm. Choice: forces about the threshold of contact,
/// motions about a tenth of a millimetre, rates what such differences make from one sample to the next at 100 Hz, slopes
/// over motion about the least stiffness of a leaf.
const FORCE_KNEE_N: f64 = 0.1;
const MOTION_KNEE_M: f64 = 1e-4;
const FORCE_RATE_KNEE_N_PER_S: f64 = 10.0;
const FORCE_SLOPE_KNEE_N_PER_S: f64 = 0.1;
const SPEED_KNEE_M_PER_S: f64 = 0.01;
const STIFFNESS_KNEE_N_PER_M: f64 = 10.0;

/// sign(x) ln(1 + |x| / knee).
fn compress(value: f64, knee: f64) -> f64 {
    value.signum() * (value.abs() / knee).ln_1p()
}

impl StreamFeatureSet {
    /// Number of features.
    pub fn dimension(self) -> usize {
        match self {
            StreamFeatureSet::Taxel => TAXEL_FEATURES,
            StreamFeatureSet::TaxelAndRegion => NAMES.len(),
        }
    }

    /// The features of a trial after each of these counts of samples (ascending, from 1; a count beyond the trial's
    /// length stands for all of it).
    ///
    /// # Errors
    /// [`FeatureError`] where the trial is empty, lacks motion or region, or holds NaN or infinity.
    pub fn after(self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, FeatureError> {
        let number = trial.trial;
        if trial.samples.is_empty() {
            return Err(FeatureError::Empty { trial: number });
        }
        let mut features = StreamFeatures::default();
        let mut found = Vec::with_capacity(counts.len());
        let mut taken = 0;
        for &count in counts {
            for sample in &trial.samples[taken..count.clamp(taken, trial.samples.len())] {
                self.check(number, taken, sample)?;
                features.push(sample);
                taken += 1;
            }
            found.push(features.values()[..self.dimension()].to_vec());
        }
        Ok(found)
    }

    fn check(self, trial: u64, index: usize, sample: &Sample) -> Result<(), FeatureError> {
        let motion_m = sample
            .motion_m
            .ok_or(FeatureError::MissingMotion { trial, sample: index })?;
        let mut numbers = vec![
            ("time_s", sample.time_s),
            ("force_n", sample.force_n),
            ("motion_m", motion_m),
        ];
        if self == StreamFeatureSet::TaxelAndRegion {
            let region = sample
                .region
                .ok_or(FeatureError::MissingRegion { trial, sample: index })?;
            numbers.push(("region_largest_force_n", region.largest_force_n));
            numbers.push(("region_force_sum_n", region.force_sum_n));
        }
        match numbers.into_iter().find(|(_, number)| !number.is_finite()) {
            None => Ok(()),
            Some((feature, value)) => Err(FeatureError::NotFinite {
                trial,
                sample: index,
                feature,
                value,
            }),
        }
    }
}

/// Mean and sum of squared deviations, sample by sample (Welford 1962, Technometrics 4).
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Takes in the `count`-th value; gives its deviation from the mean before.
    fn push(&mut self, count: f64, value: f64) -> f64 {
        let deviation = value - self.mean;
        self.mean += deviation / count;
        self.squares += deviation * (value - self.mean);
        deviation
    }
}

/// The course of a force.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    first: f64,
    last: f64,
    largest: f64,
    /// Σ |Δ force|, N.
    variation: f64,
    largest_step: f64,
    moments: Moments,
    /// Sums of products of deviations with those of time, N s, and of motion, N m.
    with_time: f64,
    with_motion: f64,
}

impl Course {
    fn push(&mut self, count: f64, force_n: f64, from_mean_time_s: f64, from_mean_motion_m: f64) {
        if count == 1.0 {
            (self.first, self.last, self.largest) = (force_n, force_n, force_n);
        }
        let step = (force_n - self.last).abs();
        self.variation += step;
        self.largest_step = self.largest_step.max(step);
        self.last = force_n;
        self.largest = self.largest.max(force_n);
        self.moments.push(count, force_n);
        self.with_time += from_mean_time_s * (force_n - self.moments.mean);
        self.with_motion += from_mean_motion_m * (force_n - self.moments.mean);
    }
}

/// The features of one contact; begins empty, and anew with each contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct StreamFeatures {
    count: f64,
    start_s: f64,
    elapsed_s: f64,
    motion_m: f64,
    largest_motion_m: f64,
    path_m: f64,
    time: Moments,
    motion: Moments,
    force: Course,
    region: Course,
    taxels: f64,
    largest_taxels: f64,
    mean_taxels: f64,
    sum_n: f64,
    mean_sum_n: f64,
    mean_share: f64,
}

impl StreamFeatures {
    /// Takes in the next sample. A motion or region that it lacks counts as none; [`StreamFeatureSet::after`] refuses
    /// such samples where they matter.
    pub fn push(&mut self, sample: &Sample) {
        self.count += 1.0;
        let count = self.count;
        let motion_m = sample.motion_m.unwrap_or(0.0);
        if count == 1.0 {
            self.start_s = sample.time_s;
            self.motion_m = motion_m;
        }
        self.elapsed_s = sample.time_s - self.start_s;
        self.path_m += (motion_m - self.motion_m).abs();
        self.motion_m = motion_m;
        self.largest_motion_m = self.largest_motion_m.max(motion_m);
        let from_mean_time_s = self.time.push(count, self.elapsed_s);
        let from_mean_motion_m = self.motion.push(count, motion_m);
        self.force
            .push(count, sample.force_n, from_mean_time_s, from_mean_motion_m);
        let Some(region) = sample.region else { return };
        let largest_n = region.largest_force_n;
        self.region.push(count, largest_n, from_mean_time_s, from_mean_motion_m);
        self.taxels = f64::from(region.taxels);
        self.largest_taxels = self.largest_taxels.max(self.taxels);
        self.mean_taxels += (self.taxels - self.mean_taxels) / count;
        self.sum_n = region.force_sum_n;
        self.mean_sum_n += (self.sum_n - self.mean_sum_n) / count;
        let share = if largest_n > 0.0 {
            sample.force_n / largest_n
        } else {
            0.0
        };
        self.mean_share += (share - self.mean_share) / count;
    }

    /// The features of the samples so far, in the order of [`NAMES`]; zeros before the first.
    pub fn values(&self) -> [f64; NAMES.len()] {
        let count = self.count.max(1.0);
        let per_second = |sum: f64| {
            if self.elapsed_s > 0.0 {
                sum / self.elapsed_s
            } else {
                0.0
            }
        };
        let force = |newtons: f64| compress(newtons, FORCE_KNEE_N);
        let rate = |course: &Course| compress(per_second(course.variation), FORCE_RATE_KNEE_N_PER_S);
        let over_time = |course: &Course| {
            let slope = if self.time.squares > 0.0 {
                course.with_time / self.time.squares
            } else {
                0.0
            };
            compress(slope, FORCE_SLOPE_KNEE_N_PER_S)
        };
        let over_motion = |course: &Course| {
            // A knee's worth of motion as noise: a taxel that rests has no stiffness to show.
            let squares = self.motion.squares + count * MOTION_KNEE_M * MOTION_KNEE_M;
            compress(course.with_motion / squares, STIFFNESS_KNEE_N_PER_M)
        };
        let deviation = |course: &Course| force((course.moments.squares.max(0.0) / count).sqrt());
        let motion = |metres: f64| compress(metres, MOTION_KNEE_M);
        [
            count.ln(),
            force(self.force.last),
            force(self.force.first),
            force(self.force.largest),
            force(self.force.moments.mean),
            deviation(&self.force),
            rate(&self.force),
            force(self.force.largest_step),
            over_time(&self.force),
            over_motion(&self.force),
            motion(self.motion_m),
            motion(self.largest_motion_m),
            compress(per_second(self.path_m), SPEED_KNEE_M_PER_S),
            over_time(&self.region),
            over_motion(&self.region),
            force(self.region.last),
            force(self.region.first),
            force(self.region.largest),
            force(self.region.moments.mean),
            deviation(&self.region),
            rate(&self.region),
            self.taxels.ln_1p(),
            self.mean_taxels.ln_1p(),
            self.largest_taxels.ln_1p(),
            force(self.sum_n),
            force(self.mean_sum_n),
            self.mean_share,
        ]
    }
}

#[cfg(test)]
mod tests;
