//! One patch in one frame, as an image of forces.

use glam::DVec3;
use underbrush_recording::{Frame, Patch, Pose, SkinLayout, TaxelReading};

use super::TrialError;
use crate::error::ValueFault;

/// The sensed forces and taxel positions of one patch in the most recently read frame. Reading does not allocate.
#[derive(Clone, Debug)]
pub struct PatchImage {
    patch_index: usize,
    patch: Patch,
    threshold_n: f64,
    /// One per taxel. Without a reading it senses nothing.
    taxels: Vec<TaxelReading>,
    pose_world: Pose,
    /// Number of frames so far.
    frames: usize,
}

impl PatchImage {
    /// An image of the named patch, or of the skin's first, with no taxel in contact yet. A taxel is in contact while
    /// it senses more than `threshold_n`.
    ///
    /// # Errors
    /// [`TrialError::UnknownPatch`], [`TrialError::NoPatch`] for a skin without any, or [`TrialError::BadOption`] for a
    /// threshold that is negative or not finite.
    pub fn new(layout: &SkinLayout, patch: Option<&str>, threshold_n: f64) -> Result<Self, TrialError> {
        if !threshold_n.is_finite() || threshold_n < 0.0 {
            let allowed = "a finite force from 0 N";
            return Err(ValueFault::new("threshold_n", threshold_n.to_string(), allowed).into());
        }
        let patch_index = layout.chosen_patch(patch).ok_or_else(|| match patch {
            Some(name) if !layout.patches.is_empty() => TrialError::UnknownPatch {
                found: name.to_owned(),
                known: layout.patches.iter().map(|patch| patch.name.clone()).collect(),
            },
            _ => TrialError::NoPatch,
        })?;
        let patch = layout.patches[patch_index].clone();
        let taxels = vec![TaxelReading::default(); patch.taxels.len()];
        Ok(PatchImage { patch_index, patch, threshold_n, taxels, pose_world: Pose::default(), frames: 0 })
    }

    /// Reads the next frame.
    ///
    /// # Errors
    /// [`TrialError::BadFrame`] if the frame has no pose for the patch, names a taxel that the patch does not have, or
    /// contains NaN or infinity.
    pub fn read(&mut self, frame: &Frame) -> Result<(), TrialError> {
        let index = self.frames;
        let bad = |found: String, allowed: String| TrialError::BadFrame { frame: index, found, allowed };
        let name = &self.patch.name;
        let pose = frame.patch_pose_world.get(self.patch_index).copied().ok_or_else(|| {
            let found = format!("{} patch poses, none for {name}", frame.patch_pose_world.len());
            bad(found, "a pose for each patch of the layout".into())
        })?;
        if !pose.position.is_finite() || !pose.orientation.is_finite() {
            return Err(bad(format!("pose {pose:?} of {name}"), "finite numbers".into()));
        }
        self.pose_world = pose;
        self.taxels.fill(TaxelReading::default());
        for reading in frame.taxels.iter().filter(|reading| usize::from(reading.patch) == self.patch_index) {
            let taxel = usize::from(reading.taxel);
            let count = self.taxels.len();
            let state = self.taxels.get_mut(taxel).ok_or_else(|| {
                bad(format!("taxel {taxel} of patch {name}"), format!("taxels 0 to {}", count.saturating_sub(1)))
            })?;
            if !reading.sensed_force_n.is_finite() {
                let found = format!("{} N sensed by taxel {taxel} of {name}", reading.sensed_force_n);
                return Err(bad(found, "finite forces".into()));
            }
            *state = *reading;
        }
        self.frames += 1;
        Ok(())
    }

    /// Index of the patch in the skin.
    pub fn patch_index(&self) -> usize {
        self.patch_index
    }

    /// The patch.
    pub fn patch(&self) -> &Patch {
        &self.patch
    }

    /// Whether a taxel is in contact; false for a taxel that the patch does not have.
    pub fn is_in_contact(&self, taxel: usize) -> bool {
        self.sensed_force_n(taxel) > self.threshold_n
    }

    /// The sensed force of a taxel, N; 0 for a taxel that the patch does not have.
    pub fn sensed_force_n(&self, taxel: usize) -> f64 {
        self.taxels.get(taxel).map_or(0.0, |own| own.sensed_force_n)
    }

    /// Ground truth: the object that presses hardest on a taxel.
    pub fn object(&self, taxel: usize) -> Option<u16> {
        self.taxels.get(taxel)?.object
    }

    /// Ground truth: whether an object presses on a taxel, however lightly.
    pub fn is_touched(&self, taxel: usize) -> bool {
        self.taxels.get(taxel).is_some_and(|own| own.true_normal_force_n > 0.0)
    }

    /// Ground truth: the object that presses hardest on a taxel; `None` if nothing does, however lightly.
    pub fn pressing(&self, taxel: usize) -> Option<u16> {
        self.object(taxel).filter(|_| self.is_touched(taxel))
    }

    /// Pose of the patch's link, world frame; the identity before the first frame is read.
    pub fn pose_world(&self) -> Pose {
        self.pose_world
    }

    /// Position of a taxel's centre, m, in the world frame; in the link frame before the first frame is read.
    ///
    /// # Panics
    /// If the patch has no such taxel.
    pub fn position_world(&self, taxel: usize) -> DVec3 {
        self.pose_world.transform_point(self.patch.taxels[taxel].position_link)
    }
}
