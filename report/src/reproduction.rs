//! A whole study: runs an experiment, and writes its data, models, results and report.

use std::path::Path;

use underbrush_experiments::experiment::campaigns;
use underbrush_experiments::files::{write, write_json};
use underbrush_experiments::run_folder::Plan;
use underbrush_experiments::{Experiment, Progress, Results, Session, audit, online_models, training};
use underbrush_recording::Fault;
use underbrush_recording::disk::{remove_if_there, write_trials};

use crate::{Written, replayed};

/// How an experiment is run.
#[derive(Clone, Copy, Debug)]
pub struct Reproduction<'a> {
    /// What is run.
    pub experiment: &'a Experiment,
    /// Seed of the first campaign.
    pub seed: u64,
    /// Whether to run fewer reaches.
    pub quick: bool,
    /// Number of campaigns, of this seed and the next ones.
    pub campaigns: u64,
    /// Whether to remove what another run has left in the folder.
    pub force: bool,
}

impl Reproduction<'_> {
    /// Runs everything, writes it into a folder, and returns the results with the report. Finished stages are cached
    /// there.
    ///
    /// # Errors
    /// If the folder holds the results of another run, a stage fails, or a file cannot be written.
    pub fn run(&self, out: &Path, progress: &dyn Progress) -> Result<(Results, Written), Fault> {
        let _in_use = Plan::new(self.experiment, self.seed, self.quick).settle(out, self.force)?;
        let experiment = self.experiment();
        let session = Session::new(&experiment, (self.seed, self.quick, self.campaigns), out, progress);
        let data = session.once(training::run)?;
        let warnings = audit::warnings(data.dataset.episodes(), &data.dataset.plan().layout);
        warnings.iter().for_each(|warning| progress.remark(warning));
        write_trials(out.join("trials-component.parquet"), &data.trials.component)?;
        write_trials(out.join("trials-taxel.parquet"), &data.trials.taxel)?;
        let text = online_models::model(&session)?.save_string();
        write(&out.join("model.json"), text?.as_bytes())?;
        let results = Results::of(&session)?;
        write_json(&out.join("summary.json"), &results)?;
        let report = Written::of(&results)?;
        let folder = out.join("report");
        // An earlier run of several campaigns has left their tables.
        for entry in std::fs::read_dir(folder.join("csv")).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with("campaign") {
                remove_if_there(&entry.path())?;
            }
        }
        for (path, bytes) in &report.files {
            write(&folder.join(path), bytes)?;
        }
        replayed::write(&session, &folder)?;
        Ok((results, report))
    }

    /// Runs one of the further campaigns alone, and caches its result in the folder for [`Reproduction::run`]. Many
    /// processes may do this in one folder at a time.
    ///
    /// # Errors
    /// If the folder holds the results of another run, a stage fails, or a file cannot be written.
    pub fn run_campaign(&self, seed: u64, out: &Path, progress: &dyn Progress) -> Result<(), Fault> {
        let _in_use = Plan::new(self.experiment, self.seed, self.quick).settle(out, false)?;
        let experiment = self.experiment();
        let session = Session::new(&experiment, (self.seed, self.quick, self.campaigns), out, progress);
        campaigns::run_one(&session, seed)
    }

    /// The experiment of its size.
    fn experiment(&self) -> Experiment {
        let whole = self.experiment.clone();
        if self.quick { whole.made_small() } else { whole }
    }
}
