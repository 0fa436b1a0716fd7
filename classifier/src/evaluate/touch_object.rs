//! Verdicts on the objects that touch the skin, compared with ground truth.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::{Category, Recording};

use super::interval::{BOOTSTRAP_RESAMPLES, Interval, bootstrap_by_reach};
use super::record::Record;
use super::roc::RocCurve;
use crate::decision::Verdict;
use crate::touch::{ObjectTouch, Touch, TouchClassifier, TouchObject, Votes, category_of, count_votes};

/// Verdicts that stood at some moments of an object: categories, `uncertain` or `unknown`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedObject {
    /// The reach, from 0 in the order in which they were judged.
    pub reach: usize,
    /// Number of the object in its reach, from 1. Contacts that begin near each other count as one object.
    pub object: u64,
    /// Category of the true object that most of the force came from.
    pub truth: String,
    /// Index of that object in the recording.
    pub true_object: u16,
    /// How long it was felt, from its first contact to its last, s.
    pub lasted_s: f64,
    /// The largest sensed force, N.
    pub peak_force_n: f64,
    /// The verdict 0.1 s after its first contact.
    pub after_100_ms: String,
    /// The verdict 0.3 s after its first contact.
    pub after_300_ms: String,
    /// The verdict when its force was largest.
    pub at_peak: String,
    /// The last verdict.
    pub at_end: String,
    /// How often the verdict changed.
    pub flips: usize,
    /// The share of known objects that are as unlike what is known, at its end.
    pub share_beyond: f64,
    /// Its contacts, as far as they belong to it, and those of them that ended as contacts with something unknown.
    pub contacts: usize,
    /// See `contacts`.
    pub contacts_called_unknown: usize,
    /// The sensed force of all its taxels and frames, and the part of it that came from the true object, N.
    #[serde(skip)]
    pub force_n: [f64; 2],
}

/// How well unknown objects are found, by the model's own decision at the end of each object. Foam blocks are left out:
/// they belong to the environment. Intervals are 95 % intervals of the shares, from a bootstrap over reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct UnknownFigures {
    /// Objects of categories that the model does not know.
    pub unknown_objects: usize,
    /// Of these: called unknown.
    pub found_objects: usize,
    /// Interval of this share.
    pub found_interval: Option<Interval>,
    /// Of the unknown objects: called unknown when their force was largest.
    pub found_objects_at_peak: usize,
    /// Objects of known categories.
    pub known_objects: usize,
    /// Of these: called unknown.
    pub false_alarm_objects: usize,
    /// Interval of this share.
    pub false_alarm_interval: Option<Interval>,
    /// Contacts with unknown objects.
    pub unknown_contacts: usize,
    /// Of these: called unknown at their end.
    pub found_contacts: usize,
    /// Contacts with known objects.
    pub known_contacts: usize,
    /// Of these: called unknown at their end.
    pub false_alarm_contacts: usize,
    /// Area under the ROC curve of unknown against known objects, by the share of known objects that are as unlike; 0.5 is
    /// guessing.
    pub roc_area: Option<f64>,
}

/// Verdicts on known objects at one moment. Shares are from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ObjectVerdicts {
    /// The moment: `0.1 s`, `0.3 s`, `peak` or `end`.
    pub at: &'static str,
    /// Number of objects of known categories.
    pub objects: usize,
    /// Share that is called what it is; the mean over the categories that were touched.
    pub balanced_right: f64,
    /// 95 % interval of the share that is called what it is, not balanced, from a bootstrap over reaches.
    pub right_interval: Option<Interval>,
    /// Share that is called what it is.
    pub right: f64,
    /// Share that is called another category or unknown.
    pub wrong: f64,
    /// Of the wrong ones: called unknown.
    pub called_unknown: f64,
}

/// How well contacts are joined to objects.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GroupingFigures {
    /// Share of the sensed force that comes from the true object of its group.
    pub purity: f64,
    /// Number of groups.
    pub groups: usize,
    /// Number of true objects.
    pub true_objects: usize,
}

