//! The contact regions of a touch model, frame by frame, as sections.

use std::ops::Range;

use underbrush_classifier::touch::{REGION_FEATURE_COUNT, SkinTracker, TaxelTouch, TouchClassifier};

use crate::container::Sections;

/// Contact regions. The regions of frame f are the rows `starts[f]` to `starts[f + 1]`.
#[derive(Clone, Debug, Default)]
pub(crate) struct TouchRegions {
    /// For each verdict on a taxel, the index of its region among the regions of the frame.
    of_taxel: Vec<u16>,
    starts: Vec<u32>,
    contacts: Vec<u32>,
    samples: Vec<u32>,
    taxels: Vec<u16>,
    touched: Vec<u16>,
    codes: Vec<u8>,
    shares_beyond: Vec<f64>,
    features: Vec<f64>,
}

impl TouchRegions {
    /// No frames so far.
    pub fn new() -> Self {
        TouchRegions { starts: vec![0], ..TouchRegions::default() }
    }

    /// Adds the regions of the frame that was judged last. `taxels` are its verdicts in the order in which they are stored, and
    /// `code` gives the number of a verdict by its name.
    pub fn push(&mut self, judged: &TouchClassifier, taxels: &[&TaxelTouch], code: impl Fn(&str) -> u8) {
        self.of_taxel.extend(taxels.iter().map(|own| own.region as u16));
        let regions = judged.patches().iter().flat_map(SkinTracker::regions);
        for (own, region) in judged.regions().iter().zip(regions) {
            self.contacts.push(own.contact as u32);
            self.samples.push(own.samples as u32);
            self.taxels.push(own.taxels[0] as u16);
            self.touched.push(own.taxels[1] as u16);
            self.codes.push(code(own.touch.name(judged.model().categories())));
            self.shares_beyond.push(own.share_beyond);
            self.features.extend(region.course.features());
        }
        self.starts.push(self.contacts.len() as u32);
    }

    /// Adds the regions of the frames from number `from` on as the sections `touch_*` and `verdict_region`. `verdicts`
    /// are the rows of the verdicts on these frames. Rows are counted from the first of these regions.
    pub fn add(&self, from: usize, verdicts: Range<usize>, sections: &mut Sections) {
        let starts = self.starts.get(from..).unwrap_or_default();
        let first = starts.first().copied().unwrap_or_default() as usize;
        let rows = first..self.contacts.len();
        sections.add("verdict_region", self.of_taxel[verdicts].iter().copied());
        sections.add("touch_start", starts.iter().map(|start| start - first as u32));
        sections.add("touch_contact", self.contacts[rows.clone()].iter().copied());
        sections.add("touch_samples", self.samples[rows.clone()].iter().copied());
        sections.add("touch_taxels", self.taxels[rows.clone()].iter().copied());
        sections.add("touch_touched_taxels", self.touched[rows.clone()].iter().copied());
        sections.add("touch_code", self.codes[rows.clone()].iter().copied());
        sections.add_single("touch_share_beyond", self.shares_beyond[rows].iter().copied());
        let features = &self.features[first * REGION_FEATURE_COUNT..];
        sections.add_single("touch_feature", features.iter().copied());
    }
}
