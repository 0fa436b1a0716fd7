//! The true objects that touch a patch in a reach, with what a model says about them.
//!
//! All contacts of a patch with one true object in a reach are one unit, so a wide trunk under thirty taxels weighs as much
//! as the tip of a leaf.

use std::collections::BTreeMap;

use underbrush_recording::Category;

/// Frames after the first one in which an object is felt, after which the verdict on it is judged: 0.1 s and 0.3 s. It is
/// judged at its end, too.
pub(super) const MOMENTS: [usize; 2] = [10, 30];
/// Number of moments at which an object is judged.
pub(super) const JUDGED_MOMENTS: usize = MOMENTS.len() + 1;
/// The last moment: the end of the object's last contact.
pub(super) const END: usize = MOMENTS.len();

/// What touches a taxel or an object is, or is said to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Class {
    /// Nothing.
    #[default]
    Nothing,
    /// A leaf.
    Leaf,
    /// A trunk.
    Trunk,
    /// An object foreign to the foliage. As an answer: unknown, or a category other than leaf and trunk.
    Unknown,
    /// The model does not decide. Only an answer, never the truth.
    Uncertain,
}

impl Class {
    /// The class of an object; `None` for a foam block, which belongs to the environment.
    pub(super) fn of(category: Category) -> Option<Self> {
        match category {
            Category::LEAF => Some(Class::Leaf),
            Category::TRUNK => Some(Class::Trunk),
            Category::BLOCK => None,
            _ => Some(Class::Unknown),
        }
    }
}

/// Which of a model's verdicts in the frames so far is its verdict on an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// The latest one: the model itself joins what it felt of an object.
    Latest,
    /// The one that most frames had: the model judges every contact of a taxel on its own.
    MostOfTheTime,
}

/// Numbers of answers leaf, trunk, unknown and uncertain. The answer nothing is no answer about an object.
#[derive(Clone, Copy, Debug, Default)]
struct Votes([usize; 4]);

impl Votes {
    const CLASSES: [Class; 4] = [Class::Leaf, Class::Trunk, Class::Unknown, Class::Uncertain];

    fn add(&mut self, class: Class) {
        if let Some(place) = Votes::CLASSES.iter().position(|own| *own == class) {
            self.0[place] += 1;
        }
    }

    /// The most frequent answer. A tie is uncertain; without any answer it is nothing.
    fn most(&self) -> Class {
        let most = self.0.into_iter().max().filter(|most| *most > 0);
        let mut first = (0..self.0.len()).filter(|place| Some(self.0[*place]) == most);
        match (first.next(), first.next()) {
            (None, _) => Class::Nothing,
            (Some(place), None) => Votes::CLASSES[place],
            _ => Class::Uncertain,
        }
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
    latest: Class,
    verdicts: [Class; JUDGED_MOMENTS],
}

impl ObjectLog {
    pub(super) fn new(standing: Standing) -> Self {
        ObjectLog { standing, objects: BTreeMap::new(), frame: BTreeMap::new() }
    }

    /// Takes in the answer about a taxel on which an object presses in this frame.
    pub(super) fn push(&mut self, object: u16, answer: Class) {
        self.frame.entry(object).or_default().add(answer);
    }

    /// Ends the frame with this index. The answer about an object in a frame is that of most of the taxels on which it
    /// presses.
    pub(super) fn end_frame(&mut self, index: usize) {
        for (object, votes) in std::mem::take(&mut self.frame) {
            let own = self.objects.entry(object).or_insert(OpenObject { first_frame: index, ..OpenObject::default() });
            let answer = votes.most();
            own.over_time.add(answer);
            if answer != Class::Nothing {
                own.latest = answer;
            }
            let verdict = match self.standing {
                Standing::Latest => own.latest,
                Standing::MostOfTheTime => own.over_time.most(),
            };
            for (place, last) in own.verdicts.iter_mut().zip(MOMENTS.into_iter().chain([usize::MAX])) {
                if index - own.first_frame <= last {
                    *place = verdict;
                }
            }
        }
    }

