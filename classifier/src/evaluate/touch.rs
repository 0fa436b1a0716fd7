//! Verdicts on what touches the skin, compared with ground truth taxel by taxel and frame by frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use underbrush_recording::Recording;

use super::confusion::{Accuracy, ConfusionMatrix};
use super::interval::{Interval, bootstrap_balanced};
use super::prediction::Record;
use super::tally::Tally;
use super::touch_contact::{JudgedContact, OpenContact};
use super::touch_object::{JudgedObject, Likeliest, OpenObject};
use crate::touch::{Followed, TaxelTouch, TouchClassifier, TouchModel, TouchVerdict};
use crate::trial::TrialError;

/// Number of bins of the probability of the likeliest class.
pub const CALIBRATION_BINS: usize = 20;

/// How often the likeliest class was true, for probabilities in one bin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CalibrationBin {
    /// Taxel frames, or objects.
    pub count: usize,
    /// Sum of the probabilities of the likeliest class.
    pub probability: f64,
    /// How often that class was the truth.
    pub true_count: usize,
}

impl CalibrationBin {
    /// Counts a probability of the likeliest class in its bin, and whether this class was true.
    fn count(bins: &mut [CalibrationBin; CALIBRATION_BINS], probability: f64, is_true: bool) {
        let bin = ((probability * CALIBRATION_BINS as f64) as usize).min(CALIBRATION_BINS - 1);
        let bin = &mut bins[bin];
        bin.count += 1;
        bin.probability += probability;
        bin.true_count += usize::from(is_true);
    }

    /// Mean difference between probability and frequency of the likeliest class, weighted by the counts of the bins
    /// (Naeini et al. 2015); `None` without any count.
    pub(super) fn expected_error(bins: &[CalibrationBin; CALIBRATION_BINS]) -> Option<f64> {
        let count: usize = bins.iter().map(|bin| bin.count).sum();
        let difference = |bin: &CalibrationBin| (bin.probability - bin.true_count as f64).abs();
        (count > 0).then(|| bins.iter().map(difference).sum::<f64>() / count as f64)
    }
}

/// All verdicts on some recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TouchEvaluation {
    /// Taxel frames by truth: nothing, the model's categories, then everything else.
    pub tallies: Vec<Tally>,
    /// Contacts of taxels with known categories.
    pub contacts: Vec<JudgedContact>,
    /// Calibration over taxel frames whose truth is nothing or a known category.
    pub calibration: [CalibrationBin; CALIBRATION_BINS],
    /// Sum of the squared errors of all probabilities over those taxel frames (Brier 1950).
    pub squared_error: f64,
    /// The objects that were felt well enough to be judged.
    pub objects: Vec<JudgedObject>,
    /// The taxel frames of each reach, by the name of the patch and by truth, in the order of `tallies`.
    pub reaches: Vec<BTreeMap<String, Vec<Tally>>>,
}

impl TouchEvaluation {
    /// Judges a recording frame by frame.
    ///
    /// # Errors
    /// [`TrialError`] if the patch or a frame does not fit.
    pub fn of(model: &Arc<TouchModel>, recording: &Recording) -> Result<Self, TrialError> {
        let mut classifier = TouchClassifier::new(Arc::clone(model), &recording.layout)?;
        let tallies = vec![Tally::default(); model.categories().len() + 2];
        let names = classifier.patches().iter().map(|tracker| tracker.image.patch().name.clone());
        let reaches = vec![names.map(|name| (name, tallies.clone())).collect()];
        let mut evaluation = TouchEvaluation { tallies, reaches, ..TouchEvaluation::default() };
        // By patch and taxel.
        let mut open: BTreeMap<(usize, usize), OpenContact> = BTreeMap::new();
        let mut objects = Followed::<OpenObject>::default();
        for (index, frame) in recording.frames.iter().enumerate() {
            classifier.update(frame)?;
            for tracker in classifier.patches() {
                let (patch, image) = (tracker.image.patch_index(), &tracker.image);
                let over = open.extract_if((patch, 0)..(patch + 1, 0), |(_, taxel), _| !image.is_in_contact(*taxel));
                evaluation.contacts.extend(over.filter_map(|(_, contact)| contact.close()));
            }
            for taxel in classifier.taxels() {
                evaluation.judge(&classifier, taxel, &mut open, recording);
            }
            objects.judge(&classifier, index, recording);
        }
        evaluation.contacts.extend(open.into_values().filter_map(OpenContact::close));
        evaluation.objects = objects.judged(recording);
        Ok(evaluation)
    }

