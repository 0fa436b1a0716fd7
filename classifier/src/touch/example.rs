//! Training rows from recordings with ground truth.

use underbrush_recording::Recording;

use super::compress::compress;
use super::contact_history::REGION_FEATURE_COUNT;
use super::frame::SkinTracker;
use super::network::Row;
use super::object::{ObjectExample, ObjectExamples, ObjectTracker, Votes, category_of};
use super::options::TouchOptions;
use super::region::Region;
use super::taxel::{TAXEL_FEATURE_COUNT, TaxelCourse};
use crate::estimator::is_trained;
use crate::trial::TrialError;

/// Contacts give a row after each of these numbers of samples, so that verdicts on the beginning of a contact are
/// learned as well.
const EARLY_SAMPLES: [usize; 6] = [1, 2, 3, 5, 10, 20];
/// In addition, every frame whose index is a multiple of this gives rows.
const EVERY: usize = 10;

/// A taxel in contact in one frame.
#[derive(Clone, Debug)]
pub(super) struct TaxelExample {
    pub(super) features: [f64; TAXEL_FEATURE_COUNT],
    /// Whether an object presses on it.
    pub(super) is_touched: bool,
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

impl TaxelExample {
    /// The row for the network that tells touches from spurious readings.
    pub(super) fn row(&self) -> Row<TAXEL_FEATURE_COUNT> {
        Row { features: self.features, class: usize::from(self.is_touched), weight: 1.0 }
    }
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
        let mut patches = SkinTracker::of_patches(&recording.layout, options)?;
        let (mut tracker, mut objects) = (ObjectTracker::default(), ObjectExamples::default());
        let mut examples = Examples::default();
        for (index, frame) in recording.frames.iter().enumerate() {
            for patch in &mut patches {
                patch.update(frame)?;
                examples.add(patch, index, recording);
            }
            tracker.update(&patches, frame.time_s);
            objects.update(&patches, &tracker, index, recording);
        }
        examples.objects = objects.finish(recording);
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
                let taxels = tracker.taxels(region).iter();
                self.regions.push(RegionExample {
                    features: region.course.features(),
                    category,
                    touched: taxels.filter(|taxel| tracker.image.is_touched(**taxel)).count(),
                    is_regular,
                });
            }
            for &taxel in tracker.taxels(region) {
                if (is_regular || EARLY_SAMPLES.contains(&tracker.samples(taxel)))
                    && let Some(values) = tracker.taxel_values(taxel, region)
                {
                    self.taxels.push(TaxelExample {
                        features: compress(values, &TaxelCourse::KNEES),
                        is_touched: tracker.image.is_touched(taxel),
                        is_regular,
                    });
                }
            }
        }
    }
}

/// Ground truth: the category of the object whose taxels have most of a region's force; `None` if nothing presses on
/// the region.
fn truth(tracker: &SkinTracker, region: &Region, recording: &Recording) -> Option<String> {
    let image = &tracker.image;
    let mut forces = Votes::new();
    for &taxel in tracker.taxels(region) {
        if let Some(object) = image.object(taxel).filter(|_| image.is_touched(taxel)) {
            *forces.entry(object).or_default() += image.sensed_force_n(taxel);
        }
    }
    category_of(&forces, recording).map(|category| category.name().to_owned())
}