    /// All objects with their true classes, which `category` gives, once the reach is over.
    pub(super) fn finish(self, category: impl Fn(u16) -> Option<Category>) -> Vec<JudgedObject> {
        let judged = |(object, own): (u16, OpenObject)| {
            let truth = Class::of(category(object)?)?;
            Some(JudgedObject { truth, verdicts: own.verdicts })
        };
        self.objects.into_iter().filter_map(judged).collect()
    }
}

/// An object that touched a patch in a reach.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct JudgedObject {
    /// What it is.
    pub(super) truth: Class,
    /// The verdicts after each of [`MOMENTS`] (the last one if its contacts ended before), and at the end.
    pub(super) verdicts: [Class; JUDGED_MOMENTS],
}

#[cfg(test)]
mod tests {
    use super::Class::{Leaf, Nothing, Trunk, Uncertain, Unknown};
    use super::*;

    /// The object 7, a leaf, pressed on by answers per frame for several taxels, and what is said of it at each moment.
    fn verdicts(standing: Standing, frames: &[&[Class]]) -> [Class; JUDGED_MOMENTS] {
        let mut log = ObjectLog::new(standing);
        for (index, answers) in frames.iter().enumerate() {
            for class in *answers {
                log.push(7, *class);
            }
            log.end_frame(100 + index);
        }
        let [judged] = log.finish(|_| Some(Category::LEAF)).try_into().unwrap();
        assert_eq!(judged.truth, Leaf);
        judged.verdicts
    }

    /// Tests which frames count at each moment, for a verdict that stands and for one by majority of time, also if the
    /// contact is interrupted.
    #[test]
    fn verdicts_are_those_of_their_moments() {
        // Trunk in frames 0 to 10, leaf to 30, no touch for 50, and then a leaf in two thirds of the taxels.
        let mut frames: Vec<&[Class]> = vec![&[Trunk]; 11];
        frames.extend([&[Leaf] as &[Class]; 20]);
        frames.extend([&[] as &[Class]; 50]);
        frames.extend([&[Unknown, Unknown, Leaf, Nothing, Nothing, Nothing] as &[Class]; 30]);
        assert_eq!(verdicts(Standing::Latest, &frames), [Trunk, Leaf, Unknown]);
        assert_eq!(verdicts(Standing::MostOfTheTime, &frames), [Trunk, Leaf, Unknown]);
        assert_eq!(verdicts(Standing::MostOfTheTime, &frames[..100]), [Trunk, Leaf, Leaf]);
        // A contact of one frame has the same verdict at all moments.
        assert_eq!(verdicts(Standing::Latest, &frames[..1]), [Trunk; 3]);
    }

    /// Tests that the answer nothing is none about an object unless there is no other, and that a tie is uncertain.
    #[test]
    fn nothing_is_no_answer_and_ties_are_uncertain() {
        for standing in [Standing::Latest, Standing::MostOfTheTime] {
            assert_eq!(verdicts(standing, &[&[Leaf], &[Nothing, Nothing]]), [Leaf; 3]);
            assert_eq!(verdicts(standing, &[&[Nothing], &[Nothing]]), [Nothing; 3]);
            assert_eq!(verdicts(standing, &[&[Leaf, Trunk]]), [Uncertain; 3]);
        }
    }

    /// Tests that a wide trunk under many taxels and the tip of a leaf under one are one object each, and that a foam block
    /// is none.
    #[test]
    fn objects_weigh_alike() {
        let mut log = ObjectLog::new(Standing::Latest);
        for object in std::iter::repeat_n(1, 30).chain([0, 2]) {
            log.push(object, Trunk);
        }
        log.end_frame(0);
        let categories = [Category::LEAF, Category::TRUNK, Category::BLOCK];
        let objects = log.finish(|object| Some(categories[usize::from(object)]));
        let found: Vec<_> = objects.iter().map(|own| (own.truth, own.verdicts[END])).collect();
        assert_eq!(found, [(Leaf, Trunk), (Trunk, Trunk)]);
    }
}
