//! Rules for an experiment file that the types of its keys do not express.

use std::collections::{BTreeMap, BTreeSet};

use underbrush_classifier::recipe::STATES;
use underbrush_classifier::{ModelError, Recipe, is_trained};
use underbrush_recording::{Category, InputError, PLAIN, is_plain};
use underbrush_sim::arm::Arm;
use underbrush_sim::scene::{RobotSection, Scene, limits};

use super::file::{AblationName, ClassifierEntry, ExperimentFile, Published, Setting, ThresholdSection};
use crate::files::Source;

/// Checks the rules that the types of the keys do not express.
pub fn check(file: &ExperimentFile, source: &Source) -> Result<(), InputError> {
    let reaches = |name: &str, count: Option<u64>, first: u64, why: &str| {
        let Some(count) = count.filter(|count| !(first..=1_000_000).contains(count)) else { return Ok(()) };
        Err(source.fault(name, &count.to_string(), format!("{first} to 1000000{why}")))
    };
    let labels: BTreeSet<&str> = file.training.iter().map(|own| own.label.as_str()).collect();
    let found = labels.first().copied().unwrap_or("no training scenes");
    source.check(labels.len() >= 2, "training.label", found, "training scenes with at least two different labels")?;
    for training in &file.training {
        let label = training.label.as_str();
        let is_reserved = ["", Category::UNCERTAIN].contains(&label) || !is_trained(label);
        let other =
            "a name other than `uncertain` and `outlier`, which are verdicts, and `block`, on which nothing is trained";
        if let Some(allowed) = is_reserved.then_some(other).or_else(|| Category::name_fault(label)) {
            return Err(source.fault("training.label", label, allowed));
        }
        let why = ": cross-validation needs a reach in each of two folds";
        reaches("training.reaches", Some(training.reaches), 2, why)?;
        reaches("training.quick_reaches", training.quick_reaches, 2, why)?;
        reaches("training.setting_reaches", training.setting_reaches, 2, why)?;
    }
    if let Some(own) = &file.verdicts {
        reaches("verdicts.reaches", Some(own.reaches), 1, "")?;
        reaches("verdicts.quick_reaches", own.quick_reaches, 1, "")?;
    }
    let tests = [("general", &file.general), ("outlier", &file.outlier), ("second_outlier", &file.second_outlier)];
    for (section, own) in tests.into_iter().filter_map(|(section, own)| Some((section, own.as_ref()?))) {
        let (first, why) = (own.reaches as u64, ": as many draws as `reaches` or more (8 if not given)");
        reaches(&format!("{section}.reaches"), Some(first), 1, "")?;
        reaches(&format!("{section}.max_draws"), Some(own.max_draws), first, why)?;
    }
    for own in &file.engineered {
        reaches("engineered.max_draws", Some(own.max_draws), 1, "")?;
    }
    if let Some(own) = file.chosen_on.iter().find(|own| own.first > own.last) {
        return Err(source.fault("chosen_on.first", &own.first.to_string(), format!("at most `last`, {}", own.last)));
    }
    if let Some(published) = &file.published {
        check_published(published, source)?;
    }
    reaches("controllers.reaches", file.controllers.as_ref().map(|own| own.reaches), 1, "")?;
    source.check(!file.truncations.contains(&0), "truncations", "0", "numbers from 1")?;
    check_limits(file, source)?;
    source.check(!file.states.is_empty(), "states", "[]", "at least one number of hidden states")?;
    source.check(!file.recipes.is_empty(), "recipes", "[]", "at least one of `authors`, `modern`")?;
    check_names(file, source)?;
    let (threshold_n, min_samples) = (file.trials.threshold_n, file.trials.min_samples);
    let (is_force, allowed) = (threshold_n > 0.0 && threshold_n < 100.0, "a force over 0 and under 100 N");
    source.check_number(is_force, "trials.threshold_n", threshold_n, allowed)?;
    let is_enough = min_samples >= file.states.iter().copied().max().unwrap_or(1);
    let allowed = "at least the largest of `states`: a model's start takes a sample for each state";
    source.check(is_enough, "trials.min_samples", &min_samples.to_string(), allowed)?;
    let unknown = file.engineered.iter().map(|own| own.label.as_str()).find(|label| !labels.contains(label));
    source.check(unknown.is_none(), "engineered.label", unknown.unwrap_or_default(), "a label of the training scenes")
}

