//! Objects of recordings with ground truth, and what is fitted to them.

use rayon::prelude::*;
use underbrush_recording::{Category, Recording};

use super::category::ObjectCategories;
use super::course::OBJECT_FEATURE_COUNT;
use super::stiffness::{Pressed, StiffnessTrees};
use super::tracker::{ObjectTracker, TouchObject};
use super::truth::{Followed, Votes, strongest, true_stiffness_n_per_m};
use super::unknown::{self, Calibration, FAMILIES, Family, UnknownObjects};
use crate::boosted::{Boosted, Loss, Row};
use crate::error::ModelError;
use crate::frequency::frequencies;
use crate::touch::frame::SkinTracker;

/// An object gives a row after each of these numbers of samples, and at its end.
const SAMPLES: [usize; 7] = [15, 30, 60, 120, 240, 480, 960];
/// An object also gives a row after each of these numbers of frames, so that its category is learnt from the beginning.
const EARLY_FRAMES: [usize; 9] = [1, 2, 3, 5, 10, 20, 30, 50, 100];
/// Parts into which reaches are divided. Each part is judged by trees that are fitted to the others.
const FOLDS: usize = 5;
/// A family needs this many objects: fewer in each part would say little.
const FEWEST: usize = 10;

/// An object that touched the skin in a recording.
#[derive(Clone, Debug, Default)]
pub(in crate::touch) struct ObjectExample {
    /// Its category in ground truth.
    pub(in crate::touch) category: &'static str,
    /// Numbers of samples and features at some times.
    rows: Vec<(usize, [f32; OBJECT_FEATURE_COUNT])>,
    /// Features after [`EARLY_FRAMES`].
    early: Vec<[f32; OBJECT_FEATURE_COUNT]>,
    /// When its force was largest; `None` if it had not given way.
    pressed: Option<Pressed>,
}

/// An object while its recording is followed.
#[derive(Default)]
pub(in crate::touch) struct Open {
    example: ObjectExample,
    /// The frame in which its force was largest, and its features then.
    peak: Option<(usize, [f32; OBJECT_FEATURE_COUNT])>,
}

impl Followed<Open> {
    /// Takes in the frame with this index, which the trackers have followed last.
    pub(in crate::touch) fn learn(&mut self, patches: &[SkinTracker], objects: &ObjectTracker, frame: usize) {
        self.update(patches, objects);
        for object in objects.objects.iter().filter(|object| object.is_touching) {
            if let Some((open, _)) = self.of(object.number) {
                open.update(object, frame);
            }
        }
    }

    /// All objects that were felt well enough, once the recording is over.
    pub(in crate::touch) fn examples(self, recording: &Recording) -> Vec<ObjectExample> {
        self.finish().filter_map(|(open, votes)| open.close(&votes, recording)).collect()
    }
}

impl Open {
    fn update(&mut self, object: &TouchObject, frame: usize) {
        if object.course.is_at_largest_force() {
            self.peak = Some((frame, object.course.features()));
        }
        let example = &mut self.example;
        if EARLY_FRAMES.contains(&object.course.frames()) {
            example.early.push(object.course.features());
        }
        if object.is_judged() {
            // The last row stands for the object as it is now, until it has its own row.
            let samples = object.course.samples();
            if example.rows.last().is_some_and(|(own, _)| !SAMPLES.contains(own)) {
                example.rows.pop();
            }
            if example.rows.last().is_none_or(|(own, _)| *own != samples) {
                example.rows.push((samples, object.course.features()));
            }
        }
    }

    /// The object, if it was felt well enough and something truly pressed.
    fn close(self, votes: &Votes, recording: &Recording) -> Option<ObjectExample> {
        let (object, _, category) = strongest(votes, recording).filter(|_| !self.example.rows.is_empty())?;
        let pressed = self.peak.and_then(|(frame, features)| {
            let stiffness_n_per_m = true_stiffness_n_per_m(recording, frame, object)?;
            Some(Pressed { features, stiffness_n_per_m })
        });
        Some(ObjectExample { category: category.name(), pressed, ..self.example })
    }
}

impl ObjectExample {
    /// The features at all times.
    fn all_rows(&self) -> impl Iterator<Item = &[f32; OBJECT_FEATURE_COUNT]> {
        self.early.iter().chain(self.rows.iter().map(|(_, features)| features))
    }

    fn judged_rows(&self, is_family: bool, weight: f64) -> impl Iterator<Item = Row<'_>> {
        let weight = weight / self.rows.len() as f64;
        self.rows.iter().map(move |(_, features)| Row { features, target: f64::from(is_family), weight })
    }
}

/// What is fitted to objects: what tells categories apart, `None` if there are few objects; what finds unknown objects,
/// `None` if the auxiliary sets are empty; and what estimates stiffness, `None` also if these sets do not say where contacts
/// and bodies were.
type FittedObjects = (Option<ObjectCategories>, Option<UnknownObjects>, Option<StiffnessTrees>);

