//! The features of all taxels and regions in contact, frame by frame.

use underbrush_recording::{Frame, Pose, SkinLayout};

use super::options::TouchOptions;
use super::region::{Motion, Region, RegionTracker};
use super::taxel::{TAXEL_FEATURE_COUNT, TaxelCourse};
use crate::trial::{PatchImage, TrialError};

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
