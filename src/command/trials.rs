//! `underbrush trials`: the contact trials of a data set as a table.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use underbrush_recording::disk::write_trials;

use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// Options of `underbrush trials`.
#[derive(Args)]
pub struct Options {
    /// Data set (folder) or recording
    dataset: PathBuf,
    /// Table to write: `.csv` or `.parquet`, one row a sample, columns trial, category, reach, patch, taxel, time_s,
    /// force_n, motion_m, region_taxels, region_largest_force_n, region_force_sum_n
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    cut: TrialArguments,
}

#[derive(Serialize)]
struct Written {
    #[serde(serialize_with = "output::path")]
    file: PathBuf,
    trials: usize,
    samples: usize,
}

/// Writes the table.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let trials = input::some_trials(&options.dataset, &options.cut)?;
    let written = Written {
        file: options.out.clone(),
        trials: trials.len(),
        samples: trials.iter().map(|trial| trial.samples.len()).sum(),
    };
    write_trials(&options.out, trials)?;
    output::result(json, &written, || {
        format!(
            "{} trials, {} samples in {}",
            written.trials,
            written.samples,
            written.file.display()
        )
    })
}
