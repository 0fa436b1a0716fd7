//! The keys of a scene file, with their defaults.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{SceneCamera, limits};
use crate::materials::MaterialsSection;
use crate::object::{Group, Specification, for_each_object_kind};
use crate::range::{Draw, PLACE_M, Within, options};
use crate::{ControllerKind, PhysicsOptions, SensorOptions};

/// The keys of a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// One sentence that says what the scene shows. Data sets use it as the name of the task.
    pub summary: String,
    /// Names the random numbers that the reaches draw. Scenes with the same stream draw the same numbers, so scenes that
    /// differ in one property of their objects can be compared on the same clutter. If not given, it follows from the
    /// objects: another file with the same objects draws the same clutter, whatever its name and its other options.
    pub stream: Option<String>,
    /// `cody`, or the path of an arm file, relative to the scene file.
    #[serde(default = "default_arm")]
    pub arm: String,
    /// The arm's controller.
    #[serde(default)]
    pub controller: ControllerKind,
    /// Changes to the arm and its controller.
    #[serde(default)]
    pub robot: RobotSection,
    /// With `--verdicts`: how hard the arm may press on objects of a category, or on `unknown` ones, N. The controller's
    /// own limit holds for all others, and so do 6 N on leaves and 1.5 N on trunks, if not given.
    #[serde(default)]
    #[schemars(transform = Within(limits::ALLOWED_FORCE_N))]
    pub allowed_force_n: BTreeMap<String, f64>,
    /// Where objects may stand.
    #[serde(default)]
    pub workspace: Workspace,
    /// The goals of a reach.
    #[serde(default)]
    pub goals: Goals,
    /// The objects, in groups: `[[objects.leaf]]`, `[[objects.trunk]]`, `[[objects.foam_block]]` and others.
    #[serde(default)]
    pub objects: Objects,
    /// From where pictures of the reaches are taken.
    #[serde(default)]
    pub cameras: Vec<SceneCamera>,
    /// Constants of the contact between arm and objects, to be set or drawn for each reach.
    #[serde(default)]
    pub materials: MaterialsSection,
    /// Pairs of kinds that pass through each other instead of colliding, such as `[["leaf", "leaf"], ["arm", "foam_block"]]`:
    /// `arm` and the keys of objects. Goals and plans still keep clear of what an arm passes through.
    #[serde(default)]
    pub passing: Vec<[String; 2]>,
    /// Time step and other options of the physics engine.
    #[serde(default)]
    pub physics: PhysicsSection,
    /// What is recorded.
    #[serde(default)]
    pub recording: RecordingSection,
    /// Properties of the tactile sensors.
    #[serde(default)]
    pub sensor: SensorOptions,
}

fn default_arm() -> String {
    "cody".into()
}

options! {
    /// Changes to the arm and its controller: a stiffer or softer arm, a faster or slower hand, higher or lower allowed
    /// forces.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct RobotSection {
        /// Scales the stiffness of every joint and of the controller's model. The damping scales with its square root,
        /// which keeps the joints' damping ratio (a choice).
        stiffness_scale: f64 = 1.0, limits::STIFFNESS_SCALE;
        /// Scales how far the controller may move the hand and the equilibrium angles in one step. The joints' own slew
        /// limits stay as they are.
        hand_speed_scale: f64 = 1.0, limits::HAND_SPEED_SCALE;
        /// Scales the force that the controller allows a taxel, f_max. How fast it may rise or fall stays the same.
        force_limit_scale: f64 = 1.0, limits::FORCE_LIMIT_SCALE;
    }
}

options! {
    // Choice: the top of the foam is 50 cm below the shoulder of Cody's right arm. The clutter extends from beside the
    // drawn-back hand to the limit of the arm's reach, so that the forearm moves among it and not only the hand.
    /// Where objects may stand, in the world frame: origin at the arm's base, x forward, y left, z up.
    #[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Workspace {
        /// Smallest and largest x of an object's foot, m.
        #[schemars(transform = Within(PLACE_M))]
        x_m: [f64; 2] = [0.20, 0.75];
        /// Smallest and largest y of an object's foot, m.
        #[schemars(transform = Within(PLACE_M))]
        y_m: [f64; 2] = [-0.60, 0.20];
        /// Height of the table top, m.
        table_height_m: f64 = -0.58, PLACE_M;
    }
}

