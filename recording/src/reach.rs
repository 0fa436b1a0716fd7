//! One whole reach: its frames, objects, contacts and outcome.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::{Deserialize, Serialize, Serializer};

use crate::{Audit, Body, Category, Frame, GoalOutcomes, MappedObstacle, NamedStop, Outcome, SafetyStop, SkinLayout};

/// One object of the clutter, as ground truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectRecord {
    /// Its kind in the scene file (`leaf`, `trunk`, `foam_block`, `foam_roll`).
    pub kind: String,
    /// Its category.
    pub category: Category,
    /// Position of its foot, m, world frame.
    pub position_world: DVec3,
    /// The parameters drawn for it, by name, with SI units in the names.
    pub parameters: BTreeMap<String, f64>,
}

/// One goal of a reach and how it ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalRecord {
    /// Goal position of the end effector, m, world frame.
    pub position_world: DVec3,
    /// Time at which the arm started towards it, s.
    pub start_time_s: f64,
    /// Time at which it was reached or given up, s.
    pub end_time_s: f64,
    /// How it ended.
    pub outcome: Outcome,
    /// The contact that ended it. Only with [`Outcome::Aborted`], and even then `None` if it is not known, as on a
    /// robot that an operator stopped.
    pub safety_stop: Option<SafetyStop>,
    /// Why the controller gave it up, in the controller's words. Only with [`Outcome::Stuck`], and `None` if it was not
    /// the controller that gave it up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given_up: Option<String>,
}

/// One contact of an object with a patch, or with a part of a link without skin, from its first frame to its last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Name of the link; for a patch, of the link that carries it.
    pub link: String,
    /// Patch of the layout; `None` for a part of the link without skin.
    pub patch: Option<u16>,
    /// Index in [`Recording::objects`].
    pub object: u16,
    /// First frame in contact.
    pub first_frame: u32,
    /// Last frame in contact.
    pub last_frame: u32,
    /// Largest contact force in any frame, N: the magnitude of the solver's force between the two.
    pub peak_force_n: f64,
    /// Mean of that force over the frames of the contact, N.
    pub mean_force_n: f64,
}

/// How hard some contacts pressed, over all of their frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForces {
    /// Number of contacts.
    pub contacts: usize,
    /// Largest contact force in any frame, N; 0 without contacts.
    pub peak_n: f64,
    /// Mean contact force over the frames of all contacts, N; 0 without contacts.
    pub mean_n: f64,
}

/// One reach: everything that was sensed, and the ground truth.
///
/// ```
/// use glam::DVec3;
/// use std::collections::BTreeMap;
/// use underbrush_recording::{Audit, Category, Contact, GoalRecord, ObjectRecord, Outcome, Recording, SkinLayout};
///
/// let trunk = ObjectRecord {
///     kind: "trunk".into(),
///     category: Category::TRUNK,
///     position_world: DVec3::ZERO,
///     parameters: BTreeMap::new(),
/// };
/// let goal = |outcome| GoalRecord {
///     position_world: DVec3::X,
///     start_time_s: 0.0,
///     end_time_s: 2.0,
///     outcome,
///     safety_stop: None,
///     given_up: None,
/// };
/// // Two frames at 6 N on average, then six at 2 N.
/// let contact = |first_frame, last_frame, mean_force_n| Contact {
///     link: "forearm".into(),
///     patch: None,
///     object: 0,
///     first_frame,
///     last_frame,
///     peak_force_n: 1.5 * mean_force_n,
///     mean_force_n,
/// };
/// let reach = Recording {
///     scene: "lab".into(),
///     controller: "by-hand".into(),
///     seed: 0,
///     reach_index: 0,
///     rate_hz: 100.0,
///     joint_names: Vec::new(),
///     layout: SkinLayout::default(),
///     objects: vec![trunk],
///     bodies: Vec::new(),
///     goals: vec![goal(Outcome::Reached), goal(Outcome::Stuck)],
///     contacts: vec![contact(0, 1, 6.0), contact(10, 15, 2.0)],
///     map: Vec::new(),
///     frames: Vec::new(),
///     audit: Audit::default(),
/// };
/// assert_eq!(reach.outcome(), Outcome::Stuck);
/// assert_eq!(reach.goal_outcomes().reached, 1);
/// let forces = reach.contact_forces(Some(Category::TRUNK));
/// assert_eq!((forces.contacts, forces.peak_n, forces.mean_n), (2, 9.0, 3.0));
/// assert_eq!(reach.contact_forces(Some(Category::LEAF)).contacts, 0);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scene.
    pub scene: String,
    /// Name of the controller.
    pub controller: String,
    /// The campaign's seed.
    pub seed: u64,
    /// Index of the reach in its campaign. Seed and index together determine all random draws.
    pub reach_index: u64,
    /// Frames per second.
    pub rate_hz: f64,
    /// Names of the joints, in the order of a frame's joint columns.
    pub joint_names: Vec<String>,
    /// The skin.
    pub layout: SkinLayout,
    /// The objects of the clutter.
    pub objects: Vec<ObjectRecord>,
    /// The links of the arm and the bodies of the objects; empty if they are not known.
    pub bodies: Vec<Body>,
    /// The goals in the order in which they were tried.
    pub goals: Vec<GoalRecord>,
    /// Contacts, sorted by first frame, then patch, link and object.
    pub contacts: Vec<Contact>,
    /// The controller's map, if it keeps one, sorted by first frame.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub map: Vec<MappedObstacle>,
    /// The samples. As the tracks of bodies, they are not serialized: files have them in columns.
    #[serde(serialize_with = "no_frames")]
    pub frames: Vec<Frame>,
    /// Residuals of the physics.
    pub audit: Audit,
}