impl UnknownFigures {
    /// The figures for a model with these categories.
    pub fn of(objects: &[JudgedObject], categories: &[String]) -> Self {
        let (mut figures, [unknown, known]) = (UnknownFigures::default(), divided(objects, categories));
        for own in &unknown {
            figures.unknown_objects += 1;
            figures.found_objects += usize::from(is_unknown(&own.at_end));
            figures.found_objects_at_peak += usize::from(is_unknown(&own.at_peak));
            figures.unknown_contacts += own.contacts;
            figures.found_contacts += own.contacts_called_unknown;
        }
        for own in &known {
            figures.known_objects += 1;
            figures.false_alarm_objects += usize::from(is_unknown(&own.at_end));
            figures.known_contacts += own.contacts;
            figures.false_alarm_contacts += own.contacts_called_unknown;
        }
        let unlike = |own: &[&JudgedObject]| own.iter().map(|own| -own.share_beyond).collect::<Vec<_>>();
        UnknownFigures {
            found_interval: interval(&unknown, |own| is_unknown(&own.at_end)),
            false_alarm_interval: interval(&known, |own| is_unknown(&own.at_end)),
            roc_area: RocCurve::of(&unlike(&unknown), &unlike(&known)).map(|curve| curve.area),
            ..figures
        }
    }
}

/// The verdict that stood at some moment.
type VerdictAt = fn(&JudgedObject) -> &String;

impl ObjectVerdicts {
    /// The figures at each moment; empty without objects of known categories.
    pub(super) fn of(objects: &[JudgedObject], categories: &[String]) -> Vec<Self> {
        let moments: [(&'static str, VerdictAt); 4] = [
            ("0.1 s", |own| &own.after_100_ms),
            ("0.3 s", |own| &own.after_300_ms),
            ("peak", |own| &own.at_peak),
            ("end", |own| &own.at_end),
        ];
        let [_, known] = divided(objects, categories);
        let share = |count: usize| count as f64 / known.len() as f64;
        let of_moment = |(at, verdict): (&'static str, VerdictAt)| {
            let is_right = |own: &JudgedObject| *verdict(own) == own.truth;
            let count = |of: &dyn Fn(&JudgedObject) -> bool| known.iter().filter(|own| of(own)).count();
            let of_category = |name: &String| {
                let all = count(&|own| own.truth == *name);
                (all > 0).then(|| count(&|own| own.truth == *name && is_right(own)) as f64 / all as f64)
            };
            let balanced: Vec<f64> = categories.iter().filter_map(of_category).collect();
            ObjectVerdicts {
                at,
                objects: known.len(),
                balanced_right: balanced.iter().sum::<f64>() / balanced.len() as f64,
                right_interval: interval(&known, is_right),
                right: share(count(&is_right)),
                wrong: share(count(&|own| !is_right(own) && *verdict(own) != Category::UNCERTAIN)),
                called_unknown: share(count(&|own| is_unknown(verdict(own)))),
            }
        };
        if known.is_empty() { Vec::new() } else { moments.map(of_moment).to_vec() }
    }
}

impl GroupingFigures {
    pub(super) fn of(objects: &[JudgedObject]) -> Option<Self> {
        let [all, own] = objects.iter().fold([0.0; 2], |sum, own| [sum[0] + own.force_n[0], sum[1] + own.force_n[1]]);
        let mut true_objects: Vec<_> = objects.iter().map(|own| (own.reach, own.true_object)).collect();
        true_objects.sort_unstable();
        true_objects.dedup();
        let (groups, true_objects) = (objects.len(), true_objects.len());
        (all > 0.0).then(|| GroupingFigures { purity: own / all, groups, true_objects })
    }
}

fn is_unknown(verdict: &str) -> bool {
    verdict == Touch::Unknown.name(&[])
}

/// The objects of unknown categories, without foam blocks, and those of known ones.
fn divided<'a>(objects: &'a [JudgedObject], categories: &[String]) -> [Vec<&'a JudgedObject>; 2] {
    let objects = objects.iter().filter(|own| own.truth != Category::BLOCK.name());
    let (known, unknown) = objects.partition(|own| categories.contains(&own.truth));
    [unknown, known]
}

/// The interval of the share of objects of which something holds.
fn interval(objects: &[&JudgedObject], holds: impl Fn(&JudgedObject) -> bool) -> Option<Interval> {
    // An object of which it holds is an outlier that is found.
    let record = |own: &&JudgedObject| Record {
        truth: Verdict::Outlier.name(),
        verdict: usize::from(holds(own)),
        scores: &[],
        reach: Some(own.reach as u64),
        weight: 1,
    };
    bootstrap_by_reach(objects.iter().map(record), &[], BOOTSTRAP_RESAMPLES, 0)
}

