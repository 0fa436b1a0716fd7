//! One input file of an arm: its text, and errors that name its lines.

use std::path::{Path, PathBuf};

use glam::DVec3;
use underbrush_recording::{InputError, Limits, TEXT_BYTES, line_setting, read_text, short};

use super::limits::DIRECTION;

/// A file's path and text.
pub(super) struct Source {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// Reads a file from the disk.
pub(super) fn read_from_disk(path: &Path) -> Result<String, InputError> {
    read_text(path, &TEXT_BYTES, "a readable text file", "check the path and the permissions")
}

/// A list of numbers in brackets, each as short as possible.
pub(super) fn listed(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|value| short(*value)).collect::<Vec<_>>().join(", "))
}

/// A number rounded to so many significant digits.
pub(super) fn significant(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// A text as a TOML file holds it. Rust's own notation escapes combining accents, among others, in a way that TOML does not know.
pub(super) fn quoted(text: &str) -> toml::Value {
    text.into()
}

/// Normalizes a direction vector whose length is within the limits.
pub(super) fn unit(vector: [f64; 3]) -> Option<DVec3> {
    let vector = DVec3::from_array(vector);
    vector.try_normalize().filter(|_| DIRECTION.hold(vector.length()))
}

/// What a direction may be, for error messages.
pub(super) fn directions() -> String {
    format!("three numbers, not all zero; a vector of length {DIRECTION}")
}

impl Source {
    /// An error about the whole file.
    pub(super) fn fault(
        &self,
        field: impl Into<String>,
        found: impl ToString,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        InputError::new(&self.path, field, found.to_string(), allowed, remedy)
    }

    /// An error about the field at this path of the TOML, such as `patch[1].link`, at the line that sets it.
    pub(super) fn fault_at(&self, field: &str, found: impl ToString, allowed: impl Into<String>) -> InputError {
        let key = field.rsplit('.').next().unwrap_or(field);
        let remedy = format!("change `{key}` in {}", self.path.display());
        self.fault(field, found, allowed, remedy).at_line(self.line_setting(field))
    }

    /// The line that sets the field at this path or, if it is not there, the closest table around it.
    pub(super) fn line_setting(&self, field: &str) -> Option<usize> {
        let mut around = std::iter::successors(Some(field), |own| Some(own.rsplit_once('.')?.0));
        around.find_map(|own| line_setting(&self.text, own))
    }

    /// Checks that a number at `field` is within its limits.
    pub(super) fn check(&self, field: &str, value: f64, limits: Limits) -> Result<(), InputError> {
        if limits.hold(value) {
            return Ok(());
        }
        Err(self.fault_at(field, short(value), limits.to_string()))
    }

    /// As [`Source::check`], for a list of numbers.
    pub(super) fn check_each(&self, field: &str, values: &[f64], limits: Limits) -> Result<(), InputError> {
        if values.iter().all(|value| limits.hold(*value)) {
            return Ok(());
        }
        Err(self.fault_at(field, listed(values), format!("numbers from {limits}")))
    }

    /// Normalizes the direction vector at `field`; an error if it is too short or too long.
    pub(super) fn direction(&self, field: &str, vector: [f64; 3]) -> Result<DVec3, InputError> {
        unit(vector).ok_or_else(|| self.fault_at(field, listed(&vector), directions()))
    }
}
