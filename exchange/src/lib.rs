//! Exchanges data with other tools: recordings as MCAP and HDF5 files, and contact trials from the files of other
//! robots.
//!
//! * [`write_mcap`] writes a reach for Foxglove and ROS 2 tools.
//! * `Hdf5Writer` (with the feature `hdf5`) writes reaches in the layout of robomimic's data sets.
//! * [`live`] reads the lines of a live stream of frames.
//! * [`import`] cuts trials from a CSV, HDF5 or MCAP file, as a mapping file describes.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod error;
#[cfg(test)]
mod example;
pub mod import;
pub mod live;
mod mcap;
#[cfg(feature = "hdf5")]
mod to_hdf5;
mod to_mcap;

pub use error::ExchangeError;
#[cfg(feature = "hdf5")]
pub use to_hdf5::{Hdf5Writer, write_hdf5};
pub use to_mcap::write_mcap;
