//! What the skin has sensed of an object.

use glam::DVec3;

use super::fit::Fit;
use super::resistance::{Mobility, Place, Stiffness};
use super::response::{RESPONSE_FEATURE_COUNT, Response};
use crate::stream_feature::features;
use crate::touch::compress::{COUNT_KNEE, PLAIN, compress};
use crate::touch::contact_history::{
    Course, MOTION_KNEE_M, Measure, REGION_FEATURE_COUNT, STIFFNESS_KNEE_N_PER_M, WORK_KNEE_J,
};

/// Lower ends of the levels of force at which the shape of the contact is described, N.
const LEVELS_N: [f64; 4] = [0.1, 0.3, 0.8, 2.0];
/// What is described at each level, and its knee: taxels, the share of the strongest one, extent, press.
const OF_LEVEL: [f64; 4] = [COUNT_KNEE, PLAIN, MOTION_KNEE_M, MOTION_KNEE_M];
/// Stands for a level that was not reached. What is described at a level is larger: taxels, shares and extents are positive, and
/// presses are far below 1 m.
const NOT_REACHED: f64 = -1.0;
/// The knee of compliances, m/N; see those of regions.
const COMPLIANCE_KNEE_M_PER_N: f64 = 1e-3;
/// A force is steady while it changes by less than this in a frame: this share of it, and this much, N.
const STEADY: (f64, f64) = (0.02, 0.005);

/// Number of features of an object: those of all its contacts together, those of its strongest contact, the shape of the
/// contact at each level of force, some of its own, and how it answers to the skin.
pub const OBJECT_FEATURE_COUNT: usize =
    2 * REGION_FEATURE_COUNT + LEVELS_N.len() * OF_LEVEL.len() + ObjectCourse::COUNT + RESPONSE_FEATURE_COUNT;

/// What the skin senses of an object in one frame: its contacts together, and the strongest one.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObjectMeasure {
    /// The contacts together; sums that are weighted by force until [`ObjectMeasure::total`] divides them.
    sum: Measure,
    squares_m2: f64,
    /// Number of contacts in this frame.
    pub(super) contacts: f64,
    span_m: f64,
    strongest: Course,
    /// The contacts, each with the same weight.
    path: Fit,
}

impl ObjectMeasure {
    pub(super) fn add(&mut self, contact: &Course) {
        let now = &contact.now;
        if self.contacts > 0.0 {
            self.span_m = self.span_m.max(now.center_world.distance(self.sum.center_world / self.sum.force_n));
        }
        self.contacts += 1.0;
        self.path.push(now.center_world.truncate(), now.normal_world.truncate(), now.force_n, 1.0);
        self.sum.taxels += now.taxels;
        self.sum.largest_force_n = self.sum.largest_force_n.max(now.largest_force_n);
        self.sum.force_n += now.force_n;
        self.sum.press_m += now.force_n * now.press_m;
        self.sum.slide_m += now.force_n * now.slide_m;
        self.sum.center_world += now.force_n * now.center_world;
        self.sum.normal_world += now.force_n * now.normal_world;
        self.squares_m2 += now.force_n * (now.extent_m * now.extent_m + now.center_world.length_squared());
        if now.force_n > self.strongest.now.force_n {
            self.strongest = *contact;
        }
    }

    fn total(&self) -> Measure {
        let force_n = self.sum.force_n;
        let center_world = self.sum.center_world / force_n;
        Measure {
            press_m: self.sum.press_m / force_n,
            slide_m: self.sum.slide_m / force_n,
            extent_m: (self.squares_m2 / force_n - center_world.length_squared()).max(0.0).sqrt(),
            center_link: DVec3::ZERO,
            center_world,
            normal_world: self.sum.normal_world / force_n,
            ..self.sum
        }
    }
}

/// Running statistics of an object.
#[derive(Clone, Copy, Debug, Default)]
pub struct ObjectCourse {
    all: Course,
    strongest: Course,
    samples: usize,
    /// Sums over the samples of each level, and their number.
    levels: [([f64; OF_LEVEL.len()], f64); LEVELS_N.len()],
    /// Squared steps of press, and products of steps of press and force, while loading and while unloading.
    slopes: [[f64; 2]; 2],
    /// Sums of force, press, their squares and their product.
    moments: [f64; 5],
    work_j: [f64; 2],
    steady_press_m: f64,
    steady: f64,
    /// Number of contacts so far.
    pub(super) contacts: f64,
    most_contacts: f64,
    span_m: f64,
    farthest_m: f64,
    impulse_ns: f64,
    circle: Fit,
    /// Every sample of every contact with the same weight: all of them, and those up to the largest force.
    path: Fit,
    path_to_largest: Fit,
    place: Place,
    place_at_largest: Place,
    response: Response,
}

impl ObjectCourse {
    /// Number of samples in which it was felt well enough to be judged.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Number of frames in which it touched the skin.
    pub fn frames(&self) -> usize {
        self.all.samples()
    }

    /// Sensed force in the last frame in which it touched the skin, N.
    pub fn force_n(&self) -> f64 {
        self.all.now.force_n
    }

    /// The largest of these forces so far, N.
    pub fn largest_force_n(&self) -> f64 {
        self.all.largest_force_n
    }

    /// Whether its force has never been larger than in the last frame in which it touched the skin.
    pub(in crate::touch) fn is_at_largest_force(&self) -> bool {
        self.force_n() >= self.largest_force_n()
    }

    /// Its stiffness where it was touched, when the force was largest; `None` before it was touched.
    pub fn stiffness(&self) -> Option<Stiffness> {
        Stiffness::of(&self.path_to_largest, &self.place_at_largest)
    }

