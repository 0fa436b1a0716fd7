//! The keys of a scene file, with their defaults.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits;
use crate::controller::ControllerKind;
use crate::object::{Specification, for_each_object_kind};
use crate::physics::PhysicsOptions;
use crate::range::{PLACE_M, Quantity, Within};
use crate::sensor::SensorOptions;

/// The keys of a scene file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// One sentence on what the scene shows; the task name in data sets.
    pub summary: String,
    /// `cody`, or a path to a user's arm file, relative to the scene file.
    #[serde(default = "default_arm")]
    pub arm: String,
    /// Controller of the arm: see `underbrush reach --help`.
    #[serde(default = "default_controller")]
    pub controller: ControllerKind,
    /// What is changed about the arm.
    #[serde(default)]
    pub robot: RobotSection,
    /// Where the clutter stands.
    #[serde(default)]
    pub workspace: Workspace,
    /// Goals of a reach.
    #[serde(default)]
    pub goals: Goals,
    /// The objects, in groups: `[[objects.leaf]]`, `[[objects.trunk]]`, `[[objects.foam_block]]`, …
    #[serde(default)]
    pub objects: Objects,
    /// The engine's step.
    #[serde(default)]
    pub physics: PhysicsSection,
    /// The skin's electronics.
    #[serde(default)]
    pub sensor: SensorOptions,
}

fn default_arm() -> String {
    "cody".into()
}

/// The flipper-era values of the authors' robot.
fn default_controller() -> ControllerKind {
    ControllerKind::Cody2013
}

/// What is changed about the arm and its controller, for other arms of the same build and other speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RobotSection {
    /// Factor on the stiffness of every joint, the simulated and the believed; the damping goes with its square root, which
    /// keeps the joints' damping ratio (a choice).
    #[schemars(range(min = limits::STIFFNESS_SCALE.least, max = limits::STIFFNESS_SCALE.most))]
    pub stiffness_scale: f64,
    /// Factor on what the controller allows the hand in one step: move, turn, and change of the equilibrium angles. The
    /// joints' own slew limits stay.
    #[schemars(range(min = limits::HAND_SPEED_SCALE.least, max = limits::HAND_SPEED_SCALE.most))]
    pub hand_speed_scale: f64,
}

impl Default for RobotSection {
    /// The arm and the controller as they are.
    fn default() -> Self {
        RobotSection {
            stiffness_scale: 1.0,
            hand_speed_scale: 1.0,
        }
    }
}

/// Where the clutter stands, in the world frame: origin at the arm's base, x forward, y left, z up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Workspace {
    /// Nearest and farthest foot of an object, m.
    pub x_m: [f64; 2],
    /// Rightmost and leftmost foot, m.
    pub y_m: [f64; 2],
    /// Height of the table top, m.
    #[schemars(range(min = PLACE_M.least, max = PLACE_M.most))]
    pub table_height_m: f64,
}

impl Default for Workspace {
    /// Choice: the foam's top lies 50 cm under the shoulder of Cody's right arm; the clutter stands from beside the
    /// drawn-back hand to the end of the arm's reach, so that the forearm comes among it and not the hand alone.
    fn default() -> Self {
        Workspace {
            x_m: [0.20, 0.75],
            y_m: [-0.60, 0.20],
            table_height_m: -0.58,
        }
    }
}

/// Goals of a reach: points for the arm's tip, drawn so that the way there passes through clutter.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Goals {
    /// How many per reach ("multiple goal positions", paper, section IV-B).
    #[schemars(range(min = limits::GOALS.least, max = limits::GOALS.most))]
    pub count: u32,
    /// How often a goal is tried again, after backing off, where the arm got stuck (Jain et al. 2013).
    #[schemars(range(min = limits::RETRIES.least, max = limits::RETRIES.most))]
    pub retries: u32,
    /// How long the operator, who gives the goals one by one (paper, section IV-B), watches an arm that makes no headway
    /// before giving the next, s. If not given, nobody watches: the controller's own rule decides when it is stuck.
    #[schemars(range(min = limits::PATIENCE_S.least, max = limits::PATIENCE_S.most))]
    pub patience_s: Option<f64>,
    /// Forward, m, world frame.
    #[schemars(transform = Within((PLACE_M.least, PLACE_M.most)))]
    pub x_m: Quantity,
    /// Left, m, world frame.
    #[schemars(transform = Within((PLACE_M.least, PLACE_M.most)))]
    pub y_m: Quantity,
    /// Up, m, world frame.
    #[schemars(transform = Within((PLACE_M.least, PLACE_M.most)))]
    pub z_m: Quantity,
}

impl Default for Goals {
    /// Choice: what Cody's arm reaches in front of its right shoulder, at the height of the foliage but clear of the foam.
    fn default() -> Self {
        Goals {
            count: 4,
            retries: 1,
            patience_s: None,
            x_m: Quantity::uniform(0.45, 0.75),
            y_m: Quantity::uniform(-0.55, 0.20),
            z_m: Quantity::uniform(-0.38, -0.16),
        }
    }
}

/// The engine's step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PhysicsSection {
    /// Length of a step, s; a whole number of steps makes 10 ms, the period of the skin. Not under 0.1 ms.
    #[schemars(range(min = limits::STEP_S.least, max = limits::STEP_S.most))]
    pub step_s: f64,
    /// Solver substeps in a step.
    #[schemars(range(min = limits::SUBSTEPS.least, max = limits::SUBSTEPS.most))]
    pub substeps: u32,
    /// Gravity, m/s².
    #[schemars(range(min = limits::GRAVITY_M_PER_S2.least, max = limits::GRAVITY_M_PER_S2.most))]
    pub gravity_m_per_s2: f64,
    /// Whether objects that nothing is near are left out of the solver until something comes near.
    pub dormancy: bool,
}

impl Default for PhysicsSection {
    /// Chosen from `benches/time_step.rs`: the contact force of a trunk is then within 1–2 % of that at steps of 0.1 ms
    /// (median), and shorter substeps do not come nearer until 1 ms.
    fn default() -> Self {
        PhysicsSection {
            step_s: 0.01,
            substeps: 2,
            gravity_m_per_s2: 9.81,
            dormancy: true,
        }
    }
}

impl PhysicsSection {
    /// The engine's options.
    pub fn options(&self) -> PhysicsOptions {
        PhysicsOptions {
            step_s: self.step_s,
            substeps: self.substeps as usize,
            gravity_m_per_s2: self.gravity_m_per_s2,
        }
    }
}

macro_rules! define_objects {
    ($($(#[$attribute:meta])* $key:ident: $specification:ty,)*) => {
        /// All groups of objects in a scene file, one list a kind.
        #[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Objects {
            $($(#[$attribute])* pub $key: Vec<$specification>,)*
        }

        impl Objects {
            /// Every group with its key and its number in the list of its kind, in the order in which they are placed.
            #[allow(unused_doc_comments, reason = "the entries' documentation is that of the fields")]
            pub fn groups(&self) -> Vec<(&'static str, usize, &dyn Specification)> {
                let mut groups: Vec<(&'static str, usize, &dyn Specification)> = Vec::new();
                $($(#[$attribute])* for (number, group) in self.$key.iter().enumerate() {
                    groups.push((stringify!($key), number, group));
                })*
                groups
            }
        }
    };
}
for_each_object_kind!(define_objects);
