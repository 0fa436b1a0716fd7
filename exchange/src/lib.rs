//! Exchanges data with other tools: recordings as MCAP files, and contact trials from the files of other robots.
//!
//! * [`write_mcap`] writes a reach for Foxglove and ROS 2 tools.
//! * [`live`] reads the lines of a live stream of frames.
//! * [`import`] cuts trials from a CSV or MCAP file, as a mapping file describes.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(test)]
mod example;
pub mod import;
pub mod live;
mod mcap;
mod to_mcap;

pub use to_mcap::write_mcap;
