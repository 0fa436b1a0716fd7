//! A broken rule: where it was broken, what was found there and what is allowed.

use std::path::Path;

use crate::{DiskError, InputError};

/// A rule broken by a recording or a trial.
#[derive(Debug, PartialEq)]
pub(crate) struct Violation {
    /// The field that breaks the rule.
    pub(crate) field: String,
    /// What was found.
    pub(crate) found: String,
    /// The rule.
    pub(crate) allowed: &'static str,
}

impl Violation {
    /// The error when writing to a file.
    pub(crate) fn unwritable(self, path: &Path) -> DiskError {
        let Violation { field, found, allowed } = self;
        DiskError::Unwritable { path: path.to_path_buf(), field, found, allowed: allowed.to_string() }
    }

    /// The error when reading from a file.
    pub(crate) fn misread(self, path: &Path) -> DiskError {
        let remedy = "write the file again with the program that made it";
        InputError::new(path, self.field, self.found, self.allowed, remedy).into()
    }
}

/// An error with field, found and allowed, unless the rule holds.
pub(crate) fn require(
    holds: bool,
    field: impl FnOnce() -> String,
    found: impl FnOnce() -> String,
    allowed: &'static str,
) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation { field: field(), found: found(), allowed }) }
}

/// Checks that a quaternion of this length has unit length, up to a tolerance.
pub(super) fn require_unit(length: f64, tolerance: f64, field: impl FnOnce() -> String) -> Result<(), Violation> {
    let found = || format!("a quaternion of length {length}");
    require((length - 1.0).abs() <= tolerance, field, found, "a quaternion of length 1")
}

/// `Err` with the first number that is not finite.
pub(super) fn finite(values: impl IntoIterator<Item = f64>, field: impl FnOnce() -> String) -> Result<(), Violation> {
    match values.into_iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Violation { field: field(), found: value.to_string(), allowed: "finite numbers" }),
    }
}
