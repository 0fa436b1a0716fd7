//! Track 1: what an object is, by the time since it was first felt, with objects that are foreign to the foliage.

use serde::{Deserialize, Serialize};
use underbrush_recording::distinct;

use super::counts::{ALL, Counts, FittedNothing, FrameCounts, KNOWN, UNKNOWN};
use super::judged_model::JudgedReach;
use super::objects::{END, JUDGED_MOMENTS, JudgedObject, MOMENTS};
use crate::resampled::{Estimate, Ranking};

/// The figures of the track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdicts {
    /// The objects that touch the forearm.
    pub forearm: ObjectFigures,
    /// The objects that touch the flipper; `None` if the model does not judge it.
    pub flipper: Option<ObjectFigures>,
    /// Balanced accuracy over the forearm's taxels in contact, frame by frame: nothing, leaf or trunk.
    pub nothing_leaf_or_trunk: Estimate,
    /// The largest sensed force that counts as nothing, N, fitted by the benchmark; `None` for a model that can say so itself.
    pub nothing_up_to_n: Option<f64>,
}

/// The figures of the objects that touch a patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectFigures {
    /// Numbers of leaves, trunks and unknown objects.
    pub objects: [usize; 3],
    /// After each time, and at the end.
    pub moments: Vec<VerdictsAt>,
    /// The unknown objects of each scene that has any.
    pub unknown_in: Vec<UnknownIn>,
}

/// The figures at one moment, by the model's own decision. An object whose contacts ended before counts with its last
/// verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictsAt {
    /// Time since the object was first felt, s; `None` at the end of its last contact.
    pub seconds: Option<f64>,
    /// Mean of the shares of leaves, trunks and unknown objects that are called what they are.
    pub leaf_trunk_or_unknown: Estimate,
    /// Mean of the shares of leaves and of trunks that are called what they are.
    pub leaf_or_trunk: Estimate,
    /// Share of unknown objects that are called unknown.
    pub unknown_found: Estimate,
    /// Share of leaves and trunks that are called unknown.
    pub known_called_unknown: Estimate,
}

/// The unknown objects of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnknownIn {
    /// The scene.
    pub scene: String,
    /// Number of unknown objects.
    pub objects: usize,
    /// Share that is called unknown at the end.
    pub found: Estimate,
}

/// The figures of reaches, which are given with the names of their scenes.
pub(super) fn figures(reaches: &[(String, JudgedReach)], nothing: Option<FittedNothing>) -> Verdicts {
    let of_patch = |patch: usize| {
        let own = |(scene, reach): &(String, JudgedReach)| Some((scene.clone(), reach.objects[patch].clone()?));
        reaches.iter().map(own).collect::<Option<Vec<_>>>().map(|reaches| of_objects(&reaches))
    };
    let frames: Vec<&FrameCounts> = reaches.iter().map(|(_, reach)| &reach.frames).collect();
    Verdicts {
        forearm: of_patch(0).unwrap_or_else(|| of_objects(&[])),
        flipper: of_patch(1),
        nothing_leaf_or_trunk: Estimate::of(&frames, |own| {
            FrameCounts::accuracy(&own.iter().map(|own| **own).collect::<Vec<_>>(), nothing)
        }),
        nothing_up_to_n: nothing.map(FittedNothing::up_to_n),
    }
}

fn of_objects(reaches: &[(String, Vec<JudgedObject>)]) -> ObjectFigures {
    let counts = |moment| reaches.iter().map(|(_, objects)| Counts::of(objects, moment)).collect::<Vec<Counts>>();
    let at = |moment| {
        let counts = counts(moment);
        VerdictsAt {
            seconds: MOMENTS.get(moment).map(|frames| *frames as f64 / 100.0),
            leaf_trunk_or_unknown: Estimate::of(&counts, |own| Counts::accuracy(own, ALL)),
            leaf_or_trunk: Estimate::of(&counts, |own| Counts::accuracy(own, KNOWN)),
            unknown_found: Estimate::of(&counts, |own| Counts::accuracy(own, UNKNOWN)),
            known_called_unknown: Estimate::of(&counts, Counts::known_called_unknown),
        }
    };
    let scenes = distinct(reaches.iter().map(|(scene, _)| scene));
    let unknown_in = |scene: &String| {
        let own = reaches.iter().filter(|(own, _)| own == scene);
        let counts: Vec<Counts> = own.map(|(_, objects)| Counts::of(objects, END)).collect();
        let [_, _, objects] = Counts::objects(&counts);
        let found = Estimate::of(&counts, |own| Counts::accuracy(own, UNKNOWN));
        (objects > 0).then(|| UnknownIn { scene: scene.clone(), objects, found })
    };
    ObjectFigures {
        objects: Counts::objects(&counts(END)),
        moments: (0..JUDGED_MOMENTS).map(at).collect(),
        unknown_in: scenes.into_iter().filter_map(unknown_in).collect(),
    }
}

/// The ranking by the balanced accuracy of leaves, trunks and unknown objects at the forearm, at their end.
pub(super) fn ranking(halves: [&[(String, JudgedReach)]; 2]) -> Ranking {
    let counts = halves.map(|half| [half.iter().map(|(_, reach)| reach.at_end()).collect::<Vec<_>>()]);
    Ranking::of([&counts[0], &counts[1]], |groups| Counts::accuracy(&groups[0], ALL))
}
