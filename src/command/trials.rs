//! `underbrush trials`: writes the contact trials of a data set as a table.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use underbrush_recording::disk::write_trials;

use crate::options::TrialArguments;
use crate::{Failure, Overwrite, input, output};

/// Options of `underbrush trials`.
#[derive(Args)]
pub struct TrialsOptions {
    /// Data set (folder), recording or folder of recordings; or a table, to be written in the other format or without short
    /// trials
    dataset: PathBuf,
    /// Table to write, `.csv` or `.parquet`, with one row per sample and the columns trial, category, reach, patch,
    /// taxel, time_s, force_n, motion_m, region_taxels, region_largest_force_n, region_force_sum_n, touched (ground
    /// truth: whether an object pressed on the taxel in this sample)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    cut: TrialArguments,
}

/// Writes the table.
pub fn run(options: TrialsOptions, json: bool) -> Result<(), Failure> {
    options.overwrite.ending(&options.out, &["csv", "parquet"], "choose such a name", [&options.dataset])?;
    let trials = input::some_trials(&options.dataset, &options.cut)?.trials;
    let never_touched = trials.iter().filter(|trial| trial.touched() == Some(false)).count();
    let touch_unknown = trials.iter().filter(|trial| trial.touched().is_none()).count();
    let (count, samples) = (trials.len(), trials.iter().map(|trial| trial.samples.len()).sum::<usize>());
    write_trials(&options.out, &trials)?;
    let file = options.out.display().to_string();
    // Trials during which no object pressed are among those for which this is known.
    let written = json!({
        "file": file, "trials": count, "samples": samples, "never_touched": never_touched, "touch_unknown": touch_unknown,
    });
    output::result(json, &written, || {
        let counts = [(count, "trial", "trials"), (samples, "sample", "samples")];
        let [trials, samples] = counts.map(|(count, one, many)| output::counted(count, one, many));
        let mut text = format!("{trials}, {samples} in {file}");
        if touch_unknown < count {
            let untouched = output::counted(never_touched, "of the trials was", "of the trials were");
            let causes = "the forces there come from the sensor alone (spurious readings, creep, crosstalk)";
            text += &format!("\n{untouched} never touched: {causes}");
        }
        text
    })
}
