//! Which data: scenes, how many reaches of each, and how trials are cut. Everything else of `reproduce` follows.

use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::trial::{Labels, TrialOptions};
use underbrush_recording::Category;
use underbrush_sim::controller::ControllerKind;
use underbrush_sim::scene::{RobotSection, SceneFile};

/// A scene as shipped in `scenes/`: its path for messages, and its text.
pub type SceneSource = (&'static str, &'static str);

macro_rules! scene {
    ($path:literal) => {
        ($path, include_str!(concat!("../../", $path)))
    };
}

/// One of the environments that models are trained in (paper, section IV-B).
pub struct Training {
    pub scene: SceneSource,
    /// What is to be learned there.
    pub category: Category,
    /// Reaches of a campaign of the paper's size, and of a quick one.
    pub reaches: u64,
    pub quick_reaches: u64,
    /// The paper's trials per reach by component and by taxel, sections IV-C (288 / 10 and 324 / 25) and IV-D (496 / 10
    /// and 582 / 25).
    pub paper_trials_per_reach: [(TableOneUnit, f64); 2],
}

pub const TRAINING: [Training; 2] = [
    Training {
        scene: scene!("scenes/leaf.toml"),
        category: Category::LEAF,
        reaches: 10,
        quick_reaches: 4,
        paper_trials_per_reach: [(TableOneUnit::Component, 28.8), (TableOneUnit::Taxel, 49.6)],
    },
    Training {
        scene: scene!("scenes/trunk.toml"),
        category: Category::TRUNK,
        reaches: 25,
        quick_reaches: 8,
        paper_trials_per_reach: [(TableOneUnit::Component, 12.96), (TableOneUnit::Taxel, 23.28)],
    },
];

/// The majority baseline of the paper's trials, per cent: the share of the more frequent category by its counts.
pub fn paper_majority_percent(unit: TableOneUnit) -> f64 {
    let count = |training: &Training| -> f64 {
        let own = training.paper_trials_per_reach.iter().filter(|(by, _)| *by == unit);
        own.map(|(_, per_reach)| per_reach * training.reaches as f64).sum()
    };
    let counts = TRAINING.each_ref().map(count);
    100.0 * counts[0].max(counts[1]) / (counts[0] + counts[1])
}

/// The ten engineered reaches (section V-B): one of each scene, in which the forearm touches this category alone.
pub const ENGINEERED: [(SceneSource, Category); 10] = [
    (scene!("scenes/engineered/leaf-clump.toml"), Category::LEAF),
    (scene!("scenes/engineered/leaf-right.toml"), Category::LEAF),
    (scene!("scenes/engineered/leaf-row.toml"), Category::LEAF),
    (scene!("scenes/engineered/leaf-stiff.toml"), Category::LEAF),
    (scene!("scenes/engineered/leaf-tall.toml"), Category::LEAF),
    (scene!("scenes/engineered/trunk-gate.toml"), Category::TRUNK),
    (scene!("scenes/engineered/trunk-post.toml"), Category::TRUNK),
    (scene!("scenes/engineered/trunk-right.toml"), Category::TRUNK),
    (scene!("scenes/engineered/trunk-row.toml"), Category::TRUNK),
    (scene!("scenes/engineered/trunk-thick.toml"), Category::TRUNK),
];
/// Reaches drawn of an engineered scene until one touches what it should; a choice: a handful is enough by far.
pub const ENGINEERED_DRAWS: u64 = 8;

/// General reaches through leaves and trunks (section V-B), in which the forearm touches both.
pub const MIXED: SceneSource = scene!("scenes/mixed.toml");
/// Reaches of it that are kept, for a full run and a quick one, and drawn at most.
pub const MIXED_REACHES: [usize; 2] = [3, 1];
pub const MIXED_DRAWS: u64 = 12;

/// Reaches that meet the foam roll first and then leaf or trunk (section V-D).
pub const OUTLIER: SceneSource = scene!("scenes/outlier.toml");
/// Reaches of it that are kept, for a full run and a quick one, and drawn at most.
pub const OUTLIER_REACHES: [usize; 2] = [4, 2];
pub const OUTLIER_DRAWS: u64 = 16;

