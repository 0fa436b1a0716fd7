//! Verdicts on the objects that touch the skin, compared with ground truth.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::Recording;

use crate::frequency::largest;
use crate::touch::{
    Followed, Mobility, ObjectTouch, SkinTracker, Stiffness, TouchClassifier, TouchObject, TouchVerdict, Votes,
    strongest, true_displacement_m, true_stiffness_n_per_m,
};

/// The likeliest known category of an object at some moment, whatever the verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Likeliest {
    /// The category.
    pub category: String,
    /// Its probability, if the object is of a known category.
    pub probability: f64,
}

impl Likeliest {
    /// What the verdict that stood at this moment would have been with another cost of an uncertain one. An object is called unknown whatever
    /// that costs.
    pub(super) fn verdict<'a>(&'a self, verdict: &'a str, cost_of_uncertain: f64) -> &'a str {
        let [unknown, uncertain] = [TouchVerdict::Unknown, TouchVerdict::Uncertain].map(|own| own.name(&[]));
        match self.probability > 1.0 - cost_of_uncertain {
            _ if verdict == unknown => verdict,
            true => &self.category,
            false => uncertain,
        }
    }
}

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
    /// Name of the patch that most of the sensed force came from, until its end.
    pub patch: String,
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
    /// What `patch` was until then.
    pub patch_after_300_ms: String,
    /// The likeliest category at that moment.
    pub likeliest_after_300_ms: Likeliest,
    /// The verdict when its force was largest.
    pub at_peak: String,
    /// What `truth` was until then.
    pub truth_at_peak: String,
    /// The last verdict.
    pub at_end: String,
    /// The likeliest category at that moment.
    pub likeliest_at_end: Likeliest,
    /// How often the verdict changed.
    pub flips: usize,
    /// The mean cost of the verdict over the frames in which the object was felt: 1 if it is wrong, the model's `cost_of_uncertain` if it is
    /// uncertain, 0 if it is right. It is compared with what `truth` was until then.
    pub mean_cost: f64,
    /// The share of known objects that are as unlike what is known, at its end.
    pub share_beyond: f64,
    /// The stiffness that the classifier told when the object's force was largest.
    pub stiffness: Option<Stiffness>,
    /// Its true stiffness when its force was largest, N/m; `None` if it did not give way.
    pub true_stiffness_n_per_m: Option<f64>,
    /// How far it seems to have moved from where it was first felt, at its end, m.
    pub moved_m: f64,
    /// The farthest that the true object was from where it was when first felt, until it was last felt, m; `None` if bodies are not recorded.
    pub moved_true_m: Option<f64>,
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
    /// The sensed force on each patch, by its index, summed over frames, N.
    patches: BTreeMap<usize, f64>,
    /// The first and the last frame in which it was felt.
    felt: Option<[usize; 2]>,
    /// The frame in which its force was largest.
    peak_frame: usize,
    /// The costs of the verdicts so far, and their number.
    costs: (f64, usize),
    is_judged: bool,
}

/// A frame of an object.
struct Now<'a> {
    frame: usize,
    time_s: f64,
    verdict: &'a str,
    /// The likeliest category.
    likeliest: &'a str,
    /// The category of the object that most of the force came from so far; empty if nothing pressed.
    truth: &'a str,
    /// The patch that most of the force came from so far.
    patch: &'a str,
    /// What the verdict costs.
    cost: f64,
}

impl Followed<OpenObject> {
    /// Takes in the verdicts on a frame of the recording.
    pub(super) fn judge(&mut self, classifier: &TouchClassifier, frame: usize, recording: &Recording) {
        let tracker = &classifier.tracker;
        self.update(classifier.patches(), tracker);
        let felt = classifier.patches().iter().flat_map(SkinTracker::regions);
        for (region, felt) in classifier.regions().iter().zip(felt) {
            if let Some((open, _)) = region.object.and_then(|object| self.of(object)) {
                open.contacts.insert((region.patch, region.contact), region.touch);
                *open.patches.entry(region.patch).or_default() += felt.course.now.force_n;
            }
        }
        let (categories, decision) = (classifier.model().categories(), &classifier.model().decision);
        for (object, own) in tracker.objects.iter().zip(classifier.objects()) {
            if let Some((open, votes)) = self.of(object.number) {
                let truth = strongest(votes, recording).map_or("", |(.., category)| category.name());
                let cost = match own.touch {
                    verdict if verdict == TouchVerdict::named(truth, categories) => 0.0,
                    TouchVerdict::Uncertain => decision.cost_of_uncertain,
                    _ => 1.0,
                };
                let (time_s, likeliest) = (recording.frames[frame].time_s, categories[own.likeliest].as_str());
                let verdict = own.touch.name(categories);
                let patch = largest(open.patches.iter().map(|(patch, force_n)| (*patch, *force_n)));
                let patch = patch.and_then(|(patch, _)| recording.layout.patches.get(patch));
                let patch = patch.map_or("", |patch| patch.name.as_str());
                open.update(object, own, &Now { frame, time_s, verdict, likeliest, truth, patch, cost });
            }
        }
    }

