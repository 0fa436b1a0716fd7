//! Running statistics of one contact, and what such statistics are made of.

use underbrush_recording::{Sample, math};

use super::CHANNEL_FEATURES;
use crate::feature::{AREA, FORCE, Feature, MOTION, REGION_FORCE_SUM, REGION_MAX_FORCE};

/// Running mean and sum of squared deviations (Welford 1962, Technometrics 4).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub(crate) mean: f64,
    pub(crate) squares: f64,
}

impl Moments {
    /// Adds the `count`-th value and returns its deviation from the previous mean.
    pub(crate) fn push(&mut self, count: f64, value: f64) -> f64 {
        let deviation = value - self.mean;
        self.mean += deviation / count;
        self.squares += deviation * (value - self.mean);
        deviation
    }
}

/// A function that computes features, from a list with an entry for each: its name, what else is known of it, and how it is
/// computed. The names and what else is known become constants beside the function.
macro_rules! features {
    (
        $(#[$column_doc:meta])* const $column:ident: $known:ty;
        $(#[$doc:meta])* $vis:vis fn values(&$this:ident $(, $argument:ident: $type:ty)* $(,)?) {
            $(let $local:pat = $first:expr;)*
            $(($name:literal, $of_name:expr, $value:expr),)*
        }
    ) => {
        /// Number of features.
        pub const COUNT: usize = [$($name),*].len();

        /// Names of the features, in order.
        pub const NAMES: [&'static str; Self::COUNT] = [$($name),*];

        $(#[$column_doc])*
        pub const $column: [$known; Self::COUNT] = [$($of_name),*];

        $(#[$doc])*
        $vis fn values(&$this $(, $argument: $type)*) -> [f64; Self::COUNT] {
            $(let $local = $first;)*
            [$($value),*]
        }
    };
}
pub(crate) use features;

/// Values well below a knee are only multiplied by a factor; values above it are compressed logarithmically. Choice:
/// forces near the contact threshold, motions of a tenth of a millimetre, rates that such changes give between two
/// samples at 100 Hz, and for slopes over motion the stiffness of the softest leaves.
const FORCE_KNEE_N: f64 = 0.1;
const MOTION_KNEE_M: f64 = 1e-4;
const FORCE_RATE_KNEE_N_PER_S: f64 = 10.0;
const FORCE_SLOPE_KNEE_N_PER_S: f64 = 0.1;
const SPEED_KNEE_M_PER_S: f64 = 0.01;
const STIFFNESS_KNEE_N_PER_M: f64 = 10.0;

/// sign(x) ln(1 + |x| / knee).
fn compress(value: f64, knee: f64) -> f64 {
    value.signum() * math::ln_1p(value.abs() / knee)
}

/// Running statistics of a force, or of a channel in its own unit, whose sign and scale mean something that is not known
/// here.
#[derive(Clone, Copy, Debug, Default)]
struct ValueCourse {
    last: f64,
    first: f64,
    largest: f64,
    smallest: f64,
    moments: Moments,
}

impl ValueCourse {
    /// Adds the `count`-th value and returns its difference from the last one, 0 for the first.
    fn push(&mut self, count: f64, value: f64) -> f64 {
        if count == 1.0 {
            *self = ValueCourse { last: value, first: value, largest: value, smallest: value, ..*self };
        }
        let step = value - self.last;
        self.last = value;
        self.largest = self.largest.max(value);
        self.smallest = self.smallest.min(value);
        self.moments.push(count, value);
        step
    }
}

/// Running statistics of a force.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    value: ValueCourse,
    /// Σ |Δ force|, N.
    variation: f64,
    largest_step: f64,
    /// Sums of the products of the force's deviations with those of time, N s, and of motion, N m.
    with_time: f64,
    with_motion: f64,
}

impl Course {
    fn push(&mut self, count: f64, force_n: f64, from_mean_time_s: f64, from_mean_motion_m: f64) {
        let step = self.value.push(count, force_n).abs();
        self.variation += step;
        self.largest_step = self.largest_step.max(step);
        self.with_time += from_mean_time_s * (force_n - self.value.moments.mean);
        self.with_motion += from_mean_motion_m * (force_n - self.value.moments.mean);
    }
}

/// Running statistics of one contact; empty before its first sample.
#[derive(Clone, Debug, Default)]
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
    channels: Vec<ValueCourse>,
}

impl StreamFeatures {
    /// Adds the next sample and its numbers in some channels, which are the same for all samples. Missing motion counts as
    /// zero and a missing region is skipped: a `Selection` refuses such samples if a selected feature depends on them.
    pub fn push(&mut self, sample: &Sample, channels: impl ExactSizeIterator<Item = f64>) {
        self.count += 1.0;
        let count = self.count;
        self.channels.resize_with(channels.len(), ValueCourse::default);
        for (course, number) in self.channels.iter_mut().zip(channels) {
            course.push(count, number);
        }
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
        self.force.push(count, sample.force_n, from_mean_time_s, from_mean_motion_m);
        let Some(region) = sample.region else { return };
        let largest_n = region.largest_force_n;
        self.region.push(count, largest_n, from_mean_time_s, from_mean_motion_m);
        self.taxels = f64::from(region.taxels);
        self.largest_taxels = self.largest_taxels.max(self.taxels);
        self.mean_taxels += (self.taxels - self.mean_taxels) / count;
        self.sum_n = region.force_sum_n;
        self.mean_sum_n += (self.sum_n - self.mean_sum_n) / count;
        let share = if largest_n > 0.0 { sample.force_n / largest_n } else { 0.0 };
        self.mean_share += (share - self.mean_share) / count;
    }

    /// The stream features of each channel after the samples so far, in the order of [`CHANNEL_FEATURES`].
    pub fn channels(&self) -> impl Iterator<Item = [f64; CHANNEL_FEATURES.len()]> {
        let count = self.count.max(1.0);
        self.channels.iter().map(move |course| {
            let deviation = (course.moments.squares.max(0.0) / count).sqrt();
            [course.last, course.first, course.largest, course.smallest, course.moments.mean, deviation]
        })
    }

    features! {
        /// The features of a sample that each is computed from.
        const NEEDED: &'static [&'static Feature];
        /// All stream features after the samples so far, in the order of [`StreamFeatures::NAMES`]; zeros before the first
        /// sample.
        pub fn values(&self) {
            let count = self.count.max(1.0);
            let per_second = |sum: f64| {
                if self.elapsed_s > 0.0 { sum / self.elapsed_s } else { 0.0 }
            };
            let force = |newtons: f64| compress(newtons, FORCE_KNEE_N);
            let rate = |course: &Course| compress(per_second(course.variation), FORCE_RATE_KNEE_N_PER_S);
            let over_time = |course: &Course| {
                let slope = if self.time.squares > 0.0 { course.with_time / self.time.squares } else { 0.0 };
                compress(slope, FORCE_SLOPE_KNEE_N_PER_S)
            };
            let over_motion = |course: &Course| {
                // Treats one knee of motion as noise, so that a taxel at rest gets no stiffness.
                let squares = self.motion.squares + count * MOTION_KNEE_M * MOTION_KNEE_M;
                compress(course.with_motion / squares, STIFFNESS_KNEE_N_PER_M)
            };
            let deviation = |course: &Course| force((course.value.moments.squares.max(0.0) / count).sqrt());
            let motion = |metres: f64| compress(metres, MOTION_KNEE_M);
            ("samples", &[], math::ln(count)),
            ("force", &[&FORCE], force(self.force.value.last)),
            ("first force", &[&FORCE], force(self.force.value.first)),
            ("largest force", &[&FORCE], force(self.force.value.largest)),
            ("mean force", &[&FORCE], force(self.force.value.moments.mean)),
            ("deviation of force", &[&FORCE], deviation(&self.force)),
            ("variation of force per second", &[&FORCE], rate(&self.force)),
            ("largest step of force", &[&FORCE], force(self.force.largest_step)),
            ("slope of force over time", &[&FORCE], over_time(&self.force)),
            ("slope of force over motion", &[&FORCE, &MOTION], over_motion(&self.force)),
            ("motion", &[&MOTION], motion(self.motion_m)),
            ("largest motion", &[&MOTION], motion(self.largest_motion_m)),
            ("path per second", &[&MOTION], compress(per_second(self.path_m), SPEED_KNEE_M_PER_S)),
            ("slope of region's largest force over time", &[&REGION_MAX_FORCE], over_time(&self.region)),
            ("slope of region's largest force over motion", &[&REGION_MAX_FORCE, &MOTION], over_motion(&self.region)),
            ("region's largest force", &[&REGION_MAX_FORCE], force(self.region.value.last)),
            ("first region's largest force", &[&REGION_MAX_FORCE], force(self.region.value.first)),
            ("largest region's largest force", &[&REGION_MAX_FORCE], force(self.region.value.largest)),
            ("mean region's largest force", &[&REGION_MAX_FORCE], force(self.region.value.moments.mean)),
            ("deviation of region's largest force", &[&REGION_MAX_FORCE], deviation(&self.region)),
            ("variation of region's largest force per second", &[&REGION_MAX_FORCE], rate(&self.region)),
            ("region's taxels", &[&AREA], math::ln_1p(self.taxels)),
            ("mean region's taxels", &[&AREA], math::ln_1p(self.mean_taxels)),
            ("largest region's taxels", &[&AREA], math::ln_1p(self.largest_taxels)),
            ("region's force", &[&REGION_FORCE_SUM], force(self.sum_n)),
            ("mean region's force", &[&REGION_FORCE_SUM], force(self.mean_sum_n)),
            ("mean share of region's largest force", &[&FORCE, &REGION_MAX_FORCE], self.mean_share),
        }
    }
}