options! {
    // Choice: what Cody's arm can reach in front of its right shoulder, at the height of the foliage but clear of the
    // foam.
    /// The goals of a reach: points for the arm's end effector, drawn so that the arm passes through clutter on its way
    /// there.
    #[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Goals {
        /// Number of goals per reach (the paper has "multiple goal positions", section IV-B).
        count: u32 = 4, limits::GOALS;
        /// How many times an arm that got stuck backs off and tries the same goal again (Jain et al. 2013).
        retries: u32 = 1, limits::RETRIES;
        /// How long the arm may make no progress before the goal is given up, s, as by the operator who gives the goals one
        /// by one (paper, section IV-B). If not given, the rule published with the controller decides when the arm is
        /// stuck.
        #[schemars(transform = Within(limits::PATIENCE_S))]
        patience_s: Option<f64> = None;
        /// The goals, m, world frame, in this order. If they are given, none are drawn, and `count` and the ranges below have
        /// no effect.
        #[schemars(transform = Within(PLACE_M))]
        positions_m: Option<Vec<[f64; 3]>> = None;
        /// What is progress: `mean-position`, as published, or `path`, by which an arm that turns round makes progress. If not
        /// given, the rule that belongs to the controller.
        progress: Option<ProgressRule> = None;
        /// Coordinate x of a goal (forward), m, world frame.
        #[schemars(transform = Within(PLACE_M))]
        x_m: Draw = Draw::Uniform(0.45, 0.75);
        /// Coordinate y of a goal (left), m, world frame.
        #[schemars(transform = Within(PLACE_M))]
        y_m: Draw = Draw::Uniform(-0.55, 0.20);
        /// Coordinate z of a goal (up), m, world frame.
        #[schemars(transform = Within(PLACE_M))]
        z_m: Draw = Draw::Uniform(-0.38, -0.16);
    }
}

impl Goals {
    /// How many goals a reach has.
    pub fn number(&self) -> u32 {
        self.positions_m.as_ref().map_or(self.count, |positions| positions.len() as u32)
    }
}

/// What is progress of an end effector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProgressRule {
    /// The distance between its mean positions in the two halves of the window, as published. An arm that turns round
    /// makes none.
    #[default]
    MeanPosition,
    /// Its distance from the place where it last made progress. An arm that turns round makes progress, and one that
    /// shakes in place makes none.
    Path,
}

impl ProgressRule {
    /// Whether it is the published rule.
    pub(crate) fn is_published(&self) -> bool {
        *self == ProgressRule::MeanPosition
    }
}

options! {
    // 5 ms: steps of 10 ms make leaves chatter, and steps of 2.5 ms change the figures little at twice the cost.
    // `docs/evidence/time-step.md` gives the convergence in the step.
    /// Time step and other options of the physics engine.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct PhysicsSection {
        /// Time step, s: 10 ms (the period of the skin) or a whole fraction of it, at least 0.1 ms.
        step_s: f64 = 0.005, limits::STEP_S;
        /// Gravity, m/s².
        gravity_m_per_s2: f64 = 9.81, limits::GRAVITY_M_PER_S2;
        /// Whether objects at rest are left out of the simulation until something comes near them.
        dormancy: bool = true;
    }
}

impl PhysicsSection {
    /// The engine's options.
    pub fn options(&self) -> PhysicsOptions {
        PhysicsOptions { step_s: self.step_s, gravity_m_per_s2: self.gravity_m_per_s2 }
    }
}

/// What is recorded of a reach beside what a robot would know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RecordingSection {
    /// Whether the forces at all contacts are recorded. They take about as much space as the frames.
    pub contact_points: bool,
}

impl Default for RecordingSection {
    fn default() -> Self {
        RecordingSection { contact_points: true }
    }
}

macro_rules! define_objects {
    ($($(#[$attribute:meta])* $key:ident: $kind:ty,)*) => {
        /// All groups of objects in a scene file, one list for each kind.
        #[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Objects {
            $($(#[$attribute])* pub $key: Vec<Group<$kind>>,)*
        }

        impl Objects {
            /// Every group with its key and its index in the list of its kind, in the order of placement.
            #[allow(unused_doc_comments, reason = "the entries' documentation is that of the fields")]
            pub fn groups(&self) -> Vec<(&'static str, usize, &Specification)> {
                let mut groups = Vec::new();
                $($(#[$attribute])*
                groups.extend(self.$key.iter().enumerate().map(|(number, own)| (stringify!($key), number, &own.0)));)*
                groups
            }
        }
    };
}
for_each_object_kind!(define_objects);
