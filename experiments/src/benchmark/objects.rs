//! The true objects that touch a patch in a reach, with what a model says about them.
//!
//! All contacts of a patch with one true object in a reach are one unit, so a wide trunk under thirty taxels weighs as much
//! as the tip of a leaf.

use std::collections::BTreeMap;

use underbrush_classifier::touch::TouchVerdict;
use underbrush_recording::Category;

/// Frames after the first one in which an object is felt, after which the verdict on it is judged: 0.1 s and 0.3 s. It is
/// judged at its end, too.
pub(super) const MOMENTS: [usize; 2] = [10, 30];
/// Number of moments at which an object is judged.
pub(super) const JUDGED_MOMENTS: usize = MOMENTS.len() + 1;
/// The last moment: the end of the object's last contact.
pub(super) const END: usize = MOMENTS.len();

/// The categories of the benchmark. An object of another category is unknown, and so is what a model gives another name.
pub(super) const CATEGORIES: [&str; 2] = ["leaf", "trunk"];

/// What an object is; `None` for a foam block, which belongs to the environment.
pub(super) fn truth_of(category: Category) -> Option<TouchVerdict> {
    (category != Category::BLOCK).then(|| TouchVerdict::named(category.name(), &CATEGORIES))
}

/// Which of a model's verdicts in the frames so far is its verdict on an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// The latest one: the model itself joins what it felt of an object.
    Latest,
    /// The one that most frames had: the model judges every contact of a taxel on its own.
    MostOfTheTime,
}

/// Numbers of answers. The answer nothing is no answer about an object.
type Votes = BTreeMap<TouchVerdict, usize>;

fn add(votes: &mut Votes, answer: TouchVerdict) {
    if answer != TouchVerdict::Nothing {
        *votes.entry(answer).or_default() += 1;
    }
}

/// The most frequent answer. A tie is uncertain; without any answer it is nothing.
fn most(votes: &Votes) -> TouchVerdict {
    let most = votes.values().max();
    let mut first = votes.iter().filter(|(_, count)| Some(*count) == most);
    match (first.next(), first.next()) {
        (None, _) => TouchVerdict::Nothing,
        (Some((answer, _)), None) => *answer,
        _ => TouchVerdict::Uncertain,
    }
}

/// The objects that have touched a patch so far, by their indices in the recording.
#[derive(Debug)]
pub(super) struct ObjectLog {
    standing: Standing,
    objects: BTreeMap<u16, OpenObject>,
    /// The answers of the present frame.
    frame: BTreeMap<u16, Votes>,
}

#[derive(Debug, Default)]
struct OpenObject {
    first_frame: usize,
    over_time: Votes,
    latest: TouchVerdict,
    verdicts: [TouchVerdict; JUDGED_MOMENTS],
}

impl ObjectLog {
    pub(super) fn new(standing: Standing) -> Self {
        ObjectLog { standing, objects: BTreeMap::new(), frame: BTreeMap::new() }
    }

    /// Takes in the answer about a taxel on which an object presses in this frame.
    pub(super) fn push(&mut self, object: u16, answer: TouchVerdict) {
        add(self.frame.entry(object).or_default(), answer);
    }

    /// Ends the frame with this index. The answer about an object in a frame is that of most of the taxels on which it
    /// presses.
    pub(super) fn end_frame(&mut self, index: usize) {
        for (object, votes) in std::mem::take(&mut self.frame) {
            let own = self.objects.entry(object).or_insert(OpenObject { first_frame: index, ..OpenObject::default() });
            let answer = most(&votes);
            add(&mut own.over_time, answer);
            if answer != TouchVerdict::Nothing {
                own.latest = answer;
            }
            let verdict = match self.standing {
                Standing::Latest => own.latest,
                Standing::MostOfTheTime => most(&own.over_time),
            };
            for (place, last) in own.verdicts.iter_mut().zip(MOMENTS.into_iter().chain([usize::MAX])) {
                if index - own.first_frame <= last {
                    *place = verdict;
                }
            }
        }
    }

