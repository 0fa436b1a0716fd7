//! Experiments as files: what to train and test on, and what to compare with. `file` defines the keys, and `check` the
//! rules that their types do not express.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use underbrush_classifier::trial::{Labels, TrialOptions};
use underbrush_classifier::{Recipe, TouchOptions};
use underbrush_recording::{Category, Fault, InputError, distinct};
use underbrush_sim::arm::Arm;
use underbrush_sim::scene::{Scene, shipped};

use crate::files::{self, Field, Source};

mod check;
mod file;

pub use underbrush_classifier::trial::Unit;

pub use file::{
    AblationName, ChosenOn, ClassifierEntry, ControllerSection, EngineeredScene, ExperimentFile, OrderingName,
    Published, PublishedAccuracy, PublishedSection, PublishedTrials, RecipeName, Setting, TestScene, ThresholdSection,
    TrainingScene, TrialSection, VerdictSection,
};

use check::{category, check, check_labels, check_patch};

/// An experiment with its checked file and its scenes.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Name: the file's stem.
    pub name: String,
    /// The content of the file.
    pub file: ExperimentFile,
    /// Scenes by the path or name that the file gives.
    pub scenes: BTreeMap<String, Scene>,
    /// The arm of all scenes, if the file names one.
    pub arm: Option<Arm>,
    /// Hash of everything that decides results: file, scenes, arms.
    pub hash: String,
}

/// The JSON Schema of experiment files.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(ExperimentFile)
}

impl Experiment {
    /// The experiment that ships: the paper's.
    ///
    /// # Errors
    /// Only if the shipped files are invalid.
    pub fn paper() -> Result<Self, InputError> {
        let text = include_str!("../../paper.toml");
        Self::parse(Path::new("paper.toml"), text, |name, field| {
            let text = name.strip_prefix("../scenes/").and_then(shipped);
            let text = text.ok_or_else(|| field.fault(name, "a scene that ships"))?;
            Scene::parse(name.trim_start_matches("../"), text.into())
        })
    }

    /// The experiment in a file, or else the paper's.
    ///
    /// # Errors
    /// As [`Experiment::load`].
    pub fn load_or_paper(path: Option<&Path>) -> Result<Self, InputError> {
        path.map_or_else(Self::paper, Self::load)
    }

