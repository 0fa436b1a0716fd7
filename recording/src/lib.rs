//! The data that a simulator or a real robot passes to a classifier.
//!
//! The types are plain data in SI units. A [`layout::SkinLayout`] says where the taxels are. A [`frame::Frame`] holds
//! one 100 Hz sample of arm and skin with its ground truth, a [`reach::Recording`] a whole reach, and a
//! [`trial::Trial`] the samples of one taxel, or one connected component, from the beginning of a contact to its end.
//! The disk formats (Parquet, JSON, CSV) need the feature `disk`.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod audit;
pub mod body;
pub mod category;
#[cfg(feature = "disk")]
pub mod disk;
pub mod fault;
pub mod frame;
pub mod layout;
pub mod limits;
pub mod math;
pub mod outcome;
pub mod plain_text;
pub mod reach;
pub mod regular_file;
pub mod stop;
#[cfg(feature = "toml")]
pub mod toml_text;
pub mod trial;
pub mod vector;

pub use audit::{Audit, AuditField};
pub use body::{Body, BodyOwner, BodyPart, BodyShape, MappedObstacle, ObstacleKind, TrackPoint};
pub use category::Category;
#[cfg(feature = "disk")]
pub(crate) use disk::Result;
#[cfg(feature = "disk")]
pub use disk::{Dataset, DiskError};
pub use fault::{Fault, InputError, line_at};
pub use frame::{ContactPoint, FRAME_PERIOD_S, Frame, Pose, TaxelReading, unit_quaternion};
pub use layout::{Grid, Patch, SkinLayout, Taxel};
pub use limits::{JSON_BYTES, Limits, TEXT_BYTES, short};
pub use outcome::{GoalOutcomes, NamedStop, Outcome, SafetyStop};
pub use plain_text::{PLAIN, escaped, is_plain, shortened};
pub use reach::{Contact, ContactForces, GoalRecord, ObjectRecord, Recording};
pub use regular_file::{open_regular, read_bytes, read_text};
#[cfg(feature = "toml")]
pub use toml_text::{line_giving, line_setting, parse_toml};
pub use trial::{Channels, Region, Sample, TRIAL_COLUMNS, Trial, period_s};

/// The different ones among `all`, in the order in which they first occur.
///
/// ```
/// use underbrush_recording::distinct;
///
/// assert_eq!(distinct(["leaf", "trunk", "leaf"]), ["leaf", "trunk"]);
/// ```
pub fn distinct<T: PartialEq>(all: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}
