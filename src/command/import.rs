//! `underbrush import`: cuts contact trials from a file of a real robot.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use underbrush_exchange::import::{Mapping, import};
use underbrush_recording::disk::write_trials;

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::output;

/// Options of `underbrush import`.
#[derive(Args)]
pub struct Options {
    /// File to read: .csv or .mcap; .h5 or .hdf5 if the program was built with the feature `hdf5`
    file: PathBuf,
    /// Mapping (TOML): which numbers are the forces on which taxels, in which unit. docs/exchange.md describes it
    #[arg(long, value_name = "FILE")]
    mapping: PathBuf,
    /// Table of trials to write, `.csv` or `.parquet`, for train, classify, evaluate and score
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// What was written.
#[derive(Serialize)]
struct Written {
    #[serde(serialize_with = "output::path")]
    file: PathBuf,
    reaches: usize,
    frames: usize,
    trials: usize,
    samples: usize,
    /// Number of trials by category; the empty name is for trials without one.
    categories: BTreeMap<String, usize>,
}

/// Writes the table.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let inputs = [&options.file, &options.mapping];
    options.overwrite.table(&options.out, inputs)?;
    let imported = import(&options.file, &Mapping::load(&options.mapping)?)?;
    let mut written = Written {
        file: options.out.clone(),
        reaches: imported.reaches,
        frames: imported.frames,
        trials: imported.trials.len(),
        samples: imported.trials.iter().map(|trial| trial.samples.len()).sum(),
        categories: BTreeMap::new(),
    };
    for trial in &imported.trials {
        let category = trial.category.clone().unwrap_or_default();
        *written.categories.entry(category).or_default() += 1;
    }
    write_trials(&options.out, imported.trials)?;
    output::result(json, &written, || {
        let named = written.categories.iter().map(|(name, count)| match name.as_str() {
            "" => format!("{count} without a category"),
            name => format!("{count} {name}"),
        });
        format!(
            "{}, {} from {} of {}: {}\n{}",
            output::counted(written.trials, "trial", "trials"),
            output::counted(written.samples, "sample", "samples"),
            output::counted(written.frames, "frame", "frames"),
            output::counted(written.reaches, "reach", "reaches"),
            named.collect::<Vec<_>>().join(", "),
            written.file.display()
        )
    })
}
