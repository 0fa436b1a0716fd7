//! `underbrush export`: names the Python call that writes reaches for other tools.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::overwrite::Overwrite;
use crate::Failure;

/// Options of `underbrush export`, which are those of the Python call.
#[derive(Args)]
pub struct ExportOptions {
    /// Data sets (folders) or recordings (.parquet)
    #[arg(required = true, value_name = "DATA")]
    _data: Vec<PathBuf>,
    /// Format to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// File or folder to write
    #[arg(long = "out", value_name = "PATH")]
    _out: PathBuf,
    #[command(flatten)]
    _overwrite: Overwrite,
}

/// The formats.
#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// For Foxglove: python -m underbrush.mcap export
    Mcap,
    /// Bags of ROS 2: python -m underbrush.ros2 export
    Ros2,
    /// In the shape of robomimic's data sets: python -m underbrush.hdf5 export
    Hdf5,
}

/// Says how the format is written.
pub fn run(options: ExportOptions) -> Result<(), Failure> {
    let (name, module) = match options.to {
        Format::Mcap => ("MCAP", "mcap"),
        Format::Ros2 => ("a bag of ROS 2", "ros2"),
        Format::Hdf5 => ("HDF5", "hdf5"),
    };
    let remedy = format!("write it with `python -m underbrush.{module} export DATA --out PATH`");
    Err(Failure::usage(format!("{name} is written by the Python package only; {remedy}")))
}
