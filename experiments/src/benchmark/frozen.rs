//! What never changes in the benchmark: scenes, seeds, numbers of reaches, and the moments at which contacts are
//! judged.
//!
//! `experiments/benchmarks` is a link to the folder `benchmarks` of the repository, so that the package of this crate
//! contains the files.

use std::collections::BTreeMap;

use underbrush_recording::InputError;
use underbrush_sim::arm::{Arm, ArmSource};
use underbrush_sim::scene::Scene;

/// Name of the benchmark.
pub(super) const NAME: &str = "incidental-contact-1";

/// Seeds of the three tracks.
pub(super) const VERDICTS_SEED: u64 = 910_000;
pub(super) const TRANSFER_SEED: u64 = 910_001;
pub(super) const REACHING_SEED: u64 = 910_002;

/// The scene with the foam roll, and the one with the water bottle.
pub(super) const FOAM_ROLL: &str = "foam-roll";
pub(super) const WATER_BOTTLE: &str = "water-bottle";

/// Scenes in which verdicts are judged.
pub(super) const VERDICTS_SCENES: &[&str] = &["leaf", "trunk", "mixed", FOAM_ROLL, WATER_BOTTLE];
/// The settings of arm, speed and sensor in the track transfer, by name and scene. The first is as in training. All
/// scenes except the one with another arm are called `mixed`, so that clutter and goals are the same.
pub(super) const SETTINGS: &[(&str, &str)] = &[
    ("as-trained", "mixed"),
    ("half-stiffness", "half-stiffness/mixed"),
    ("double-stiffness", "double-stiffness/mixed"),
    ("half-speed", "half-speed/mixed"),
    ("double-speed", "double-speed/mixed"),
    ("poor-sensor", "poor-sensor/mixed"),
    (OTHER_ARM, "other-arm/other-arm"),
];
/// The setting with another arm, and its scene.
pub(super) const OTHER_ARM: &str = "other-arm";
/// The scene that controllers reach through.
pub(super) const REACHING_SCENE: &str = "mixed";

/// Reaches of each scene in which verdicts are judged.
pub(super) const JUDGED_REACHES: u64 = 40;
/// Reaches of each controller.
pub(super) const CONTROLLED_REACHES: u64 = 500;
/// A quick run has this many reaches of each scene.
pub(super) const QUICK_REACHES: u64 = 2;

/// The patch that is judged.
pub(super) const PATCH: &str = "forearm";
/// A taxel is in contact while it senses more than this, N.
pub(super) const THRESHOLD_N: f64 = 0.03;
/// Numbers of samples since contact after which a contact is judged. It is judged at its end, too.
pub(super) const MOMENTS: [usize; 9] = [1, 2, 3, 6, 12, 25, 50, 100, 200];

macro_rules! texts {
    ($folder:literal: $($file:literal),* $(,)?) => {
        &[$(($file, include_str!(concat!("../../benchmarks/incidental-contact-1/scenes/", $folder, $file)))),*]
    };
}

const SCENES: &[(&str, &str)] = texts!["":
    "leaf.toml", "trunk.toml", "mixed.toml", "foam-roll.toml", "water-bottle.toml", "half-stiffness/mixed.toml",
    "double-stiffness/mixed.toml", "half-speed/mixed.toml", "double-speed/mixed.toml", "poor-sensor/mixed.toml",
    "other-arm/other-arm.toml",
];

const PANDA: &[(&str, &str)] = texts!["other-arm/panda/": "panda.toml", "panda.urdf", "panda.skin.toml"];

/// A frozen scene, by its path without the ending.
///
/// # Errors
/// Only when the frozen files are broken.
pub(super) fn scene(path: &str) -> Result<Scene, InputError> {
    let file = format!("{path}.toml");
    let Some((_, text)) = SCENES.iter().find(|(own, _)| *own == file) else {
        let remedy = "choose a scene of the benchmark";
        return Err(InputError::new(file, "file", "no such scene", "a frozen scene", remedy));
    };
    Scene::parse(file, (*text).to_owned())
}

/// The arms of those scenes that do not use Cody, by the name of the scene.
///
/// # Errors
/// Only when the frozen files are broken.
pub(super) fn arms(scenes: &[Scene]) -> Result<BTreeMap<String, Arm>, InputError> {
    if scenes.iter().all(|scene| scene.name != OTHER_ARM) {
        return Ok(BTreeMap::new());
    }
    let source = |(name, text): &(&str, &str)| ArmSource { name: (*name).to_owned(), text: (*text).to_owned() };
    let files: Vec<ArmSource> = PANDA.iter().map(source).collect();
    Ok([(OTHER_ARM.to_owned(), Arm::from_files(&files)?)].into())
}