    /// All objects, once the recording is over.
    pub(super) fn judged(self, recording: &Recording) -> Vec<JudgedObject> {
        self.finish().filter_map(|(open, votes)| open.close(votes, recording)).collect()
    }
}

impl OpenObject {
    fn update(&mut self, object: &TouchObject, own: &ObjectTouch, now: &Now<'_>) {
        let Now { verdict, truth, .. } = *now;
        let judged = &mut self.judged;
        judged.object = object.number;
        // Tolerates rounding of the times.
        let since_s = now.time_s - object.start_s - 1e-6;
        for (verdict_then, truth_then, until_s) in [
            (&mut judged.after_100_ms, &mut judged.truth_after_100_ms, 0.1),
            (&mut judged.after_300_ms, &mut judged.truth_after_300_ms, 0.3),
        ] {
            if since_s <= until_s {
                verdict.clone_into(verdict_then);
                truth.clone_into(truth_then);
            }
        }
        for (likeliest_then, patch_then, until_s) in [
            (&mut judged.likeliest_after_300_ms, &mut judged.patch_after_300_ms, 0.3),
            (&mut judged.likeliest_at_end, &mut judged.patch, f64::INFINITY),
        ] {
            if since_s <= until_s {
                now.likeliest.clone_into(&mut likeliest_then.category);
                likeliest_then.probability = own.probability;
                now.patch.clone_into(patch_then);
            }
        }
        if object.is_touching && object.course.largest_force_n() > judged.peak_force_n {
            judged.peak_force_n = object.course.largest_force_n();
            verdict.clone_into(&mut judged.at_peak);
            truth.clone_into(&mut judged.truth_at_peak);
            judged.stiffness = own.stiffness(object);
            self.peak_frame = now.frame;
        }
        if verdict != judged.at_end {
            judged.flips += usize::from(since_s > 0.0);
            verdict.clone_into(&mut judged.at_end);
        }
        if object.is_touching {
            let [first, _] = self.felt.unwrap_or([now.frame; 2]);
            self.felt = Some([first, now.frame]);
            judged.lasted_s = now.time_s - object.start_s;
            (judged.moved_m, judged.mobility) = (object.course.moved_m(), object.course.mobility());
            // Before anything truly pressed, there is nothing to be wrong about.
            if !truth.is_empty() {
                self.costs = (self.costs.0 + now.cost, self.costs.1 + 1);
            }
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
            moved_true_m: self.felt.and_then(|frames| true_displacement_m(recording, frames, true_object)),
            mean_cost: self.costs.0 / self.costs.1.max(1) as f64,
            contacts: self.contacts.len(),
            contacts_called_unknown: self.contacts.values().filter(|touch| **touch == TouchVerdict::Unknown).count(),
            force_n: [votes.values().sum(), own_n],
            pressed_by: votes.into_keys().collect(),
            ..self.judged
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::touch::ObjectCourse;

    /// Tests that every change of the verdict counts, and that only frames in which the object is felt cost anything.
    #[test]
    fn changes_and_costs_are_counted() {
        let mut open = OpenObject::default();
        let mut object = TouchObject { number: 1, start_s: 0.0, is_touching: true, course: ObjectCourse::default() };
        let own = ObjectTouch {
            object: 1,
            samples: 0,
            frames: 0,
            share_beyond: 1.0,
            learnt_stiffness: None,
            likeliest: 0,
            probability: 0.5,
            touch: TouchVerdict::Uncertain,
        };
        let verdicts = [("leaf", 0.0), ("uncertain", 0.3), ("trunk", 1.0), ("leaf", 0.0)];
        for (frame, (verdict, cost)) in verdicts.into_iter().enumerate() {
            object.is_touching = frame < 3;
            let time_s = 0.01 * frame as f64;
            let now = Now { frame, time_s, verdict, likeliest: "leaf", truth: "leaf", patch: "forearm", cost };
            open.update(&object, &own, &now);
        }
        assert_eq!((open.judged.flips, open.costs), (3, (1.3, 3)));
    }
}