/// The names of all experiments, as an array.
macro_rules! names {
    ($($name:ident: $result:ident,)*) => { [$(stringify!($name)),*] };
}

/// Checks the published numbers, and the names of sections.
fn check_published(published: &Published, source: &Source) -> Result<(), InputError> {
    let trials = published.trials.iter();
    let trials = trials.flat_map(|own| [("trials.trials", own.trials), ("trials.reaches", own.reaches)]);
    let samples = published.samples_used.map(|own| ("samples_used", own));
    let seconds = published.seconds_per_100_taxels.map(|own| ("seconds_per_100_taxels", own));
    for (name, value) in trials.chain(samples).chain(seconds) {
        let name = format!("published.{name}");
        source.check_number(value > 0.0 && value.is_finite(), &name, value, "a finite number over 0")?;
    }
    let percents = published.accuracy.iter().map(|own| ("published.accuracy.percent", own.percent));
    let best = published.best_accuracy_percent.map(|own| ("published.best_accuracy_percent", own));
    for (name, value) in percents.chain(best) {
        source.check_number((0.0..=100.0).contains(&value), name, value, "0 to 100 per cent")?;
    }
    let names = crate::for_each_experiment!(names);
    let unknown = published.sections.keys().find(|name| !names.contains(&name.as_str()));
    let Some(name) = unknown else { return Ok(()) };
    let field = source.field(&format!("published.sections.{name}"), "");
    Err(field.fault(name, format!("the name of a section: {}", names.join(", "))))
}

/// Checks that what names a row or a column of a table is fit for one, and in the file only once.
fn check_names(file: &ExperimentFile, source: &Source) -> Result<(), InputError> {
    let of_entries =
        |entries: &[ClassifierEntry]| -> Vec<String> { entries.iter().map(|entry| entry.name.clone()).collect() };
    let recipes = file.recipes.iter().map(|recipe| recipe.name().to_owned());
    let ablation = file.ablation.iter().map(|own| serde_json::json!(own).as_str().unwrap_or_default().to_owned());
    let training = file.training.iter().map(|own| own.scene.clone());
    let names: [(&str, Vec<String>); 9] = [
        ("title", vec![file.title.clone()]),
        // A scene that is named twice would have the same reaches in several folds.
        ("training.scene", training.collect()),
        ("truncations", file.truncations.iter().map(usize::to_string).collect()),
        ("ablation", ablation.collect()),
        ("states", file.states.iter().map(usize::to_string).collect()),
        ("recipes", recipes.collect()),
        ("classifiers.name", of_entries(&file.classifiers)),
        ("setting_classifiers.name", of_entries(&file.setting_classifiers)),
        ("settings.name", file.settings.iter().map(|setting| setting.name.clone()).collect()),
    ];
    for (field, names) in names {
        if let Some(name) = names.iter().find(|name| name.is_empty() || !is_plain(name)) {
            return Err(source.fault(field, &format!("{name:?}"), format!("{PLAIN}, not empty")));
        }
        let mut known = BTreeSet::new();
        if let Some(twice) = names.iter().find(|name| !known.insert(name.as_str())) {
            let allowed = "each only once: it names a result";
            return Err(source.field(field, twice).fault(format!("{twice} twice"), allowed));
        }
    }
    Ok(())
}

/// Checks that labels are categories of objects if verdicts are compared with objects, or trials are labelled by them.
pub fn check_labels(
    file: &ExperimentFile,
    scenes: &BTreeMap<String, Scene>,
    source: &Source,
) -> Result<(), InputError> {
    let is_tested = [&file.general, &file.outlier, &file.second_outlier].iter().any(|own| own.is_some());
    let online = !file.engineered.is_empty() || is_tested || file.verdicts.is_some();
    let by_objects = online || file.ablation.contains(&AblationName::LabelsByContact);
    let mut labels = file.training.iter().map(|own| own.label.as_str());
    let unknown = labels.find(|label| by_objects && category(scenes, label).is_none());
    let allowed = "the category of an object: verdicts and labels by contact follow what presses on each taxel";
    source.check(unknown.is_none(), "training.label", unknown.unwrap_or_default(), allowed)
}

