//! Regression suites: scenes, a controller and a model, with bounds on the results of running them.
//!
//! A suite file ([`mod@file`]) says what to run and, for each scene, which metrics ([`metric`]) must stay within which
//! bounds. [`Suite::run`] runs it and checks every metric against its bounds; [`Checked::of`] can write bounds from what
//! was found, with a margin that `statistics` derives.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use underbrush_classifier::any_model::OnlineModel;
use underbrush_recording::{Category, Fault, InputError};
use underbrush_sim::{ReachPlan, Scene};

use crate::files::{self, Source};

mod check;
mod checked;
pub mod file;
pub mod metric;
pub mod result;
mod statistics;
#[cfg(test)]
mod tests;

pub use checked::Checked;
pub use file::Bound;

use file::{SceneEntry, SuiteFile};
use metric::Metric;

/// A suite with its checked file, its scenes and its model.
#[derive(Debug)]
pub struct Suite {
    /// Name: the file's stem.
    pub name: String,
    /// The keys of the file. The seed may be another one, see [`Suite::set_seed`].
    pub file: SuiteFile,
    /// The scenes.
    pub scenes: Vec<SuiteScene>,
    /// The model, if the suite names one.
    model: Option<OnlineModel>,
    /// The text of the file.
    text: String,
}

/// A scene of a suite.
#[derive(Debug)]
pub struct SuiteScene {
    /// The scene with arm, controller and seed.
    pub plan: ReachPlan,
    /// Its file, or the name of one that ships, by which commands find it.
    pub name_or_path: String,
    /// Number of reaches.
    pub reaches: u64,
    /// The bounds, in the order of the file.
    pub bounds: Vec<SceneBound>,
}

/// A bound on one metric.
#[derive(Debug)]
pub struct SceneBound {
    /// The metric.
    pub metric: &'static Metric,
    /// The category, for metrics that have one.
    pub category: Option<Category>,
    /// The bound.
    pub bound: Bound,
    /// Its range of bytes in the file.
    span: Range<usize>,
}

/// The JSON Schema of suite files.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(SuiteFile)
}

impl SceneBound {
    /// The key in the file, such as `peak_force_n.leaf`.
    pub fn name(&self) -> String {
        match self.category {
            Some(category) => format!("{}.{category:?}", self.metric.name),
            None => self.metric.name.to_owned(),
        }
    }
}

impl Suite {
    /// Reads and checks a suite file, its scenes and its model.
    ///
    /// # Errors
    /// When a file cannot be read, is not TOML, has unknown keys or a value that is not allowed.
    pub fn load(path: &Path) -> Result<Self, Fault> {
        Self::parse(path, files::read(path, "suite")?)
    }

    /// Reads and checks several files, before anything is run, so that a mistake in the last one costs no time.
    ///
    /// # Errors
    /// As [`Suite::load`], and if a file is given twice or two files have the same name.
    pub fn load_all(paths: &[PathBuf]) -> Result<Vec<(Self, &Path)>, Fault> {
        let mut suites: Vec<(Self, &Path)> = Vec::new();
        for path in paths.iter().map(PathBuf::as_path) {
            let suite = Self::load(path)?;
            if let Some((_, other)) = suites.iter().find(|(own, _)| own.name == suite.name) {
                let is_same = std::fs::canonicalize(other).ok() == std::fs::canonicalize(path).ok();
                let [other, path] = [*other, path].map(Path::display);
                return Err(Fault::Usage(if is_same {
                    format!("{path} is given twice; give each suite once")
                } else {
                    format!("{other} and {path} have the same name, by which results are told apart; rename one")
                }));
            }
            suites.push((suite, path));
        }
        Ok(suites)
    }

    /// Checks the text of a suite file, and reads its scenes and its model.
    fn parse(path: &Path, text: String) -> Result<Self, Fault> {
        let source = Source { path, text: &text };
        let file: SuiteFile = source.parse("suite")?;
        check::numbers(&file, &source)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let model = file.model.as_ref().map(|own| own.load(folder, &source)).transpose()?;
        let (mut scenes, mut names) = (Vec::new(), BTreeSet::new());
        for (place, entry) in file.scenes.iter().enumerate() {
            let scene = scene(&file, entry, folder, &source, model.as_ref())?;
            if !names.insert(scene.plan.scene.name.clone()) {
                let allowed = "scene files with different names, by which results are told apart";
                return Err(source.fault(&format!("scenes[{place}].scene"), &entry.scene, allowed).into());
            }
            scenes.push(scene);
        }
        Ok(Suite {
            name: path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
            file,
            scenes,
            model,
            text,
        })
    }

    /// Runs the reaches of another seed instead.
    pub fn set_seed(&mut self, seed: u64) {
        self.file.seed = seed;
        self.scenes.iter_mut().for_each(|scene| scene.plan.seed = seed);
    }
}

/// Reads a scene and its bounds.
fn scene(
    file: &SuiteFile,
    entry: &SceneEntry,
    folder: &Path,
    source: &Source,
    model: Option<&OnlineModel>,
) -> Result<SuiteScene, InputError> {
    let named = |error| source.field("scenes.scene", &entry.scene).named(error);
    let scene = Scene::open_in(folder, Path::new(&entry.scene)).map_err(named)?;
    let plan = ReachPlan::new(scene, file.controller, file.seed)?;
    if let Some(model) = model {
        model.begin(&plan.arm.skin.layout).map_err(|error| {
            let file = file.model.as_ref().map_or("", |own| own.file.as_str());
            let allowed = format!("a model, patch, threshold and rule that fit the skin of {}", entry.scene);
            source.field("model.file", file).fault(error.to_string(), allowed)
        })?;
    }
    let bounds = check::bounds(&entry.bounds, &plan.scene, model, source)?;
    if bounds.is_empty() {
        let allowed = "at least one bound under [scenes.bounds]; `{}` in place of a bound lets --bless choose it";
        return Err(source.field("scenes.scene", &entry.scene).fault("no bounds", allowed));
    }
    let path = folder.join(&entry.scene);
    let name_or_path = if path.is_file() { path.display().to_string() } else { entry.scene.clone() };
    Ok(SuiteScene { plan, name_or_path, reaches: entry.reaches, bounds })
}