/// Serializes an empty list in place of frames.
fn no_frames<S: Serializer>(_: &[Frame], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq([(); 0])
}

impl Recording {
    /// The name of the controller in a robot's log, which does not say what moved the robot.
    pub const UNKNOWN_CONTROLLER: &str = "unknown";

    /// Whether it is a robot's log. Then nobody knows controller, seed, goals or audit, and their fields say nothing.
    pub fn is_log(&self) -> bool {
        self.controller == Self::UNKNOWN_CONTROLLER
    }

    /// The categories of the objects that are not built in, each once, by code.
    pub fn further_categories(&self) -> Vec<Category> {
        Category::further(self.objects.iter().map(|object| object.category))
    }

    /// The outcome of the whole reach: the worst outcome of its goals.
    pub fn outcome(&self) -> Outcome {
        self.goals.iter().map(|goal| goal.outcome).max().unwrap_or(Outcome::Reached)
    }

    /// The number of goals with each outcome.
    pub fn goal_outcomes(&self) -> GoalOutcomes {
        let mut counts = GoalOutcomes::default();
        for goal in &self.goals {
            counts.count(goal.outcome);
        }
        counts
    }

    /// The contact that ended the reach, if a force exceeded the controller's stop force.
    pub fn safety_stop(&self) -> Option<NamedStop> {
        let stop = self.goals.iter().find_map(|goal| goal.safety_stop.as_ref())?;
        let patch = stop.patch.and_then(|patch| self.layout.patches.get(usize::from(patch)));
        Some(NamedStop {
            object_index: stop.object,
            object_kind: match stop.object {
                Some(object) => self.objects.get(usize::from(object))?.kind.clone(),
                None => "arm".into(),
            },
            link: stop.link.clone(),
            patch: patch.map(|patch| patch.name.clone()),
            force_n: stop.force_n,
        })
    }

    /// The category of the object with this index; `None` if there is no such object.
    pub fn category_of(&self, object: u16) -> Option<Category> {
        self.objects.get(usize::from(object)).map(|object| object.category)
    }

    /// The forces of the contacts with objects of this category, or with any object.
    pub fn contact_forces(&self, category: Option<Category>) -> ContactForces {
        let wanted = |contact: &&Contact| category.is_none() || self.category_of(contact.object) == category;
        let (mut forces, mut frames, mut sum_n) = (ContactForces::default(), 0.0, 0.0);
        for contact in self.contacts.iter().filter(wanted) {
            let own_frames = f64::from(contact.last_frame - contact.first_frame + 1);
            forces.contacts += 1;
            forces.peak_n = forces.peak_n.max(contact.peak_force_n);
            frames += own_frames;
            sum_n += contact.mean_force_n * own_frames;
        }
        if frames > 0.0 {
            forces.mean_n = sum_n / frames;
        }
        forces
    }

    /// The number of frames in which an object truly pressed on each patch, by the patch's name. Sensor readings do not
    /// count, since spurious readings and creep are not contact. All are 0 if ground truth is unknown, as on a robot.
    pub fn touched_frames(&self) -> BTreeMap<String, u32> {
        let frames_of = |patch: usize| {
            let on_patch =
                |contact: &&Contact| contact.patch.map(usize::from) == Some(patch) && contact.peak_force_n > 0.0;
            let contacts = self.contacts.iter().filter(on_patch);
            let mut spans: Vec<(u32, u32)> = contacts.map(|own| (own.first_frame, own.last_frame)).collect();
            spans.sort_unstable();
            let (mut frames, mut next) = (0, 0);
            for (first, last) in spans {
                // A frame in which two objects press on the patch counts once.
                let first = first.max(next);
                if first <= last {
                    frames = (last - first).saturating_add(1).saturating_add(frames);
                    next = last.saturating_add(1);
                }
            }
            frames
        };
        let patches = self.layout.patches.iter().enumerate();
        patches.map(|(index, patch)| (patch.name.clone(), frames_of(index))).collect()
    }
}

#[cfg(test)]
mod tests;
