//! The folder of a run, which holds the results of one plan: experiment, seed and size. Finished results are cached there.
//! Each is stored with a checksum and with its origin. A result that does not match is computed again.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use underbrush_recording::disk::{is_there, remove_if_there};
use underbrush_recording::{DiskError, Fault};

use crate::dataset::PROGRAM_VERSION;
use crate::{Experiment, Progress, files};

/// Everything that decides the reaches of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version, with a hash of the sources that decide data.
    pub program: String,
    /// The seed.
    pub seed: u64,
    /// Whether it is a quick run.
    pub quick: bool,
    /// Name of the experiment.
    pub experiment: String,
    /// Hash of the experiment with its scenes and arms.
    hash: String,
}

const FILE: &str = "plan.json";
/// Folders and files that a run creates. Nothing else in its folder is ever removed.
const FOLDERS: [&str; 4] = ["dataset", "reaches", "campaigns", "report"];
const FILES: [&str; 5] = [
    "summary.json",
    "model.json",
    "trials-component.parquet",
    "trials-taxel.parquet",
    // The last, so that a folder that was cleared in part is still known to be that of a run.
    FILE,
];

impl Plan {
    /// The plan of an experiment.
    pub fn new(experiment: &Experiment, seed: u64, quick: bool) -> Self {
        Plan {
            program: PROGRAM_VERSION.into(),
            seed,
            quick,
            experiment: experiment.name.clone(),
            hash: experiment.hash.clone(),
        }
    }

    /// Prepares a folder for this plan, or checks that it holds results of the same plan. `force` removes what another
    /// run left there. Without a plan that shows that there was one, nothing is removed: the files may be anybody's. As long as
    /// the file that is returned is open, nobody else removes the results.
    ///
    /// # Errors
    /// When the folder holds the results of another plan, or files under the names of results but no plan, or cannot be
    /// written; with `force`, also when another process is at work in it.
    pub fn settle(&self, out: &Path, force: bool) -> Result<File, Fault> {
        let place = out.display();
        let found = FOLDERS.iter().chain(&FILES).map(|name| is_there(&out.join(name)));
        if found.collect::<Result<Vec<_>, _>>()?.contains(&true) {
            let stored = Plan::stored(out)?;
            if !force {
                return match self.difference(&stored) {
                    None => in_use(out),
                    Some(difference) => Err(Fault::Usage(format!(
                        "{place}: holds the results of another run: {difference}; choose another folder with --out, or \
                         replace them with --force"
                    ))),
                };
            }
            if in_use(out)?.try_lock().is_err() {
                return Err(Fault::Usage(format!(
                    "{place}: another process is at work in this folder; wait for it, or choose another folder with --out"
                )));
            }
            FOLDERS.iter().chain(&FILES).try_for_each(|name| remove_if_there(&out.join(name)))?;
        }
        files::write_json(&out.join(FILE), self)?;
        in_use(out)
    }

    /// The plan of the run whose results a folder holds.
    fn stored(out: &Path) -> Result<Self, Fault> {
        let path = out.join(FILE);
        let no_plan = |found: String| {
            Fault::Usage(format!(
                "{}: holds files under the names of results, but {found}, so they may not come from reproduce, which leaves \
                 them alone; choose another folder with --out",
                out.display()
            ))
        };
        match std::fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|error| no_plan(format!("a {FILE} that is not the plan of a run ({error})"))),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(no_plan(format!("no {FILE}"))),
            Err(error) => Err(DiskError::io(&path, "read")(error).into()),
        }
    }

    /// The first difference from a stored plan.
    fn difference(&self, stored: &Plan) -> Option<String> {
        let differs = |what: &str, was: &dyn std::fmt::Display, now: &dyn std::fmt::Display| {
            (was.to_string() != now.to_string()).then(|| format!("{what} was {was}, now {now}"))
        };
        differs("seed", &stored.seed, &self.seed)
            .or_else(|| differs("quick", &stored.quick, &self.quick))
            .or_else(|| differs("experiment", &stored.experiment, &self.experiment))
            .or_else(|| differs("program", &stored.program, &self.program))
            .or_else(|| (stored.hash != self.hash).then(|| "the experiment's file, scenes or arms have changed".into()))
    }
}

/// The file of the plan, which tells others that the folder is in use. Where the file system has no locks, it tells nothing.
fn in_use(out: &Path) -> Result<File, Fault> {
    let path = out.join(FILE);
    let file = File::open(&path).map_err(DiskError::io(&path, "read"))?;
    let _ = file.try_lock_shared();
    Ok(file)
}

/// Hash of the sources that decide results: this crate and the classifier.
pub const ANALYSIS_VERSION: &str = env!("UNDERBRUSH_ANALYSIS_SOURCES");

/// A cached result, with a hash of it and of its origin. A file that was edited or damaged is not used.
#[derive(Serialize, Deserialize)]
struct Kept {
    blake3: String,
    made_by: MadeBy,
    result: Value,
}

/// Everything that a result depends on.
#[derive(PartialEq, Serialize, Deserialize)]
struct MadeBy {
    /// The name of the file, so that one result is never taken for another.
    name: String,
    /// Hash of the sources that decide trials, models and figures.
    analysis: String,
    #[serde(flatten)]
    plan: Plan,
}

impl Kept {
    /// BLAKE3 of origin and result as compact JSON with sorted keys.
    fn hash(&self) -> String {
        blake3::hash(json!([self.made_by, self.result]).to_string().as_bytes()).to_hex().to_string()
    }

    /// The result in a file, if it has this origin. A damaged file counts as missing, with a warning.
    fn read<T: DeserializeOwned>(path: &Path, made_by: &MadeBy, progress: &dyn Progress) -> Option<T> {
        let bytes = std::fs::read(path).ok()?;
        let kept = serde_json::from_slice::<Kept>(&bytes).ok().filter(|kept| kept.hash() == kept.blake3);
        if kept.is_none() {
            let path = path.display();
            progress.remark(&format!("{path}: does not match its checksum, so it is computed again"));
        }
        kept.filter(|kept| kept.made_by == *made_by).and_then(|kept| serde_json::from_value(kept.result).ok())
    }
}

/// The result in a file, if it was made by this build for this plan and is undamaged; or else a new one, which is then
/// cached there.
pub fn result<T: Serialize + DeserializeOwned>(
    path: &Path,
    plan: Plan,
    progress: &dyn Progress,
    make: impl FnOnce() -> Result<T, Fault>,
) -> Result<T, Fault> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into();
    let made_by = MadeBy { name, analysis: ANALYSIS_VERSION.into(), plan };
    if let Some(result) = Kept::read(path, &made_by, progress) {
        return Ok(result);
    }
    let made = make()?;
    let result = serde_json::to_value(&made).map_err(files::unwritable(path))?;
    let mut kept = Kept { blake3: String::new(), made_by, result };
    kept.blake3 = kept.hash();
    files::write_json(path, &kept)?;
    Ok(made)
}

#[cfg(test)]
mod tests;
