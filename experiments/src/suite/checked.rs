//! Running several suites.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;
use underbrush_recording::{Fault, disk};

use super::result::SuiteResult;
use super::{Suite, bless};
use crate::progress::Progress;
use crate::source;

/// The results of some suites.
#[derive(Debug, Serialize)]
pub struct Checked {
    /// Whether all bounds hold.
    pub passed: bool,
    /// One for each suite.
    pub suites: Vec<SuiteResult>,
}

impl Checked {
    /// Runs the suites in these files, with `seed` instead of each file's seed if it is given. With `bless`, bounds
    /// computed from the results are written into the files, and the results are checked against them.
    ///
    /// # Errors
    /// As [`Suite::load`] and [`Suite::run`]; if two files have the same name; with `bless` also if a bound is not written
    /// in braces, a metric cannot be bounded, or a file cannot be written.
    pub fn of(paths: &[PathBuf], seed: Option<u64>, bless: bool, progress: &dyn Progress) -> Result<Self, Fault> {
        // All files are read before anything is run, so that a mistake in the last one costs no time.
        let mut suites = paths.iter().map(|path| Suite::load(path)).collect::<Result<Vec<_>, _>>()?;
        let mut names = BTreeMap::new();
        for (suite, path) in suites.iter().zip(paths) {
            if let Some(other) = names.insert(&suite.name, path) {
                let [other, path] = [other, path].map(|path| path.display());
                let text =
                    format!("{other} and {path} have the same name, by which results are told apart; rename one");
                return Err(Fault::Usage(text));
            }
        }
        if bless {
            for (suite, path) in suites.iter().zip(paths) {
                bless::check_places(suite, path)?;
            }
        }
        if let Some(seed) = seed {
            suites.iter_mut().for_each(|suite| suite.set_seed(seed));
        }
        let (mut results, mut texts) = (Vec::new(), Vec::new());
        for (suite, path) in suites.iter().zip(paths) {
            let mut result = suite.run(progress)?;
            if bless {
                texts.push((suite, path.as_path(), blessed(suite, &mut result, path, progress)?));
            }
            results.push(result);
        }
        write(&texts)?;
        Ok(Checked { passed: results.iter().all(|result| result.passed), suites: results })
    }

    /// Number of bounds that do not hold.
    pub fn broken(&self) -> usize {
        self.suites.iter().map(|result| result.broken().count()).sum()
    }
}

/// The text of the file with new bounds, against which the result is checked. A file is never replaced by one that cannot
/// be read.
pub(super) fn blessed(
    suite: &Suite,
    result: &mut SuiteResult,
    path: &Path,
    progress: &dyn Progress,
) -> Result<String, Fault> {
    let text = bless::text(suite, result)?;
    let new = Suite::parse(path, text.clone()).map_err(|error| {
        Fault::Usage(format!(
            "the file would not be a suite with the new bounds, so nothing was written ({error}). Write each bound in \
             braces, on one line"
        ))
    })?;
    *result = new.hold(result.clone());
    for scene in &result.scenes {
        for bound in scene.bounds.iter().filter(|bound| bound.allows_everything()) {
            progress.remark(&format!(
                "warning: {}: {} differs so much between reaches that its bound allows everything; run more reaches, let the \
                 scene vary less, or remove it",
                scene.scene, bound.name
            ));
        }
    }
    Ok(text)
}

/// Writes the texts with new bounds, if no file has changed since its suite was read.
pub(super) fn write(texts: &[(&Suite, &Path, String)]) -> Result<(), Fault> {
    for (suite, path, _) in texts {
        if source::read(path, "suite")? != suite.text {
            let path = path.display();
            let text = "changed while the suites ran, so nothing was written; run the command again";
            return Err(Fault::Run(format!("{path}: the file {text}")));
        }
    }
    for (_, path, text) in texts {
        disk::write_file(path, text.as_bytes())?;
    }
    Ok(())
}