/// The controller of all reaches; each scene's own if none.
pub const CONTROLLER: Option<ControllerKind> = None;

/// How trials are cut.
pub fn trial_options() -> TrialOptions {
    TrialOptions::paper()
}

/// The same with contacts of any length.
pub fn any_length_options() -> TrialOptions {
    TrialOptions {
        min_samples: 1,
        ..trial_options()
    }
}

/// The default seed. Choice: the first that nothing was chosen on. The README reports seeds from there on.
pub const DEFAULT_SEED: u64 = 100;

/// Seeds on which something was chosen so that trials per reach and Table I come near the paper's, and what.
pub const CHOSEN_ON: [(std::ops::RangeInclusive<u64>, &str); 2] = [
    (1000..=5005, "creep, strays and the contact threshold"),
    (0..=2, "patience and the number of goals"),
];

/// The margin under which a taxel is uncertain online, nats. Section V-B gives no number; this is section V-D's.
pub const UNCERTAIN_BELOW_NATS: f64 = 15.0;

/// Lengths to which Fig. 13 truncates trials, samples: the paper's four, and on.
pub const TRUNCATIONS: [usize; 7] = [200, 150, 100, 50, 25, 12, 6];

/// What thresholds chosen from training data are to hold: at most so many trials of the other category are taken for one,
/// and so many contacts are expected to be outliers. Choices: one in twenty, each.
pub const FALSE_POSITIVE_RATE: f64 = 0.05;
pub const OUTLIER_PRIOR: f64 = 0.05;

/// Share of taxel frames left uncertain above which the page says that a rule fails. Choice: such a rule decides on fewer
/// than one in ten.
pub const FAILING_UNCERTAIN_SHARE: f64 = 0.9;

/// The arm and the speed of the campaign's own reaches.
pub const NOMINAL: &str = "nominal";
/// Arm stiffness and hand speed at which else the training scenes are run, to train at one and test at the others: the
/// open question of the follow-up study (arXiv 1409.4972). Half and double by choice.
pub const SETTINGS: [(&str, RobotSection); 4] = [
    ("half stiffness", robot(0.5, 1.0)),
    ("double stiffness", robot(2.0, 1.0)),
    ("half speed", robot(1.0, 0.5)),
    ("double speed", robot(1.0, 2.0)),
];
/// Reaches of each training scene at a setting, for a full run and a quick one.
pub const SETTING_REACHES: [[u64; 2]; 2] = [[5, 12], [2, 4]];

const fn robot(stiffness_scale: f64, hand_speed_scale: f64) -> RobotSection {
    RobotSection {
        stiffness_scale,
        hand_speed_scale,
    }
}

/// One thing that is otherwise than in the campaign.
pub enum Change {
    /// How the same reaches are cut into trials.
    Cut(fn() -> TrialOptions),
    /// What is simulated.
    Scene(fn(&mut SceneFile)),
}

/// What each part of reality is worth: Table I with one of these changed at a time; name, what it is, and how.
pub const CHANGES: [(&str, &str, Change); 6] = [
    (
        "labels by contact",
        "a trial's category is what truly touches the taxel, not what stands in the scene",
        Change::Cut(|| TrialOptions {
            labels: Labels::Contact,
            ..trial_options()
        }),
    ),
    (
        "trials of any length",
        "also those of fewer samples than models have states",
        Change::Cut(any_length_options),
    ),
    (
        "no strays",
        "no taxel reads a force where nothing touches",
        Change::Scene(|scene| scene.sensor.spurious_share = 0.0),
    ),
    (
        "no creep",
        "a taxel reads nothing of a contact that has gone",
        Change::Scene(|scene| scene.sensor.creep_share_per_decade = 0.0),
    ),
    (
        "perfect sensor",
        "the sensed force is the true force",
        Change::Scene(|scene| scene.sensor.perfect = true),
    ),
    (
        "nobody watching",
        "the controller's own rule ends a goal, and each is tried once more",
        Change::Scene(|scene| {
            scene.goals.patience_s = None;
            scene.goals.retries = 1;
        }),
    ),
];
