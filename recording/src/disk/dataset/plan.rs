//! The plan of a data set: its content and origin, fixed before the first reach runs and compared on resume.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{Category, SkinLayout, shortened};

/// Everything that determines the bytes of a data set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DatasetPlan {
    /// Where the data come from.
    pub provenance: Provenance,
    /// Name of the robot (`robot_type` in LeRobot's `info.json`).
    pub robot: String,
    /// Frames per second.
    pub rate_hz: f64,
    /// Names of the joints, in the order of a frame's joint columns.
    pub joint_names: Vec<String>,
    /// The skin, the same in every reach.
    pub layout: SkinLayout,
    /// Categories that objects of these reaches may have besides [`Category::BUILT_IN`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub categories: Vec<Category>,
    /// The reaches in the order of their episodes.
    pub episodes: Vec<PlannedEpisode>,
}

/// One planned reach.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedEpisode {
    /// Name of its scene.
    pub scene: String,
    /// The task of the arm, as a sentence (LeRobot's `task`).
    pub task: String,
    /// Its index in the campaign. Seed and index together determine all random draws.
    pub reach_index: u64,
}

/// The origin of a data set, sufficient to generate it again. Facts about the run (date, machine, threads) are not
/// stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the program.
    pub program: String,
    /// Version of the program.
    pub program_version: String,
    /// Name and version of the physics engine (or of the robot's software).
    pub engine: String,
    /// What the build computes with: a hash of values of the elementary functions that data depend on. Builds that differ
    /// here make other data. Empty for data that are not simulated.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub arithmetic: String,
    /// Options of the engine and of the sensor, by scene. They are for readers only: the text of the scenes generates the
    /// set again. JSON has no infinity, so `null` is a saturation that the scene switches off with `inf`.
    pub options: BTreeMap<String, Value>,
    /// The scenes, in the order of the campaign.
    pub scenes: Vec<SceneText>,
    /// The arms of the scenes, each once.
    pub arms: Vec<ArmText>,
    /// The campaign's seed.
    pub seed: u64,
    /// Name of the controller.
    pub controller: String,
    /// Parameters of the controller, by scene.
    pub controller_parameters: BTreeMap<String, Value>,
    /// The part of the campaign in this set; `None` for all of it.
    pub shard: Option<Shard>,
}

/// A scene of a campaign.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneText {
    /// Name of the scene.
    pub name: String,
    /// Reaches of this scene in the whole campaign, all shards together.
    pub reaches: u64,
    /// Its arm: index in [`Provenance::arms`].
    pub arm: usize,
    /// The scene file.
    pub file: FileText,
}

/// The files that describe an arm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArmText {
    /// Name of the arm.
    pub name: String,
    /// Its files with names relative to its folder, first the one that names the others.
    pub files: Vec<FileText>,
}

/// A text file with its content.
///
/// ```
/// use underbrush_recording::disk::FileText;
///
/// let [one, other] = ["count = 3", "count = 4"].map(|text| FileText::new("scene.toml", text));
/// assert!(one != other && one.blake3.len() == 64);
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileText {
    /// Name of the file.
    pub name: String,
    /// BLAKE3 hash of the text, hexadecimal.
    pub blake3: String,
    /// The whole text.
    pub text: String,
}

impl FileText {
    /// A text with its hash.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        FileText { name: name.into(), blake3: blake3::hash(text.as_bytes()).to_hex().to_string(), text }
    }
}

/// One part of a campaign that is divided among several machines.
///
/// ```
/// use underbrush_recording::disk::Shard;
///
/// // The second of three parts.
/// let shard = Shard { index: 1, count: 3 };
/// let own: Vec<u64> = (0..7).filter(|position| shard.holds(*position)).collect();
/// assert_eq!(own, [1, 4]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which part, from 0.
    pub index: u64,
    /// How many parts.
    pub count: u64,
}

impl Shard {
    /// Whether this part has the reach at a position of the whole campaign: every part takes each `count`-th reach, so that
    /// all parts have reaches of all scenes.
    pub fn holds(&self, position: u64) -> bool {
        position % self.count == self.index
    }
}

/// As `--shard` writes it: counted from 1.
impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

/// The first difference between two plans: its path and both values. The provenance is compared first because
/// everything else follows from it. A changed skin file is then reported as that file, and not as the first taxel
/// that moved.
pub(crate) fn first_difference(stored: &Value, given: &Value) -> Option<(String, String, String)> {
    const FIRST: &str = "provenance";
    search(FIRST, stored.get(FIRST), given.get(FIRST)).or_else(|| search("", Some(stored), Some(given)))
}

fn brief(value: Option<&Value>) -> String {
    value.map_or("absent".to_string(), |value| shortened(&value.to_string(), 60))
}

fn search(path: &str, stored: Option<&Value>, given: Option<&Value>) -> Option<(String, String, String)> {
    match (stored, given) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let keys: BTreeSet<_> = a.keys().chain(b.keys()).collect();
            keys.into_iter().find_map(|key| {
                let path = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
                search(&path, a.get(key), b.get(key))
            })
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => (0..a.len().max(b.len())).find_map(|index| {
            let (stored, given) = (a.get(index), b.get(index));
            // Entries with a name, such as files, are identified by it.
            let name = |entry: Option<&Value>| entry.and_then(|entry| entry.get("name")).cloned();
            let path = match name(stored) {
                Some(own) if Some(&own) == name(given).as_ref() => format!("{path}[{own}]"),
                _ => format!("{path}[{index}]"),
            };
            search(&path, stored, given)
        }),
        (a, b) if a == b => None,
        (a, b) => Some((path.to_string(), brief(a), brief(b))),
    }
}