/// Checks that the skin of every arm has the patch that the file names, or any if it names none.
pub fn check_patch<'a>(
    file: &ExperimentFile,
    arms: impl IntoIterator<Item = &'a Arm>,
    source: &Source,
) -> Result<(), InputError> {
    let patch = file.trials.patch.as_deref();
    let without = |arm: &&Arm| arm.skin.layout.chosen_patch(patch).is_none();
    let Some(arm) = arms.into_iter().find(without) else { return Ok(()) };
    let names: Vec<&str> = arm.skin.layout.patches.iter().map(|patch| patch.name.as_str()).collect();
    let has = if names.is_empty() { "none, so there is nothing to classify".into() } else { names.join(", ") };
    let allowed = format!("a patch of the skin of {}, which has {has}", arm.name);
    Err(source.fault("trials.patch", patch.unwrap_or("no patch"), allowed))
}

/// The category with this name: a built-in one, or the category of an object in the scenes.
pub fn category(scenes: &BTreeMap<String, Scene>, name: &str) -> Option<Category> {
    let groups = scenes.values().flat_map(|scene| scene.file.objects.groups());
    let mut own = groups.map(|(_, _, group)| group.category);
    Category::from_name(name).or_else(|| own.find(|category| category.name() == name))
}

/// Checks the numbers of states, the thresholds and the settings.
fn check_limits(file: &ExperimentFile, source: &Source) -> Result<(), InputError> {
    let fault = |name: &str, states: usize, allowed: String| Err(source.fault(name, &states.to_string(), allowed));
    if let Some(states) = file.states.iter().find(|states| !STATES.hold(**states as f64)) {
        return fault("states", *states, format!("numbers from {STATES}"));
    }
    let ThresholdSection { uncertain_below_nats: margin, false_positive_rate: rate, outlier_prior: prior } =
        file.thresholds;
    for (name, value, holds, allowed) in [
        ("thresholds.uncertain_below_nats", margin, margin.is_finite() && margin >= 0.0, "a finite number from 0"),
        ("thresholds.false_positive_rate", rate, rate > 0.0 && rate < 1.0, "a share over 0 and under 1"),
        ("thresholds.outlier_prior", prior, (0.0..0.5).contains(&prior), "a share from 0 and under 0.5"),
    ] {
        source.check_number(holds, name, value, allowed)?;
    }
    for setting in &file.settings {
        let allowed = "another name: this is that of the scenes' own setting";
        source.check(setting.name != Setting::NOMINAL, "settings.name", &setting.name, allowed)?;
        // The arm of a setting replaces a scene file's `[robot]`. All its keys are named here, so that no later one can
        // be forgotten.
        let RobotSection { stiffness_scale, hand_speed_scale, force_limit_scale } = setting.robot;
        for (name, value, range) in [
            ("settings.robot.stiffness_scale", stiffness_scale, limits::STIFFNESS_SCALE),
            ("settings.robot.hand_speed_scale", hand_speed_scale, limits::HAND_SPEED_SCALE),
            ("settings.robot.force_limit_scale", force_limit_scale, limits::FORCE_LIMIT_SCALE),
        ] {
            source.check_number(range.hold(value), name, value, &range.to_string())?;
        }
    }
    for (table, entries) in [("classifiers", &file.classifiers), ("setting_classifiers", &file.setting_classifiers)] {
        for (place, entry) in entries.iter().enumerate() {
            if let Some(states) = entry.states.filter(|states| !STATES.hold(*states as f64) || !entry.is_hmm()) {
                return fault(&format!("{table}.states"), states, format!("a number from {STATES}, for hmm alone"));
            }
            // Options are checked before trials, so none are needed here.
            if let Err(ModelError::BadOption(fault)) = entry.estimator(&Recipe::authors()).fit(&[]) {
                let field = source.field(&format!("{table}[{place}].{}", fault.field), "");
                return Err(field.fault(fault.found, fault.allowed));
            }
        }
    }
    let unused = file.settings.first().filter(|_| file.setting_classifiers.is_empty());
    let Some(setting) = unused else { return Ok(()) };
    let allowed =
        "settings with [[setting_classifiers]], which are trained and tested at each; without these, no settings";
    Err(source.fault("settings.name", &setting.name, allowed))
}
