//! How readings become contacts; what each taxel has sensed since its contact began, to tell a touch from a spurious reading;
//! and the taxels and regions of a patch, frame by frame.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Frame, Pose, SkinLayout};

use super::compress::{COUNT_KNEE, PLAIN};
use super::contact_history::{Course, MOTION_KNEE_M, STIFFNESS_KNEE_N_PER_M};
use super::region::{Motion, Region, RegionTracker};
use crate::stream_feature::{Moments, features};
use crate::trial::{PatchImage, TrialError, TrialOptions};

/// The patch, and the force above which a taxel is in contact.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TouchOptions {
    /// Name of the only patch that is judged. If left out, `all_patches` decides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch: Option<String>,
    /// Whether all patches are judged if none is named; else the skin's first is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub all_patches: bool,
    /// A taxel is in contact while its sensed force is above this, N.
    #[schemars(range(min = 0.0))]
    pub threshold_n: f64,
}

impl Default for TouchOptions {
    /// All patches, and the threshold of [`TrialOptions::default`].
    fn default() -> Self {
        TouchOptions::of(None, None)
    }
}

impl TouchOptions {
    /// The named patch, or all patches; and the force above which a taxel is in contact, N, or that of
    /// [`TrialOptions::default`].
    pub fn of(patch: Option<String>, threshold_n: Option<f64>) -> Self {
        let threshold_n = threshold_n.unwrap_or(TrialOptions::default().threshold_n);
        TouchOptions { all_patches: patch.is_none(), patch, threshold_n }
    }

    /// The indices of the patches that are judged; empty if the skin lacks the named one.
    pub fn judged_patches(&self, layout: &SkinLayout) -> Vec<usize> {
        match &self.patch {
            None if self.all_patches => (0..layout.patches.len()).collect(),
            patch => layout.chosen_patch(patch.as_deref()).into_iter().collect(),
        }
    }
}

/// Knees, beside those of regions. Changes of a steady reading are noise of about 2 mN.
const FORCE_KNEE_N: f64 = 0.05;
const CHANGE_KNEE_N: f64 = 0.002;
const RECENT_SHARE: f64 = 0.1;

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
        /// The knees of the features of a taxel, in order.
        const KNEES: f64;
        /// The features of the taxel's contact so far, in the order of [`Self::NAMES`], before they are compressed.
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

/// Follows taxels and regions of one patch. Nothing is allocated after the first frames.
#[derive(Clone, Debug)]
pub struct SkinTracker {
    /// The forces of the last frame.
    pub image: PatchImage,
    regions: RegionTracker,
    /// One per taxel; `None` without contact.
    courses: Vec<Option<TaxelCourse>>,
    pose_before: Option<Pose>,
}

impl SkinTracker {
    /// Follows the named patch, or the skin's first. A taxel is in contact while it senses more than `threshold_n`.
    ///
    /// # Errors
    /// [`TrialError`] if the patch is unknown, or the threshold is out of range.
    pub fn new(layout: &SkinLayout, patch: Option<&str>, threshold_n: f64) -> Result<Self, TrialError> {
        let image = PatchImage::new(layout, patch, threshold_n)?;
        Ok(SkinTracker {
            regions: RegionTracker::new(&image),
            courses: vec![None; image.patch().taxels.len()],
            image,
            pose_before: None,
        })
    }

    /// One for each patch that the options name.
    ///
    /// # Errors
    /// As [`SkinTracker::new`].
    pub fn of_patches(layout: &SkinLayout, options: &TouchOptions) -> Result<Vec<Self>, TrialError> {
        let new = |patch: Option<&str>| SkinTracker::new(layout, patch, options.threshold_n);
        match options.patch.as_deref() {
            None if options.all_patches && !layout.patches.is_empty() => {
                layout.patches.iter().map(|patch| new(Some(&patch.name))).collect()
            }
            patch => Ok(vec![new(patch)?]),
        }
    }

    /// Takes in the next frame.
    ///
    /// # Errors
    /// [`TrialError::BadFrame`] if the frame does not fit the skin or holds NaN or infinity.
    pub fn update(&mut self, frame: &Frame) -> Result<(), TrialError> {
        self.image.read(frame)?;
        let pose = self.image.pose_world();
        let motion = Motion::between(&self.pose_before.unwrap_or(pose), &pose);
        self.pose_before = Some(pose);
        self.regions.update(&self.image, &motion, frame.time_s);
        for (taxel, course) in self.courses.iter_mut().enumerate() {
            if !self.image.is_in_contact(taxel) {
                *course = None;
                continue;
            }
            let place = &self.image.patch().taxels[taxel];
            let moved = motion.of(place.position_link);
            let press_m = moved.dot(place.normal_link);
            course.get_or_insert_default().push(self.image.sensed_force_n(taxel), press_m, moved.length());
        }
        Ok(())
    }

    /// The regions of the last frame.
    pub fn regions(&self) -> &[Region] {
        &self.regions.regions
    }

    /// The taxels of a region of the last frame.
    pub fn taxels(&self, region: &Region) -> &[usize] {
        &self.regions.taxels[region.taxels.clone()]
    }

    /// Number of samples since a taxel's contact began; 0 without contact.
    pub fn samples(&self, taxel: usize) -> usize {
        self.courses[taxel].map_or(0, |course| course.samples())
    }

    /// The features of a taxel in contact, which belongs to this region, before they are compressed; `None` without contact.
    pub(super) fn taxel_values(&self, taxel: usize, region: &Region) -> Option<[f64; TAXEL_FEATURE_COUNT]> {
        let forces = self.regions.neighbours[taxel].iter().map(|other| self.image.sensed_force_n(*other));
        let strongest_n = forces.fold(0.0, f64::max);
        Some(self.courses[taxel].as_ref()?.values(&region.course, strongest_n))
    }
}