/// Fits to the objects of reaches of data sets and of auxiliary sets, for a model with these categories.
pub(in crate::touch) fn fit_objects(
    known: &[&[ObjectExample]],
    auxiliary: &[&[ObjectExample]],
    categories: &[String],
) -> Result<FittedObjects, ModelError> {
    let objects = Objects::of(known, auxiliary, categories);
    let rows: Vec<_> = objects.known.iter().map(|(category, _, own)| (*category, own.all_rows().collect())).collect();
    let unknown = if auxiliary.is_empty() { None } else { Some(fit_unknown(&objects, categories)?) };
    let all = objects.known.iter().map(|(.., own)| own).chain(objects.families.iter().map(|(_, own)| own));
    let pressed: Vec<_> = all.filter_map(|own| Some((own.category, own.pressed.as_ref()?))).collect();
    Ok((ObjectCategories::fit(&rows, categories.len()), unknown, StiffnessTrees::fit(&pressed, categories)))
}

fn fit_unknown(objects: &Objects<'_>, categories: &[String]) -> Result<UnknownObjects, ModelError> {
    let counts = frequencies(objects.families.iter().map(|(_, own)| own.category));
    if counts.is_empty() {
        let found = "no unknown objects in the auxiliary sets that touch the skin";
        let allowed = "reaches in which an object of a category that the data sets lack touches the skin";
        return Err(ModelError::mismatch(found, allowed));
    }
    if let Some((name, count)) = counts.iter().find(|(_, count)| **count < FEWEST) {
        let found = format!("{count} objects of the auxiliary category {name} that touch the skin");
        let allowed = format!("{FEWEST} or more; generate more reaches of its scene, or leave it out");
        return Err(ModelError::mismatch(found, allowed));
    }
    if counts.len() > FAMILIES {
        let found = format!("{} auxiliary categories", counts.len());
        return Err(ModelError::mismatch(found, format!("at most {FAMILIES}")));
    }
    let families: Vec<&str> = counts.keys().copied().collect();
    let fit = |fold: Option<usize>| objects.fit(&families, fold);
    let held_out: Vec<Vec<Family>> = (0..FOLDS).into_par_iter().map(|fold| fit(Some(fold))).collect();
    let calibrations = |stage: usize| {
        let scores = |category| objects.scores(category, stage, &held_out);
        Calibration::of(&(0..categories.len()).map(scores).collect::<Vec<_>>(), families.len())
    };
    Ok(UnknownObjects { stages: std::array::from_fn(calibrations), families: fit(None) })
}

/// The objects that are fitted to, with the part that their reach is in.
struct Objects<'a> {
    /// With the index of the category.
    known: Vec<(usize, usize, &'a ObjectExample)>,
    families: Vec<(usize, &'a ObjectExample)>,
}

impl<'a> Objects<'a> {
    fn of(known: &[&'a [ObjectExample]], auxiliary: &[&'a [ObjectExample]], categories: &[String]) -> Self {
        let mut objects = Objects { known: Vec::new(), families: Vec::new() };
        let reaches = known.iter().map(|own| (false, own)).chain(auxiliary.iter().map(|own| (true, own)));
        for (reach, (is_auxiliary, own)) in reaches.enumerate() {
            for object in own.iter() {
                if let Some(category) = categories.iter().position(|name| name == object.category) {
                    objects.known.push((category, reach % FOLDS, object));
                } else if is_auxiliary && object.category != Category::BLOCK.name() {
                    // Foam blocks are part of the environment.
                    objects.families.push((reach % FOLDS, object));
                }
            }
        }
        objects
    }

    /// Trees for each family, fitted to all parts but this one.
    fn fit(&self, families: &[&str], without: Option<usize>) -> Vec<Family> {
        let known: Vec<_> = self.known.iter().filter(|(_, fold, _)| Some(*fold) != without).collect();
        let counts = frequencies(known.iter().map(|(category, ..)| *category));
        let family = |name: &&str| {
            let own = self.families.iter().filter(|(fold, own)| own.category == *name && Some(*fold) != without);
            let family: Vec<&ObjectExample> = own.map(|(_, own)| *own).collect();
            // The known objects together count as much as the family, each category the same, each of its objects too.
            let weight = |category: usize| 1.0 / (counts.len() * counts[&category]) as f64;
            let rows = known.iter().flat_map(|(category, _, own)| own.judged_rows(false, weight(*category)));
            let own_rows = family.iter().flat_map(|own| own.judged_rows(true, 1.0 / family.len() as f64));
            let rows: Vec<Row<'_>> = rows.chain(own_rows).collect();
            let trees = Boosted::fit(Loss::Logistic, &rows, OBJECT_FEATURE_COUNT);
            Family { name: (*name).to_owned(), objects: family.len(), trees }
        };
        families.iter().map(family).collect()
    }

    /// The scores of the known objects of a category at the end of a stage, each by trees that were fitted to other reaches.
    fn scores(&self, category: usize, stage: usize, held_out: &[Vec<Family>]) -> Vec<Vec<f64>> {
        let scores = |(_, fold, object): &(usize, usize, &ObjectExample)| -> Option<Vec<f64>> {
            let (_, features) = object.rows.iter().rfind(|(samples, _)| unknown::stage(*samples) == stage)?;
            Some(held_out[*fold].iter().map(|own| own.trees.score(features)).collect())
        };
        self.known.iter().filter(|(own, ..)| *own == category).filter_map(scores).collect()
    }
}
