//! `underbrush import`: cuts contact trials from a file of a real robot.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;
use underbrush_classifier::frequencies;
use underbrush_exchange::import::{Mapping, import};
use underbrush_recording::Recording;
use underbrush_recording::disk::{
    DiskError, UnfinishedFolder, check_free, is_recording, write_recording, write_trials,
};

use crate::{Failure, Overwrite, output};

/// Options of `underbrush import`.
#[derive(Args)]
pub struct ImportOptions {
    /// CSV file to read
    file: PathBuf,
    /// Mapping (TOML): which columns hold the times and the forces, and in which unit. docs/exchange.md describes it
    #[arg(long, value_name = "FILE")]
    mapping: PathBuf,
    /// Table of trials to write, `.csv` or `.parquet`, for train, classify, evaluate and score. Or, if the mapping says where
    /// the taxels are, a folder for recordings of the reaches, for train --classifier touch and for replay
    #[arg(long, value_name = "FILE or FOLDER")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Writes the table.
pub fn run(options: ImportOptions, json: bool) -> Result<(), Failure> {
    let mapping = Mapping::load(&options.mapping)?;
    let taxels = mapping.taxels_file();
    let inputs = [&options.file, &options.mapping].into_iter().chain(&taxels);
    let is_table = options.out.extension().is_some();
    if is_table {
        options.overwrite.ending(&options.out, &["csv", "parquet"], "choose such a name", inputs)?;
    } else {
        check_free(&options.out, options.overwrite.force)?;
        require_recordings(&options.out)?;
        output::create_parents(&options.out)?;
    }
    let imported = import(&options.file, &mapping, !is_table)?;
    for warning in &imported.warnings {
        output::remark(format!("warning: {warning}"));
    }
    let categories = frequencies(imported.trials.iter().map(|trial| trial.category.clone().unwrap_or_default()));
    let (trials, frames, reaches) = (imported.trials.len(), imported.frames, imported.reaches);
    let samples: usize = imported.trials.iter().map(|trial| trial.samples.len()).sum();
    if is_table {
        write_trials(&options.out, &imported.trials)?;
    } else {
        write_recordings(&options.out, &imported.recordings)?;
    }
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
        let trials = output::counted(trials, "trial", "trials");
        let samples = output::counted(samples, "sample", "samples");
        let frames = output::counted(frames, "frame", "frames");
        let reaches = output::counted(reaches, "reach", "reaches");
        let named = named.collect::<Vec<_>>().join(", ");
        let sign = if named.is_empty() { "" } else { ": " };
        format!("{trials}, {samples} from {frames} of {reaches}{sign}{named}\n{file}")
    })
}

/// Demands that a folder, if it is there, holds nothing but recordings of an earlier import, which may be overwritten.
fn require_recordings(folder: &Path) -> Result<(), Failure> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.starts_with("reach-") || !is_recording(&entry.path())? {
            let text = format!("holds {name}, which is no recording of an import; choose another name");
            return Err(Failure::usage(text).about(folder));
        }
    }
    Ok(())
}

/// Writes a folder of recordings. It gets its name only when all of them are written.
fn write_recordings(folder: &Path, recordings: &[Recording]) -> Result<(), Failure> {
    // The folder itself, if the path is a link or leads through it, as `..` does within it.
    let folder = &std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let beside = folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let temporary = UnfinishedFolder::within(beside).map_err(DiskError::io(folder, "write"))?;
    // The temporary folder is for its owner alone, but not what is in it.
    let written = temporary.path().join("recordings");
    std::fs::create_dir(&written).map_err(DiskError::io(folder, "write"))?;
    for recording in recordings {
        write_recording(&written.join(format!("reach-{:06}.parquet", recording.reach_index)), recording)?;
    }
    if folder.is_dir() {
        // It is removed with the temporary folder, so that none is left that has lost some of its recordings.
        std::fs::rename(folder, temporary.path().join("before")).map_err(DiskError::io(folder, "write"))?;
    }
    Ok(std::fs::rename(&written, folder).map_err(DiskError::io(folder, "write"))?)
}