    /// How far it is from where it was first felt, horizontally, m; within some 2 cm.
    pub fn moved_m(&self) -> f64 {
        self.place.moved_m()
    }

    /// What it has done so far under the push.
    pub fn mobility(&self) -> Mobility {
        self.place.mobility()
    }

    pub(super) fn push(&mut self, frame: &ObjectMeasure, time_s: f64, judged_n: f64) {
        let (before, last_s, largest_n, now) = (self.all.now, self.all.last_s, self.all.largest_force_n, frame.total());
        let force_n = now.force_n;
        self.all.push(&now, time_s);
        if self.frames() > 1 {
            let step_n = force_n - before.force_n;
            let [squares, products] = &mut self.slopes[usize::from(step_n < 0.0)];
            *squares += now.press_m * now.press_m;
            *products += now.press_m * step_n;
            self.work_j[usize::from(now.press_m < 0.0)] += 0.5 * (force_n + before.force_n) * now.press_m.abs();
            if step_n.abs() < STEADY.0 * force_n + STEADY.1 {
                self.steady_press_m += now.press_m;
                self.steady += 1.0;
            }
            self.impulse_ns += 0.5 * (force_n + before.force_n) * (time_s - last_s).clamp(0.0, 0.1);
        }
        let press_m = self.all.press_m;
        let moments = [force_n, press_m, force_n * force_n, press_m * press_m, force_n * press_m];
        self.moments.iter_mut().zip(moments).for_each(|(sum, value)| *sum += value);
        self.path.merge(&frame.path);
        self.place.push(now.center_world.truncate(), now.normal_world.truncate(), force_n);
        if force_n > largest_n {
            self.path_to_largest = self.path;
            self.place_at_largest = self.place;
        }
        if let Some(level) = LEVELS_N.iter().rposition(|level| force_n >= *level) {
            let (sums, count) = &mut self.levels[level];
            let values = [now.taxels, now.largest_force_n / force_n, now.extent_m, press_m];
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            *count += 1.0;
        }
        self.samples += usize::from(force_n >= judged_n);
        self.most_contacts = self.most_contacts.max(frame.contacts);
        self.span_m = self.span_m.max(frame.span_m);
        self.farthest_m = self.farthest_m.max(now.center_world.distance(self.all.first_world));
        self.circle.push(now.center_world.truncate(), now.normal_world.truncate(), force_n, force_n);
        self.response.push(time_s, force_n, now.press_m, now.slide_m);
        self.strongest = frame.strongest;
    }

    /// The features of the object so far.
    pub fn features(&self) -> [f32; OBJECT_FEATURE_COUNT] {
        let of_levels = self.levels.map(|(sums, count)| {
            let means = sums.map(|sum| if count > 0.0 { sum / count } else { NOT_REACHED });
            compress(means, &OF_LEVEL)
        });
        let [all, strongest] = [self.all.features(), self.strongest.features()];
        let own = compress(self.values(), &ObjectCourse::KNEES);
        let response = self.response.features();
        let mut values = all.iter().chain(&strongest).chain(of_levels.iter().flatten()).chain(&own).chain(&response);
        std::array::from_fn(|_| values.next().copied().unwrap_or_default() as f32)
    }

    features! {
        /// The knees of the features of an object alone, in order.
        const KNEES: f64;
        /// Its own features, before they are compressed.
        fn values(&self) {
            let square = MOTION_KNEE_M * MOTION_KNEE_M;
            let slope = |[squares, products]: [f64; 2]| products / (squares + square);
            let count = self.frames().max(1) as f64;
            let [force, press, force_squares, press_squares, product] = self.moments.map(|sum| sum / count);
            let force_variance = (force_squares - force * force).max(1e-4);
            let compliance = (product - force * press) / force_variance;
            let left = press_squares - press * press - compliance * compliance * force_variance;
            let error = (left.max(0.0) / (force_variance * count)).sqrt();
            let [radius_m, compliance_m_per_n, residual_m, turn, path_m] = self.circle.found();
            ("slope of force over press while loading", STIFFNESS_KNEE_N_PER_M, slope(self.slopes[0])),
            ("slope of force over press while unloading", STIFFNESS_KNEE_N_PER_M, slope(self.slopes[1])),
            ("compliance", COMPLIANCE_KNEE_M_PER_N, compliance),
            ("standard error of the compliance", COMPLIANCE_KNEE_M_PER_N, error),
            ("work of the skin", WORK_KNEE_J, self.work_j[0]),
            ("work given back", WORK_KNEE_J, self.work_j[1]),
            ("share of the work given back", PLAIN, self.work_j[1] / (self.work_j[0] + WORK_KNEE_J)),
            ("press at steady force", MOTION_KNEE_M, self.steady_press_m),
            ("share of the time at steady force", PLAIN, self.steady / count),
            ("press since the largest force", MOTION_KNEE_M, self.all.press_m - self.all.press_at_largest_m),
            ("contacts so far", COUNT_KNEE, self.contacts),
            ("most contacts at once", COUNT_KNEE, self.most_contacts),
            ("largest distance between contacts", MOTION_KNEE_M, self.span_m),
            ("largest distance in the world", MOTION_KNEE_M, self.farthest_m),
            ("impulse", 0.1, self.impulse_ns),
            ("radius", MOTION_KNEE_M, radius_m),
            ("compliance of the circle", COMPLIANCE_KNEE_M_PER_N, compliance_m_per_n),
            ("residual of the circle", MOTION_KNEE_M, residual_m),
            ("turn of the normal", PLAIN, turn),
            ("path of the contact", MOTION_KNEE_M, path_m),
        }
    }
}
