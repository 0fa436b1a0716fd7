//! Data sets of scenes, made for one training and then thrown away.

use std::path::{Path, PathBuf};

use clap::Args;
use underbrush_experiments::dataset::{Campaign, REACHES};
use underbrush_recording::disk::UnfinishedFolder;
use underbrush_sim::scene::{Scene, shipped_by_name};

use crate::{Failure, Shown, input, options};

/// Options on scenes that are given in place of data sets.
#[derive(Args)]
pub struct SimulatedArguments {
    /// With --classifier touch and scenes in place of data sets: simulate this many reaches of each scene
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(REACHES))]
    reaches: Option<u64>,
    /// Seed of these reaches, as for `underbrush generate`
    #[arg(long, default_value_t = 0, value_name = "N", requires = "reaches")]
    seed: u64,
}

impl SimulatedArguments {
    /// Refuses these options, for a reason.
    pub fn refuse(&self, reason: &str) -> Result<(), Failure> {
        options::refuse(self.reaches.map(|_| "--reaches".to_owned()), reason)
    }

    /// The paths with one data set, which is made in the folder, in place of all scenes.
    pub(super) fn sets(&self, paths: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>, Failure> {
        let (scenes, mut sets): (Vec<PathBuf>, Vec<PathBuf>) = paths.iter().cloned().partition(|path| is_scene(path));
        if let Some(scene) = scenes.first() {
            let reaches = self.reaches.ok_or_else(|| {
                let text = "is a scene; say with --reaches how many of its reaches to simulate and train on";
                Failure::usage(format!("{} {text}", scene.display()))
            })?;
            let scenes: Result<Vec<Scene>, _> = scenes.iter().map(Scene::open).collect();
            Campaign::new(scenes?, reaches, self.seed)?.write(folder, false, &Shown)?;
            sets.push(folder.to_owned());
        }
        Ok(sets)
    }

    /// A folder for the sets beside the model file; `None` if no path is a scene. A wrong name is refused here, before any
    /// scene is simulated.
    pub(super) fn folder(&self, paths: &[PathBuf], out: &Path) -> Result<Option<UnfinishedFolder>, Failure> {
        let allowed = "data sets (folders), recordings (.parquet) or, with --reaches, scenes";
        paths.iter().filter(|path| !is_scene(path)).try_for_each(|path| input::check_exists(path, allowed))?;
        if !paths.iter().any(|path| is_scene(path)) {
            self.refuse("applies to scenes in place of data sets")?;
            return Ok(None);
        }
        let beside = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = UnfinishedFolder::within(beside);
        let cannot = |error| Failure::run(format!("{}: no folder can be made in it: {error}", beside.display()));
        folder.map(Some).map_err(cannot)
    }
}

/// Whether this is a scene file or the name of a scene that ships. A data set of that name comes first.
fn is_scene(path: &Path) -> bool {
    let ships = || shipped_by_name().any(|(name, _)| path == Path::new(name));
    path.extension().is_some_and(|ending| ending == "toml") || (!path.exists() && ships())
}
