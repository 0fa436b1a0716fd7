//! One input file of an arm: its text, and errors that name its lines.

use std::path::{Path, PathBuf};

use glam::DVec3;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use underbrush_recording::{InputError, Limits, TEXT_BYTES, line_at, parse_toml, read_text, short};

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
    let texts: Vec<String> = values.iter().map(|value| short(*value)).collect();
    format!("[{}]", texts.join(", "))
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
    /// Parses the text as TOML.
    pub(super) fn toml<T: DeserializeOwned + JsonSchema>(&self, allowed: &str) -> Result<T, InputError> {
        parse_toml(&self.path, &self.text, "TOML", allowed)
    }

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

    /// An error about `field`. Its line is the first one from byte `offset` on that sets the last part of the field, or
    /// else the line of `offset` itself.
    pub(super) fn fault_after(
        &self,
        offset: usize,
        field: &str,
        found: impl ToString,
        allowed: impl Into<String>,
    ) -> InputError {
        let key = field.rsplit('.').next().unwrap_or(field);
        let sets =
            |line: &str| line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='));
        let first = self.line(offset);
        let line = (first..)
            .zip(self.text.lines().skip(first - 1))
            .find(|(_, line)| sets(line))
            .map_or(first, |(number, _)| number);
        let remedy = format!("change `{key}` in {}", self.path.display());
        self.fault(field, found, allowed, remedy).at_line(line)
    }

    /// Checks that a number at `field`, which stands after byte `offset`, is within its limits.
    pub(super) fn check(&self, offset: usize, field: &str, value: f64, limits: Limits) -> Result<(), InputError> {
        if limits.hold(value) {
            return Ok(());
        }
        Err(self.fault_after(offset, field, short(value), limits.to_string()))
    }

    /// As [`Source::check`], for a list of numbers.
    pub(super) fn check_each(
        &self,
        offset: usize,
        field: &str,
        values: &[f64],
        limits: Limits,
    ) -> Result<(), InputError> {
        if values.iter().all(|value| limits.hold(*value)) {
            return Ok(());
        }
        let allowed = format!("numbers from {limits}");
        Err(self.fault_after(offset, field, listed(values), allowed))
    }

    /// Normalizes the direction vector at `field`; an error if it is too short or too long.
    pub(super) fn direction(&self, offset: usize, field: &str, vector: [f64; 3]) -> Result<DVec3, InputError> {
        unit(vector).ok_or_else(|| self.fault_after(offset, field, listed(&vector), directions()))
    }

    /// The line, counted from 1, that contains a byte.
    pub(super) fn line(&self, offset: usize) -> usize {
        line_at(&self.text, offset)
    }
}
