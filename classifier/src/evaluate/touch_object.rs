//! Verdicts on the objects that touch the skin, compared with ground truth.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::Recording;

use crate::touch::{
    Followed, Mobility, ObjectTouch, Stiffness, TouchClassifier, TouchObject, TouchVerdict, Votes, strongest,
    true_stiffness_n_per_m,
};

/// Verdicts that stood at some moments of an object: categories, `uncertain` or `unknown`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct JudgedObject {
    /// The reach, from 0 in the order in which they were judged; in a report, in the order in which they were given.
    pub reach: usize,
    /// Number of the object in its reach, from 1. Contacts that begin near each other count as one object.
    pub object: u64,
    /// Category of the true object that most of the force came from, until its end.
    pub truth: String,
    /// Index of that object in the recording.
    pub true_object: u16,
    /// How long it was felt, from its first contact to its last, s.
    pub lasted_s: f64,
    /// The largest sensed force, N.
    pub peak_force_n: f64,
    /// The verdict 0.1 s after its first contact.
    pub after_100_ms: String,
    /// What `truth` was until then: contacts with several true objects may be joined, and a verdict cannot know of later ones.
    pub truth_after_100_ms: String,
    /// The verdict 0.3 s after its first contact.
    pub after_300_ms: String,
    /// What `truth` was until then.
    pub truth_after_300_ms: String,
    /// The verdict when its force was largest.
    pub at_peak: String,
    /// What `truth` was until then.
    pub truth_at_peak: String,
    /// The last verdict.
    pub at_end: String,
    /// How often the verdict changed.
    pub flips: usize,
    /// The share of known objects that are as unlike what is known, at its end.
    pub share_beyond: f64,
    /// The stiffness that the classifier told when the object's force was largest.
    pub stiffness: Option<Stiffness>,
    /// Its true stiffness when its force was largest, N/m; `None` if it did not give way.
    pub true_stiffness_n_per_m: Option<f64>,
    /// How far it seems to have moved from where it was first felt, at its end, m.
    pub moved_m: f64,
    /// What it had done under the push, at its end.
    pub mobility: Mobility,
    /// Number of its contacts.
    pub contacts: usize,
    /// Number of its contacts whose last verdict was unknown.
    pub contacts_called_unknown: usize,
    /// The sensed force of all its taxels and frames, and the part of it that came from the true object, N.
    #[serde(skip)]
    pub force_n: [f64; 2],
    /// Indices of all objects in the recording that pressed its taxels.
    #[serde(skip)]
    pub pressed_by: Vec<u16>,
}

/// An object while its reach is followed.
#[derive(Default)]
pub(super) struct OpenObject {
    judged: JudgedObject,
    /// The last verdict on each of its contacts, by patch and number.
    contacts: BTreeMap<(usize, u64), TouchVerdict>,
    /// The frame in which its force was largest.
    peak_frame: usize,
    is_judged: bool,
}

impl Followed<OpenObject> {
    /// Takes in the verdicts on a frame of the recording.
    pub(super) fn judge(&mut self, classifier: &TouchClassifier, frame: usize, recording: &Recording) {
        let tracker = classifier.object_tracker();
        self.update(classifier.patches(), tracker);
        let categories = classifier.model().categories();
        for (object, own) in tracker.objects.iter().zip(classifier.objects()) {
            if let Some((open, votes)) = self.of(object.number) {
                let truth = strongest(votes, recording).map_or("", |(.., category)| category.name());
                let time_s = recording.frames[frame].time_s;
                open.update(object, own, [own.touch.name(categories), truth], frame, time_s);
            }
        }
        for region in classifier.regions() {
            if let Some((open, _)) = region.object.and_then(|object| self.of(object)) {
                open.contacts.insert((region.patch, region.contact), region.touch);
            }
        }
    }

    /// All objects, once the recording is over.
    pub(super) fn judged(self, recording: &Recording) -> Vec<JudgedObject> {
        self.finish().filter_map(|(open, votes)| open.close(votes, recording)).collect()
    }
}

impl OpenObject {
    /// Takes in a frame. `names` are those of the verdict and of the truth until then, which is empty if nothing pressed.
    fn update(&mut self, object: &TouchObject, own: &ObjectTouch, names: [&str; 2], frame: usize, time_s: f64) {
        let [verdict, truth] = names;
        let judged = &mut self.judged;
        judged.object = object.number;
        // Tolerates rounding of the times.
        let since_s = time_s - object.start_s - 1e-6;
        for (verdict_then, truth_then, until_s) in [
            (&mut judged.after_100_ms, &mut judged.truth_after_100_ms, 0.1),
            (&mut judged.after_300_ms, &mut judged.truth_after_300_ms, 0.3),
        ] {
            if since_s <= until_s {
                verdict.clone_into(verdict_then);
                truth.clone_into(truth_then);
            }
        }
        if object.is_touching && object.course.largest_force_n() > judged.peak_force_n {
            judged.peak_force_n = object.course.largest_force_n();
            verdict.clone_into(&mut judged.at_peak);
            truth.clone_into(&mut judged.truth_at_peak);
            judged.stiffness = own.stiffness(object);
            self.peak_frame = frame;
        }
        if verdict != judged.at_end {
            judged.flips += usize::from(since_s > 0.0);
            verdict.clone_into(&mut judged.at_end);
        }
        if object.is_touching {
            judged.lasted_s = time_s - object.start_s;
            (judged.moved_m, judged.mobility) = (object.course.moved_m(), object.course.mobility());
        }
        judged.share_beyond = own.share_beyond;
        self.is_judged = object.is_judged();
    }

    /// The object, if it was felt well enough and something truly pressed.
    fn close(mut self, votes: Votes, recording: &Recording) -> Option<JudgedObject> {
        let (true_object, own_n, truth) = strongest(&votes, recording).filter(|_| self.is_judged)?;
        let truth = truth.name();
        let judged = &mut self.judged;
        for before in [&mut judged.truth_after_100_ms, &mut judged.truth_after_300_ms, &mut judged.truth_at_peak] {
            // Spurious readings only, until then.
            if before.is_empty() {
                truth.clone_into(before);
            }
        }
        Some(JudgedObject {
            truth: truth.to_owned(),
            true_object,
            true_stiffness_n_per_m: true_stiffness_n_per_m(recording, self.peak_frame, true_object),
            contacts: self.contacts.len(),
            contacts_called_unknown: self.contacts.values().filter(|touch| **touch == TouchVerdict::Unknown).count(),
            force_n: [votes.values().sum(), own_n],
            pressed_by: votes.into_keys().collect(),
            ..self.judged
        })
    }
}