/// Follows the objects of a reach.
#[derive(Default)]
pub(super) struct ObjectJudge {
    open: BTreeMap<u64, OpenObject>,
    closed: Vec<JudgedObject>,
}

/// An object that has not ended.
struct OpenObject {
    judged: JudgedObject,
    votes: Votes,
    /// The last verdict on each of its contacts, by patch and number.
    contacts: BTreeMap<(usize, u64), Touch>,
    is_judged: bool,
}

impl ObjectJudge {
    /// Takes in the verdicts on a frame that was sensed at `time_s`.
    pub(super) fn update(&mut self, classifier: &TouchClassifier, time_s: f64, recording: &Recording) {
        let tracker = classifier.object_tracker();
        for object in tracker.ended() {
            self.close(object.number, recording);
        }
        let categories = classifier.model().categories();
        for (object, own) in tracker.objects().iter().zip(classifier.objects()) {
            let open = self.open.entry(object.number).or_insert_with(|| OpenObject::new(object.number));
            open.update(object, own, time_s, categories);
        }
        for region in classifier.regions() {
            if let Some(open) = region.object.and_then(|object| self.open.get_mut(&object)) {
                open.contacts.insert((region.patch, region.contact), region.touch);
            }
        }
        count_votes(classifier.patches(), tracker, |object, truth, force_n| {
            if let Some(open) = self.open.get_mut(&object.number) {
                *open.votes.entry(truth).or_default() += force_n;
            }
        });
    }

    /// All objects, once the recording is over.
    pub(super) fn finish(mut self, recording: &Recording) -> Vec<JudgedObject> {
        for number in self.open.keys().copied().collect::<Vec<_>>() {
            self.close(number, recording);
        }
        self.closed
    }

    fn close(&mut self, number: u64, recording: &Recording) {
        let Some(open) = self.open.remove(&number).filter(|open| open.is_judged) else { return };
        let strongest = open.votes.iter().reduce(|most, other| if other.1 > most.1 { other } else { most });
        let (Some((true_object, own_n)), Some(truth)) = (strongest, category_of(&open.votes, recording)) else {
            return;
        };
        let called_unknown = open.contacts.values().filter(|touch| **touch == Touch::Unknown).count();
        self.closed.push(JudgedObject {
            truth: truth.name().to_owned(),
            true_object: *true_object,
            contacts: open.contacts.len(),
            contacts_called_unknown: called_unknown,
            force_n: [open.votes.values().sum(), *own_n],
            ..open.judged
        });
    }
}

impl OpenObject {
    fn new(object: u64) -> Self {
        let none = || Touch::Uncertain.name(&[]).to_owned();
        let judged = JudgedObject {
            reach: 0,
            object,
            truth: String::new(),
            true_object: 0,
            lasted_s: 0.0,
            peak_force_n: 0.0,
            after_100_ms: none(),
            after_300_ms: none(),
            at_peak: none(),
            at_end: none(),
            flips: 0,
            share_beyond: 1.0,
            contacts: 0,
            contacts_called_unknown: 0,
            force_n: [0.0; 2],
        };
        OpenObject { judged, votes: Votes::new(), contacts: BTreeMap::new(), is_judged: false }
    }

    fn update(&mut self, object: &TouchObject, own: &ObjectTouch, time_s: f64, categories: &[String]) {
        let (judged, verdict) = (&mut self.judged, own.touch.name(categories));
        // Tolerates rounding of the times.
        let since_s = time_s - object.start_s - 1e-6;
        for (place, until_s) in [(&mut judged.after_100_ms, 0.1), (&mut judged.after_300_ms, 0.3)] {
            if since_s <= until_s && verdict != place {
                verdict.clone_into(place);
            }
        }
        if object.is_touching && object.course.largest_force_n() > judged.peak_force_n {
            judged.peak_force_n = object.course.largest_force_n();
            verdict.clone_into(&mut judged.at_peak);
        }
        if verdict != judged.at_end {
            judged.flips += usize::from(since_s > 0.0);
            verdict.clone_into(&mut judged.at_end);
        }
        if object.is_touching {
            judged.lasted_s = time_s - object.start_s;
        }
        judged.share_beyond = own.share_beyond;
        self.is_judged = object.is_judged();
    }
}
