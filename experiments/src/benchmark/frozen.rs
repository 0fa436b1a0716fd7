//! What never changes in the benchmark: scenes, seeds and numbers of reaches.
//!
//! `experiments/benchmarks` is a link to the folder `benchmarks` of the repository, so that the package of this crate
//! contains the files.

use std::collections::BTreeMap;

use underbrush_recording::InputError;
use underbrush_sim::arm::{Arm, ArmSource};
use underbrush_sim::scene::Scene;

/// Name of the benchmark.
pub(super) const NAME: &str = "incidental-contact-2";

/// Public seeds of the three tracks.
pub(super) const VERDICTS_SEED: u64 = 910_020;
pub(super) const TRANSFER_SEED: u64 = 910_021;
pub(super) const REACHING_SEED: u64 = 910_022;
/// Seed of the reaches to which the class "nothing" is fitted.
pub(super) const FITTING_SEED: u64 = 910_023;

/// The seed of the audit half of a track, from a hash of what is judged. It is from 2⁵² to 2⁵³, where whole numbers are
/// exact in every reader of JSON; all smaller seeds are free for other uses.
fn audit_seed(track: &str, judged: &str) -> u64 {
    let hash = blake3::hash(format!("{NAME} {track} {judged}").as_bytes());
    let first = hash.as_bytes().iter().take(8).fold(0, |number: u64, byte| number << 8 | u64::from(*byte));
    1 << 52 | first >> 12
}

/// The name and the seed of each half of a track: the public one, and the audit half of what is judged. The name of the audit half
/// has the hash of the model, because each model has other reaches. The hash is empty for a controller.
pub(super) fn halves(track: &str, public_seed: u64, judged: &str, hash: &str) -> [(String, u64); 2] {
    let audit = if hash.is_empty() { "audit".to_owned() } else { format!("audit-{hash:.8}") };
    [("public".to_owned(), public_seed), (audit, audit_seed(track, judged))]
}

/// Scenes with leaves and trunks only; the class "nothing" is fitted to these.
pub(super) const KNOWN_SCENES: &[&str] = &["leaf", "trunk", "mixed"];
/// Scenes in which verdicts are judged.
pub(super) const VERDICTS_SCENES: &[&str] =
    &["leaf", "trunk", "mixed", "foam-roll", "water-bottle", "soft-roll", "hard-roll", "springy-branch"];
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

/// Reaches of each scene in which verdicts are judged, in each half.
pub(super) const VERDICTS_REACHES: u64 = 25;
/// Reaches at each setting, in each half.
pub(super) const TRANSFER_REACHES: u64 = 20;
/// Reaches of each controller, in each half.
pub(super) const CONTROLLED_REACHES: u64 = 250;
/// Reaches of each scene to which the class "nothing" is fitted.
pub(super) const FITTING_REACHES: u64 = 5;
/// A quick run has this many reaches of each scene.
pub(super) const QUICK_REACHES: u64 = 2;

/// The patch that every model judges, and the one that is judged too if the model can and the arm has it.
pub(super) const FOREARM: &str = "forearm";
pub(super) const FLIPPER: &str = "flipper";
/// A taxel is in contact while it senses more than this, N.
pub(super) const THRESHOLD_N: f64 = 0.03;
/// A goal that is reached counts in the ranking of controllers if no link pressed on a trunk with more than this, N: the
/// limit f_max of reaches into foliage in A. Jain, M. D. Killpack, A. Edsinger, C. C. Kemp, "Reaching in clutter with
/// whole-arm tactile sensing", International Journal of Robotics Research 32(4), 2013.
pub(super) const GENTLE_N: f64 = 5.0;

macro_rules! texts {
    ($folder:literal: $($file:literal),* $(,)?) => {
        &[$(($file, include_str!(concat!("../../benchmarks/incidental-contact-", $folder, $file)))),*]
    };
}

/// The scenes of version 1, and those that version 2 added.
const SCENES: &[&[(&str, &str)]] = &[
    texts!["1/scenes/":
        "leaf.toml", "trunk.toml", "mixed.toml", "foam-roll.toml", "water-bottle.toml", "half-stiffness/mixed.toml",
        "double-stiffness/mixed.toml", "half-speed/mixed.toml", "double-speed/mixed.toml", "poor-sensor/mixed.toml",
        "other-arm/other-arm.toml",
    ],
    texts!["2/scenes/": "soft-roll.toml", "hard-roll.toml", "springy-branch.toml"],
];

const PANDA: &[(&str, &str)] = texts!["1/scenes/other-arm/panda/": "panda.toml", "panda.urdf", "panda.skin.toml"];

/// A frozen scene, by its path without the ending.
///
/// # Errors
/// Only when the frozen files are broken.
pub(super) fn scene(path: &str) -> Result<Scene, InputError> {
    let file = format!("{path}.toml");
    let Some((_, text)) = SCENES.iter().copied().flatten().find(|(own, _)| *own == file) else {
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
