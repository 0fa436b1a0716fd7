//! `underbrush import`: cuts contact trials from a file of a real robot.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use underbrush_exchange::import::{Mapping, import};
use underbrush_recording::disk::{channel_names, write_trials_with};

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::output;

/// ImportOptions of `underbrush import`.
#[derive(Args)]
pub struct ImportOptions {
    /// CSV file to read
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

/// Writes the table.
pub fn run(options: ImportOptions, json: bool) -> Result<(), Failure> {
    let inputs = [&options.file, &options.mapping];
    options.overwrite.table(&options.out, inputs)?;
    let imported = import(&options.file, &Mapping::load(&options.mapping)?)?;
    if let Some(warning) = &imported.warning {
        output::remark(format!("warning: {warning}"));
    }
    let mut categories = BTreeMap::<String, usize>::new();
    for trial in &imported.trials {
        *categories.entry(trial.category.clone().unwrap_or_default()).or_default() += 1;
    }
    let (trials, frames, reaches) = (imported.trials.len(), imported.frames, imported.reaches);
    let samples: usize = imported.trials.iter().map(|trial| trial.samples.len()).sum();
    write_trials_with(&options.out, &channel_names(&imported.trials), imported.trials)?;
    let file = options.out.display().to_string();
    // The empty name is for trials without a category.
    let written = json!({
        "file": file, "reaches": reaches, "frames": frames, "trials": trials, "samples": samples, "categories": categories,
    });
    output::result(json, &written, || {
        let named = categories.iter().map(|(name, count)| match name.as_str() {
            "" => format!("{count} without a category"),
            name => format!("{count} {name}"),
        });
        format!(
            "{}, {} from {} of {}: {}\n{file}",
            output::counted(trials, "trial", "trials"),
            output::counted(samples, "sample", "samples"),
            output::counted(frames, "frame", "frames"),
            output::counted(reaches, "reach", "reaches"),
            named.collect::<Vec<_>>().join(", ")
        )
    })
}
