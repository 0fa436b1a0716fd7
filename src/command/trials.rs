//! `underbrush trials`: writes the contact trials of a data set as a table.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use underbrush_recording::disk::write_trials;

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::input::{self, TrialArguments};
use crate::output;

/// Options of `underbrush trials`.
#[derive(Args)]
pub struct Options {
    /// Data set (folder) or recording
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

#[derive(Serialize)]
struct Written {
    #[serde(serialize_with = "output::path")]
    file: PathBuf,
    trials: usize,
    samples: usize,
    /// Trials during which no object pressed, among those for which this is known.
    never_touched: usize,
    /// Trials for which it is unknown whether an object pressed.
    touch_unknown: usize,
}

/// Writes the table.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    options.overwrite.table(&options.out, [&options.dataset])?;
    let trials = input::some_trials(&options.dataset, &options.cut)?;
    let written = Written {
        file: options.out.clone(),
        trials: trials.len(),
        samples: trials.iter().map(|trial| trial.samples.len()).sum(),
        never_touched: trials.iter().filter(|trial| trial.touched() == Some(false)).count(),
        touch_unknown: trials.iter().filter(|trial| trial.touched().is_none()).count(),
    };
    write_trials(&options.out, trials)?;
    output::result(json, &written, || {
        let mut text = format!(
            "{}, {} in {}",
            output::counted(written.trials, "trial", "trials"),
            output::counted(written.samples, "sample", "samples"),
            written.file.display()
        );
        if written.touch_unknown < written.trials {
            text += &format!(
                "\n{} never touched: the forces there come from the sensor alone (spurious readings, creep, crosstalk)",
                output::counted(written.never_touched, "of the trials was", "of the trials were")
            );
        }
        text
    })
}
