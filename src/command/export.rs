//! `underbrush export`: names the Python call that writes reaches for other tools. The command that pip installs writes them.

use std::path::PathBuf;

use clap::Args;

use crate::{Failure, Overwrite, options};

/// Options of `underbrush export`, which are those of the Python call.
#[derive(Args)]
pub struct ExportOptions {
    /// Data sets or folders of recordings, or recordings (.parquet)
    #[arg(required = true, value_name = "DATA")]
    _data: Vec<PathBuf>,
    /// Format to write
    #[arg(long, value_name = "FORMAT", value_parser = options::named::<String>(&[
        ("mcap", "For Foxglove; the same as python -m underbrush.mcap export"),
        ("ros2", "Bags of ROS 2; the same as python -m underbrush.ros2 export"),
        ("hdf5", "In the shape of robomimic's data sets; the same as python -m underbrush.hdf5 export"),
    ]))]
    to: String,
    /// File or folder to write
    #[arg(long = "out", value_name = "PATH")]
    _out: PathBuf,
    #[command(flatten)]
    _overwrite: Overwrite,
}

/// Says how the format is written.
pub fn run(options: ExportOptions, _json: bool) -> Result<(), Failure> {
    let module = options.to;
    let name = if module == "ros2" { "a bag of ROS 2".to_owned() } else { module.to_uppercase() };
    let remedy = format!("write it with `python -m underbrush.{module} export DATA --out PATH`");
    Err(Failure::usage(format!("{name} is written by the Python package only; {remedy}")))
}
