//! `underbrush export`: writes reaches for other tools.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;
use underbrush_classifier::evaluate::touch_folds::ReadReaches;
use underbrush_exchange::write_mcap;
use underbrush_recording::disk::{check_free, check_not_input};

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::output;
use crate::reaches::Reaches;

/// ExportOptions of `underbrush export`.
#[derive(Args)]
pub struct ExportOptions {
    /// Data sets (folders) or recordings (.parquet)
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// Format to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// File to write. For MCAP and several reaches: the folder, with one file reach-000000.mcap, … for each
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// The formats.
#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// For Foxglove and tools of ROS 2: joint states, transforms, scene and skin; one file per reach
    Mcap,
    /// In the shape of robomimic's data sets. The Python package writes it: python -m underbrush.hdf5 export
    Hdf5,
}

/// What was written.
#[derive(Serialize)]
struct Written {
    #[serde(serialize_with = "output::path")]
    out: PathBuf,
    reaches: usize,
    frames: usize,
    files: usize,
    bytes: u64,
}

/// An error about the folder for several files.
fn failed(folder: &Path, action: &str) -> impl Fn(std::io::Error) -> Failure {
    move |error| {
        let folder = folder.display();
        Failure::run(format!("{folder}: cannot {action}: {error}; check the path and its permissions"))
    }
}

/// Name of the file of a reach in the folder for several files.
fn name_of(reach: usize) -> String {
    format!("reach-{reach:06}.mcap")
}

/// Whether a file with this name is that of a reach.
fn is_of_export(name: &str) -> bool {
    let number = name.strip_prefix("reach-").and_then(|rest| rest.strip_suffix(".mcap"));
    number.is_some_and(|number| number.parse::<usize>().is_ok())
}

/// Makes room in the folder for the files of the reaches: without `--force` there must be none of another export, and
/// with it they are removed, because those of more reaches would be mixed with the new ones.
fn make_room(folder: &Path, overwrite: Overwrite) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(failed(folder, "create"))?;
    for entry in std::fs::read_dir(folder).map_err(failed(folder, "read"))? {
        let path = entry.map_err(failed(folder, "read"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if is_of_export(&name) {
            check_free(&path, overwrite.force)?;
            std::fs::remove_file(&path).map_err(failed(&path, "remove"))?;
        }
    }
    Ok(())
}

/// Writes the files.
pub fn run(options: ExportOptions, json: bool) -> Result<(), Failure> {
    if let Format::Hdf5 = options.to {
        let remedy = "write it with `python -m underbrush.hdf5 export DATA --out FILE`, or export MCAP";
        return Err(Failure::usage(format!("HDF5 is written by the Python package only; {remedy}")));
    }
    let overwrite = options.overwrite;
    check_not_input(&options.out, &options.data)?;
    let reaches = Reaches::open(&options.data)?;
    let out = options.out.as_path();
    let mut written = Written { out: out.to_path_buf(), reaches: 0, frames: 0, files: 0, bytes: 0 };
    let is_folder = reaches.count() > 1;
    if is_folder {
        make_room(out, overwrite)?
    } else {
        overwrite.file(out, &options.data)?
    }
    reaches.read_any(|recording| {
        let path = if is_folder { out.join(name_of(written.reaches)) } else { out.to_path_buf() };
        write_mcap(&path, recording)?;
        written.reaches += 1;
        written.frames += recording.frames.len();
        written.files += 1;
        written.bytes += std::fs::metadata(&path).map_or(0, |file| file.len());
        Ok::<(), Failure>(())
    })?;
    output::result(json, &written, || {
        let Written { reaches, frames, files, .. } = written;
        let megabytes = written.bytes as f64 / 1e6;
        let counts = [(reaches, "reach", "reaches"), (frames, "frame", "frames"), (files, "file", "files")];
        let [reaches, frames, files] = counts.map(|(count, one, many)| output::counted(count, one, many));
        format!("{reaches}, {frames} in {files}, {megabytes:.1} MB: {}", out.display())
    })
}
