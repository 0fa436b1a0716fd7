//! Reads what other robots felt: contact trials from files, and frames from live streams.
//!
//! * [`import`] cuts trials from a CSV file, as a mapping file describes.
//! * [`live`] reads the lines of a live stream of frames.
//! * [`press`] fits the law of a skin to a press test.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod import;
pub mod live;
pub mod press;