    /// All objects of which `category` gives the true categories, once the reach is over.
    pub(super) fn finish(self, category: impl Fn(u16) -> Option<Category>) -> Vec<JudgedObject> {
        let judged = |(object, own): (u16, OpenObject)| {
            let truth = truth_of(category(object)?)?;
            Some(JudgedObject { truth, verdicts: own.verdicts })
        };
        self.objects.into_iter().filter_map(judged).collect()
    }
}

/// An object that touched a patch in a reach.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct JudgedObject {
    /// What it is.
    pub(super) truth: TouchVerdict,
    /// The verdicts after each of [`MOMENTS`] (the last one if its contacts ended before), and at the end.
    pub(super) verdicts: [TouchVerdict; JUDGED_MOMENTS],
}

#[cfg(test)]
mod tests {
    use underbrush_classifier::touch::TouchVerdict::{Nothing, Uncertain, Unknown};

    use super::*;

    const LEAF: TouchVerdict = TouchVerdict::Category(0);
    const TRUNK: TouchVerdict = TouchVerdict::Category(1);

    /// The object 7, a leaf, pressed on by answers per frame for several taxels, and what is said of it at each moment.
    fn verdicts(standing: Standing, frames: &[&[TouchVerdict]]) -> [TouchVerdict; JUDGED_MOMENTS] {
        let mut log = ObjectLog::new(standing);
        for (index, answers) in frames.iter().enumerate() {
            for answer in *answers {
                log.push(7, *answer);
            }
            log.end_frame(100 + index);
        }
        let [judged] = log.finish(|_| Some(Category::LEAF)).try_into().unwrap();
        assert_eq!(judged.truth, LEAF);
        judged.verdicts
    }

    /// Tests which frames count at each moment, for a verdict that stands and for one by majority of time, also if the
    /// contact is interrupted.
    #[test]
    fn verdicts_are_those_of_their_moments() {
        // Trunk in frames 0 to 10, leaf to 30, no touch for 50, and then a leaf in two thirds of the taxels.
        let mut frames: Vec<&[TouchVerdict]> = vec![&[TRUNK]; 11];
        frames.extend([&[LEAF] as &[TouchVerdict]; 20]);
        frames.extend([&[] as &[TouchVerdict]; 50]);
        frames.extend([&[Unknown, Unknown, LEAF, Nothing, Nothing, Nothing] as &[TouchVerdict]; 30]);
        assert_eq!(verdicts(Standing::Latest, &frames), [TRUNK, LEAF, Unknown]);
        assert_eq!(verdicts(Standing::MostOfTheTime, &frames), [TRUNK, LEAF, Unknown]);
        assert_eq!(verdicts(Standing::MostOfTheTime, &frames[..100]), [TRUNK, LEAF, LEAF]);
        // A contact of one frame has the same verdict at all moments.
        assert_eq!(verdicts(Standing::Latest, &frames[..1]), [TRUNK; 3]);
    }

    /// Tests that the answer nothing is none about an object unless there is no other, and that a tie is uncertain.
    #[test]
    fn nothing_is_no_answer_and_ties_are_uncertain() {
        for standing in [Standing::Latest, Standing::MostOfTheTime] {
            assert_eq!(verdicts(standing, &[&[LEAF], &[Nothing, Nothing]]), [LEAF; 3]);
            assert_eq!(verdicts(standing, &[&[Nothing], &[Nothing]]), [Nothing; 3]);
            assert_eq!(verdicts(standing, &[&[LEAF, TRUNK]]), [Uncertain; 3]);
        }
    }

    /// Tests that a wide trunk under many taxels and the tip of a leaf under one are one object each, and that a foam block
    /// is none.
    #[test]
    fn objects_weigh_alike() {
        let mut log = ObjectLog::new(Standing::Latest);
        for object in std::iter::repeat_n(1, 30).chain([0, 2]) {
            log.push(object, TRUNK);
        }
        log.end_frame(0);
        let categories = [Category::LEAF, Category::TRUNK, Category::BLOCK];
        let objects = log.finish(|object| Some(categories[usize::from(object)]));
        let found: Vec<_> = objects.iter().map(|own| (own.truth, own.verdicts[END])).collect();
        assert_eq!(found, [(LEAF, TRUNK), (TRUNK, TRUNK)]);
    }
}
