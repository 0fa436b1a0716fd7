//! Training rows from recordings with ground truth.

use underbrush_recording::Recording;

use super::compress::compress;
use super::contact_history::REGION_FEATURE_COUNT;
use super::frame::{SkinTracker, TAXEL_FEATURE_COUNT, TaxelCourse, TouchOptions};
use super::network::Row;
use super::object::{Followed, ObjectExample, ObjectTracker, Open, Votes, add_votes, strongest};
use super::region::Region;
use crate::estimator::is_trained;
use crate::trial::{TrialError, require_truth};

/// Contacts give a row after each of these numbers of samples, so that verdicts on the beginning of a contact are
/// learned as well.
const EARLY_SAMPLES: [usize; 6] = [1, 2, 3, 5, 10, 20];
/// In addition, every frame whose index is a multiple of this gives rows.
const EVERY: usize = 10;

/// A taxel in contact in one frame.
#[derive(Clone, Debug)]
pub(super) struct TaxelExample {
    /// The row for the network that tells touches from spurious readings: its class is 1 if an object presses on the taxel.
    pub(super) row: Row<TAXEL_FEATURE_COUNT>,
    /// Whether the index of the frame is a multiple of [`EVERY`]. These rows are an unbiased sample of all frames.
    pub(super) is_regular: bool,
}

/// A touched region in one frame.
#[derive(Clone, Debug)]
pub(super) struct RegionExample {
    pub(super) features: [f64; REGION_FEATURE_COUNT],
    pub(super) category: String,
    /// Number of its taxels that an object presses on.
    pub(super) touched: usize,
    pub(super) is_regular: bool,
}

impl RegionExample {
    /// The row for the network that tells these categories apart.
    pub(super) fn row(&self, categories: &[String]) -> Row<REGION_FEATURE_COUNT> {
        let class = categories.iter().position(|own| *own == self.category).unwrap_or_default();
        Row { features: self.features, class, weight: self.touched as f64 }
    }
}

/// The rows of one recording.
#[derive(Clone, Debug, Default)]
pub(super) struct Examples {
    pub(super) taxels: Vec<TaxelExample>,
    pub(super) regions: Vec<RegionExample>,
    pub(super) objects: Vec<ObjectExample>,
}

impl Examples {
    /// The rows of a recording. Contacts with categories that are not trained count as touched, and have no region
    /// rows.
    pub(super) fn of(recording: &Recording, options: &TouchOptions) -> Result<Self, TrialError> {
        require_truth(recording)?;
        let mut patches = SkinTracker::of_patches(&recording.layout, options)?;
        let (mut tracker, mut objects) = (ObjectTracker::default(), Followed::<Open>::default());
        let mut examples = Examples::default();
        for (index, frame) in recording.frames.iter().enumerate() {
            for patch in &mut patches {
                patch.update(frame)?;
                examples.add(patch, index, recording);
            }
            tracker.update(&patches, frame.time_s);
            objects.learn(&patches, &tracker, index);
        }
        examples.objects = objects.examples(recording);
        Ok(examples)
    }

    /// Adds the rows of a patch in the frame that its tracker has followed last.
    fn add(&mut self, tracker: &SkinTracker, index: usize, recording: &Recording) {
        for region in tracker.regions() {
            let is_regular = index.is_multiple_of(EVERY);
            let samples = region.course.samples();
            if (is_regular || EARLY_SAMPLES.contains(&samples))
                && let Some(category) = truth(tracker, region, recording)
                && is_trained(&category)
            {
                let features = region.course.features();
                let touched = tracker.taxels(region).iter().filter(|taxel| tracker.image.is_touched(**taxel)).count();
                self.regions.push(RegionExample { features, category, touched, is_regular });
            }
            for &taxel in tracker.taxels(region) {
                if (is_regular || EARLY_SAMPLES.contains(&tracker.samples(taxel)))
                    && let Some(values) = tracker.taxel_values(taxel, region)
                {
                    let features = compress(values, &TaxelCourse::KNEES);
                    let class = usize::from(tracker.image.is_touched(taxel));
                    self.taxels.push(TaxelExample { row: Row { features, class, weight: 1.0 }, is_regular });
                }
            }
        }
    }
}

/// Ground truth: the category of the object whose taxels have most of a region's force; `None` if nothing presses on
/// the region.
fn truth(tracker: &SkinTracker, region: &Region, recording: &Recording) -> Option<String> {
    let mut votes = Votes::new();
    add_votes(&mut votes, tracker, region);
    strongest(&votes, recording).map(|(.., category)| category.name().to_owned())
}