    /// Judges several recordings.
    ///
    /// # Errors
    /// As [`TouchEvaluation::of`].
    pub fn of_all<'a>(
        model: &Arc<TouchModel>,
        recordings: impl IntoIterator<Item = &'a Recording>,
    ) -> Result<Self, TrialError> {
        let mut all = TouchEvaluation::default();
        for recording in recordings {
            all.add(TouchEvaluation::of(model, recording)?);
        }
        Ok(all)
    }

    fn judge(
        &mut self,
        classifier: &TouchClassifier,
        taxel: &TaxelTouch,
        open: &mut BTreeMap<(usize, usize), OpenContact>,
        recording: &Recording,
    ) {
        let categories = classifier.model().categories();
        let tracker = classifier.patches().iter().find(|tracker| tracker.image.patch_index() == taxel.patch);
        let touching = tracker.and_then(|tracker| recording.category_of(tracker.image.pressing(taxel.taxel)?));
        let truth = touching.map_or(TouchVerdict::Nothing, |category| TouchVerdict::named(category.name(), categories));
        let row = truth.row(categories.len());
        let of_patch = tracker.and_then(|tracker| self.reaches[0].get_mut(&tracker.image.patch().name));
        for tallies in of_patch.into_iter().chain([&mut self.tallies]) {
            tallies[row].add(taxel.touch, taxel.touch == truth, 1);
        }
        let probabilities = classifier.probabilities(taxel.region);
        if truth != TouchVerdict::Unknown {
            self.calibrate(taxel.nothing, probabilities, row);
        }
        let place = (taxel.patch, taxel.taxel);
        let contact = open.entry(place).or_insert_with(|| OpenContact::new(categories.len()));
        contact.push(taxel, probabilities, truth);
    }

    /// Counts the probabilities of a taxel frame whose truth is this class: 0 is nothing, and the categories follow.
    fn calibrate(&mut self, nothing: f64, probabilities: &[f64], class: usize) {
        let (mut likeliest, mut largest) = (0, nothing);
        let touched = probabilities.iter().map(|probability| (1.0 - nothing) * probability);
        for (index, probability) in std::iter::once(nothing).chain(touched).enumerate() {
            if probability > largest {
                (likeliest, largest) = (index, probability);
            }
            self.squared_error += (probability - f64::from(u8::from(index == class))).powi(2);
        }
        CalibrationBin::count(&mut self.calibration, largest, likeliest == class);
    }

    /// Adds the verdicts on other recordings by a model with the same categories.
    pub fn add(&mut self, other: TouchEvaluation) {
        self.tallies.resize(self.tallies.len().max(other.tallies.len()), Tally::default());
        self.tallies.iter_mut().zip(other.tallies).for_each(|(own, other)| *own = Tally::sum([*own, other]));
        let before = self.reaches.len();
        self.contacts.extend(other.contacts.into_iter().map(|own| JudgedContact { reach: before + own.reach, ..own }));
        for (own, other) in self.calibration.iter_mut().zip(&other.calibration) {
            own.count += other.count;
            own.probability += other.probability;
            own.true_count += other.true_count;
        }
        self.squared_error += other.squared_error;
        self.objects.extend(other.objects.into_iter().map(|own| JudgedObject { reach: before + own.reach, ..own }));
        self.reaches.extend(other.reaches);
    }

    /// Taxel frames of known categories.
    pub fn known(&self) -> Tally {
        known(&self.tallies)
    }

    /// How often the likeliest category of a whole contact is right, for a model with these categories; `None` without
    /// contacts. There is no balanced accuracy unless every category has a contact.
    pub fn accuracy(&self, categories: &[String]) -> Option<Accuracy> {
        let record = |own: &JudgedContact| {
            let truth = &categories[own.category];
            Record { truth, verdict: own.at_end, scores: &[], reach: None }
        };
        let confusion = ConfusionMatrix::of(self.contacts.iter().map(record), categories);
        let accuracy = confusion.accuracy()?;
        let balanced_accuracy = accuracy.balanced_accuracy.filter(|_| confusion.truth.len() == categories.len());
        Some(Accuracy { balanced_accuracy, ..accuracy })
    }

    /// The 95 % interval of the balanced accuracy of [`Self::accuracy`], from a bootstrap over reaches.
    pub(super) fn accuracy_interval(&self) -> Option<Interval> {
        let is_right = |own: &JudgedContact| usize::from(own.at_end == own.category);
        bootstrap_balanced(self.contacts.iter().map(|own| (own.reach as u64, own.category, [is_right(own), 1])))
    }

    /// The expected calibration error over objects of these categories, of their likeliest category 0.3 s after the first contact.
    pub fn object_calibration_error(&self, categories: &[String]) -> Option<f64> {
        let mut bins = [CalibrationBin::default(); CALIBRATION_BINS];
        for own in self.objects.iter().filter(|own| categories.contains(&own.truth_after_300_ms)) {
            let Likeliest { category, probability } = &own.likeliest_after_300_ms;
            CalibrationBin::count(&mut bins, *probability, *category == own.truth_after_300_ms);
        }
        CalibrationBin::expected_error(&bins)
    }

    /// Mean squared error of the probabilities; `None` without any taxel frame.
    pub fn brier_score(&self) -> Option<f64> {
        let count: usize = self.calibration.iter().map(|bin| bin.count).sum();
        (count > 0).then(|| self.squared_error / count as f64)
    }
}

/// The part of a list of tallies that is of known categories, between nothing and everything else.
pub(super) fn known(tallies: &[Tally]) -> Tally {
    let known = tallies.get(1..tallies.len().saturating_sub(1)).unwrap_or_default();
    Tally::sum(known.iter().copied())
}
