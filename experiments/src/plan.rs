//! What a folder of results was made from: only the same plan goes on there.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use underbrush_recording::disk::FileText;

use crate::data;
use crate::dataset::PROGRAM_VERSION;
use crate::error::ExperimentError;
use crate::files;

/// Everything that decides the reaches of a run. The arm is Cody in every scene, and its files are among the sources
/// that the version has a hash of.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version, with a hash of the sources that decide data.
    pub program: String,
    pub seed: u64,
    pub quick: bool,
    /// BLAKE3 of each scene's text.
    scenes: BTreeMap<String, String>,
}

const FILE: &str = "plan.json";
/// Folders and files that `reproduce` makes; nothing else in its folder is ever removed.
const FOLDERS: [&str; 4] = ["dataset", "reaches", "campaigns", "report"];
const FILES: [&str; 5] = [
    FILE,
    "summary.json",
    "model.json",
    "trials-component.parquet",
    "trials-taxel.parquet",
];

impl Plan {
    pub fn new(seed: u64, quick: bool) -> Self {
        let training = data::TRAINING.iter().map(|training| training.scene);
        let engineered = data::ENGINEERED.iter().map(|(scene, _)| *scene);
        let scenes = training.chain(engineered).chain([data::MIXED, data::OUTLIER]);
        Plan {
            program: PROGRAM_VERSION.into(),
            seed,
            quick,
            scenes: scenes
                .map(|(path, text)| (path.to_owned(), FileText::new(path, text).blake3))
                .collect(),
        }
    }

    /// Takes up a folder that this plan was begun in, or begins it; `fresh` throws away what another left there.
    pub fn settle(&self, out: &Path, fresh: bool) -> Result<(), ExperimentError> {
        let path = out.join(FILE);
        let known = FOLDERS.iter().chain(&FILES).any(|name| out.join(name).exists());
        let found = match std::fs::read(&path) {
            Ok(bytes) => serde_json::from_slice::<Plan>(&bytes).map_err(|error| error.to_string()),
            Err(error) => Err(error.to_string()),
        };
        if fresh {
            clear(out)?;
        } else if known {
            let difference = match &found {
                Ok(stored) => self.difference(stored),
                Err(error) => Some(format!("{FILE} cannot be read: {error}")),
            };
            if let Some(difference) = difference {
                return Err(ExperimentError::OtherRun {
                    folder: out.into(),
                    difference,
                });
            }
            return Ok(());
        }
        files::write_json(&path, self)
    }

    /// The first thing in which a stored plan differs.
    fn difference(&self, stored: &Plan) -> Option<String> {
        let differs = |what: &str, was: &dyn std::fmt::Display, now: &dyn std::fmt::Display| {
            (was.to_string() != now.to_string()).then(|| format!("{what} was {was}, now {now}"))
        };
        differs("seed", &stored.seed, &self.seed)
            .or_else(|| differs("quick", &stored.quick, &self.quick))
            .or_else(|| differs("program", &stored.program, &self.program))
            .or_else(|| (stored.scenes != self.scenes).then(|| "its scenes have changed".into()))
    }
}

fn clear(out: &Path) -> Result<(), ExperimentError> {
    let remove = |path: &Path| match path {
        _ if !path.exists() => Ok(()),
        _ if path.is_dir() => std::fs::remove_dir_all(path),
        _ => std::fs::remove_file(path),
    };
    for name in FOLDERS.iter().chain(&FILES) {
        let path = out.join(name);
        remove(&path).map_err(|source| ExperimentError::Io {
            path,
            action: "removed",
            source,
        })?;
    }
    Ok(())
}
