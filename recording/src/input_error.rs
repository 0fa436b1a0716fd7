//! The one error for bad input: it names the place, what was found there, what is allowed and the remedy.

use std::fmt;
use std::path::{Path, PathBuf};

/// Bad input in a file that a person or another program wrote.
///
/// The binary turns it into text once (with the offending line, where `line` is known) and ends with exit status 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// Line in the file, from 1, where it is known.
    pub line: Option<usize>,
    /// The field, column or key, for instance `leaf.flexural_rigidity_n_m2`.
    pub field: String,
    /// What was found there.
    pub found: String,
    /// What is allowed there.
    pub allowed: String,
    /// What to do about it.
    pub remedy: String,
}

impl InputError {
    /// An error about `field` of `file`, its line not known; see [`InputError::at_line`].
    pub fn new(
        file: impl AsRef<Path>,
        field: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        InputError {
            file: file.as_ref().to_path_buf(),
            line: None,
            field: field.into(),
            found: found.into(),
            allowed: allowed.into(),
            remedy: remedy.into(),
        }
    }

    /// The same error with its line (from 1).
    #[must_use]
    pub fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(
            f,
            ": {}: found {}; allowed: {}; remedy: {}",
            self.field, self.found, self.allowed, self.remedy
        )
    }
}

impl std::error::Error for InputError {}