    /// Reads and checks an experiment file, its scenes and its arm.
    ///
    /// # Errors
    /// When a file cannot be read, is not TOML, has unknown keys or a value that is not allowed.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        let text = files::read(path, "experiment")?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(path, &text, |name, field| {
            Scene::open_in(folder, Path::new(name)).map_err(|error| field.named(error))
        })
    }

    /// Checks the text of an experiment file; `scene` reads a scene that it names.
    fn parse(
        path: &Path,
        text: &str,
        scene: impl Fn(&str, &Field) -> Result<Scene, InputError>,
    ) -> Result<Self, InputError> {
        let source = Source { path, text };
        let file: ExperimentFile = source.parse("experiment")?;
        check(&file, &source)?;
        let mut scenes = BTreeMap::new();
        let names = scene_names(&file);
        for (name, field) in &names {
            if !scenes.contains_key(*name) {
                scenes.insert((*name).to_owned(), scene(name, &source.field(field, name))?);
            }
        }
        check_labels(&file, &scenes, &source)?;
        let mut stems = BTreeSet::new();
        if let Some((path, _)) = scenes.iter().find(|(_, scene)| !stems.insert(scene.name.clone())) {
            let allowed = "scene files with different names, by which results are told apart";
            let field = names.iter().find(|(name, _)| name == path).map_or("scene", |(_, field)| field);
            return Err(source.fault(field, path, allowed));
        }
        // The indices of test reaches begin at 0, as those of the training reaches do, and the clutter of a stream is the same.
        let is_trained =
            |path: &str| file.training.iter().any(|own| scenes[own.scene.as_str()].stream == scenes[path].stream);
        let tests = ["engineered.scene", "general.scene", "outlier.scene", "second_outlier.scene"];
        if let Some((path, field)) = names.iter().find(|(path, field)| tests.contains(field) && is_trained(path)) {
            let allowed = "other objects than those of training, or a `stream` of its own: its reaches are trained on";
            return Err(source.fault(field, path, allowed));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let load_arm =
            |arm: &String| Arm::load(folder.join(arm)).map_err(|error| source.field("arm", arm).named(error));
        let arm = file.arm.as_ref().map(load_arm).transpose()?;
        let named_arms = match &arm {
            Some(arm) => vec![arm.clone()],
            None => arms_of(&scenes)?,
        };
        let ships = |scene: &Scene| scene.arm_path().is_none();
        let needs_cody = file.trials.patch.is_some() && arm.is_none() && scenes.values().any(ships);
        let cody = needs_cody.then(Arm::cody).transpose()?;
        check_patch(&file, named_arms.iter().chain(&cody), &source)?;
        let mut hasher = blake3::Hasher::new();
        let texts = scenes.values().map(|scene| scene.text.as_str());
        let arm_texts = named_arms.iter().flat_map(|arm| arm.files.iter().map(|file| file.text.as_str()));
        for text in [text].into_iter().chain(texts).chain(arm_texts) {
            hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        }
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Experiment { name, file, scenes, arm, hash: hasher.finalize().to_hex().to_string() })
    }

    /// The same experiment, small, as quick runs have it. Its hash stays that of the whole experiment.
    pub fn made_small(mut self) -> Self {
        let file = &mut self.file;
        file.recipes.truncate(1);
        for own in &mut file.training {
            own.reaches = own.quick_reaches.unwrap_or(own.reaches.div_ceil(3).max(2).min(own.reaches));
        }
        file.engineered.iter_mut().for_each(|own| own.max_draws = 1);
        for own in [&mut file.general, &mut file.outlier].into_iter().flatten() {
            (own.reaches, own.max_draws) = (1, own.max_draws.min(2));
        }
        if let Some(own) = &mut file.verdicts {
            own.reaches = own.quick_reaches.unwrap_or(own.reaches.div_ceil(3));
            own.auxiliary.clear();
        }
        (file.second_outlier, file.controllers) = (None, None);
        file.settings.clear();
        file.ablation.clear();
        self
    }

    /// The scene that the file names by this path.
    ///
    /// # Errors
    /// If the file does not name it.
    pub fn scene(&self, name: &str) -> Result<&Scene, Fault> {
        self.scenes.get(name).ok_or_else(|| Fault::Usage(format!("{name}: the experiment has no such scene")))
    }

    /// The category with the name `label`, if it is the category of an object.
    pub fn category(&self, label: &str) -> Option<Category> {
        category(&self.scenes, label)
    }

    /// The first recipe, which is used wherever there is only one.
    pub fn main_recipe(&self) -> Recipe {
        self.main_recipe_name().recipe()
    }

    /// The name of the first recipe.
    pub fn main_recipe_name(&self) -> RecipeName {
        self.file.recipes.first().copied().unwrap_or(RecipeName::Authors)
    }

    /// The options for extracting trials: labelled by their scene, with at least the file's number of samples.
    pub fn trial_options(&self) -> TrialOptions {
        TrialOptions {
            patch: self.file.trials.patch.clone(),
            threshold_n: self.file.trials.threshold_n,
            min_samples: self.file.trials.min_samples,
            labels: Labels::Environment,
            ..TrialOptions::default()
        }
    }

    /// The options for verdicts on each taxel: patch and threshold as for trials.
    pub fn touch_options(&self) -> TouchOptions {
        TouchOptions::of(self.file.trials.patch.clone(), Some(self.file.trials.threshold_n))
    }

    /// Labels of the training scenes, in their order.
    pub fn labels(&self) -> Vec<&str> {
        distinct(self.file.training.iter().map(|training| training.label.as_str()))
    }

    /// The published figures, if the file gives any.
    pub fn published(&self) -> Option<&Published> {
        self.file.published.as_ref()
    }
}

/// Scenes that the file names, each with its field.
fn scene_names(file: &ExperimentFile) -> Vec<(&str, &'static str)> {
    let training = file.training.iter().map(|own| (own.scene.as_str(), "training.scene"));
    let engineered = file.engineered.iter().map(|own| (own.scene.as_str(), "engineered.scene"));
    let general = file.general.iter().map(|own| (own.scene.as_str(), "general.scene"));
    let outlier = file.outlier.iter().map(|own| (own.scene.as_str(), "outlier.scene"));
    let second_outlier = file.second_outlier.iter().map(|own| (own.scene.as_str(), "second_outlier.scene"));
    let verdicts = file.verdicts.iter().map(|own| (own.scene.as_str(), "verdicts.scene"));
    let auxiliary = file.verdicts.iter().flat_map(|own| &own.auxiliary);
    let auxiliary = auxiliary.map(|scene| (scene.as_str(), "verdicts.auxiliary"));
    let tests = engineered.chain(general).chain(outlier).chain(second_outlier);
    let controllers = file.controllers.iter().map(|own| (own.scene.as_str(), "controllers.scene"));
    training.chain(tests).chain(verdicts).chain(auxiliary).chain(controllers).collect()
}

/// The arms that scenes name by file, each once.
fn arms_of(scenes: &BTreeMap<String, Scene>) -> Result<Vec<Arm>, InputError> {
    let by_path: BTreeMap<PathBuf, &Scene> =
        scenes.values().filter_map(|scene| Some((scene.arm_path()?, scene))).collect();
    by_path.into_values().map(Scene::load_arm).collect()
}
