//! Errors: bad input with its place, and what an error means to the program that called the library.
//!
//! A user can meet four kinds of errors. The command line turns each kind into an exit status, and the Python
//! package turns it into an exception. A crate whose callers need to tell errors apart has its own error types and converts
//! them with `From` for [`Fault`]. Experiments and reports return a [`Fault`] directly.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::plain_text::shortened;

/// Bad input in a file that a person or another program wrote.
///
/// The program prints it, with the offending line if `line` is known, and ends with exit status 2, or 1 if the operating
/// system failed to read the file.
///
/// ```
/// use underbrush_recording::InputError;
///
/// let error = InputError::new("leaf.toml", "goals.count", "0", "1 to 100", "change the value in the scene file").at_line(7);
/// assert!(error.to_string().contains("goals.count"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputError {
    /// The file.
    pub file: PathBuf,
    /// Line in the file, from 1, if known.
    pub line: Option<usize>,
    /// The field, column or key, for instance `leaf.flexural_rigidity_n_m2`.
    pub field: String,
    /// What was found there.
    pub found: String,
    /// What is allowed there.
    pub allowed: String,
    /// The remedy.
    pub remedy: String,
    /// Whether the operating system failed to read the file. Then the input may be good, and reading it may succeed later.
    pub storage: bool,
}

/// Longer texts are cut to this many characters: an error about a line of a megabyte must stay short.
const LONGEST_TEXT: usize = 400;

impl InputError {
    /// An error about `field` of `file`, without a line (see [`InputError::at_line`]). Long texts are shortened.
    pub fn new(
        file: impl AsRef<Path>,
        field: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        let [field, found, allowed, remedy] = [field.into(), found.into(), allowed.into(), remedy.into()].map(brief);
        let file = file.as_ref().to_path_buf();
        InputError { file, line: None, field, found, allowed, remedy, storage: false }
    }

    /// The error of the parser of a CSV text in memory, with its line.
    #[cfg(feature = "disk")]
    pub fn of_csv(file: &Path, field: &str, text: &[u8], error: csv::Error, remedy: &str) -> Self {
        let line = error.position().map(|position| line_of_row(text, position));
        // The parser's own line numbers do not count blank lines, so they are left out of the messages.
        let (found, allowed) = match error.into_kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                let cells = |count: u64| if count == 1 { "1 cell".to_owned() } else { format!("{count} cells") };
                (cells(len), format!("{}, as in the header", cells(expected_len)))
            }
            csv::ErrorKind::Utf8 { .. } => ("bytes that are not UTF-8".into(), "UTF-8 text".to_string()),
            csv::ErrorKind::Deserialize { err, .. } => (err.to_string(), "a number in each of the columns".into()),
            other => (format!("{other:?}"), "CSV with a header line".into()),
        };
        InputError::new(file, field, found, allowed, remedy).at_line(line)
    }

    /// The same error with its line (from 1), or with none if it is not known.
    #[must_use]
    pub fn at_line(self, line: impl Into<Option<usize>>) -> Self {
        InputError { line: line.into(), ..self }
    }

    /// The same error about a file that another file names: the remedy tells where, with the line (from 1) if it is known.
    #[must_use]
    pub fn named_in(self, file: &Path, line: Option<usize>) -> Self {
        let line = line.map_or_else(String::new, |line| format!(":{line}"));
        InputError { remedy: format!("{}; {}{line} names this file", self.remedy, file.display()), ..self }
    }
}

/// A text cut to [`LONGEST_TEXT`] characters, with its original length if it was longer.
fn brief(text: String) -> String {
    let characters = text.chars().count();
    if characters <= LONGEST_TEXT {
        return text;
    }
    format!("{} ({characters} characters)", shortened(&text, LONGEST_TEXT))
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(f, ": {}: found {}; allowed: {}; remedy: {}", self.field, self.found, self.allowed, self.remedy)
    }
}

impl std::error::Error for InputError {}

/// The line of a text that contains the byte at `offset`, counted from 1.
pub fn line_at(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
}

/// The line of the CSV row at `position`, counted from 1. The parser counts from where it started to look for the row,
/// so blank lines before it (and the second half of a line break) have to be added.
#[cfg(feature = "disk")]
pub fn line_of_row(text: &[u8], position: &csv::Position) -> usize {
    let rest = text.get(position.byte() as usize..).unwrap_or_default();
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    position.line() as usize + blank.filter(|byte| **byte == b'\n').count()
}

/// What an error means.
///
/// ```
/// use underbrush_recording::InputError;
/// use underbrush_recording::fault::Fault;
///
/// let error = InputError::new("arm.toml", "mass_kg", "-1", "above 0 kg", "correct the mass");
/// assert!(matches!(Fault::from(error.clone()), Fault::Input(_)));
/// // The same file on a disk that fails may be read later.
/// assert!(matches!(Fault::from(InputError { storage: true, ..error }), Fault::Storage { .. }));
/// ```
#[derive(Clone, Debug, thiserror::Error)]
pub enum Fault {
    /// Bad input, with its place.
    #[error("{0}")]
    Input(Box<InputError>),
    /// Bad input or usage that one sentence describes.
    #[error("{0}")]
    Usage(String),
    /// The run failed although its input was good, and would fail again.
    #[error("{0}")]
    Run(String),
    /// A file could not be read or written, as on a full disk or a lost share: the same run may succeed later.
    #[error("{}: cannot {action}: {cause}; {remedy}", .file.display())]
    Storage {
        /// The file or folder.
        file: PathBuf,
        /// What was tried, as a verb (`read`, `write`).
        action: &'static str,
        /// What the operating system says.
        cause: String,
        /// The remedy.
        remedy: String,
    },
}

impl From<InputError> for Fault {
    fn from(error: InputError) -> Self {
        if !error.storage {
            return Fault::Input(Box::new(error));
        }
        Fault::Storage { file: error.file, action: "read", cause: error.found, remedy: error.remedy }
    }
}

#[cfg(test)]
mod tests {
    use super::InputError;

    /// Tests that an error about a cell of a megabyte is a few lines long, and is cut between characters.
    #[test]
    fn long_texts_are_shortened() {
        let long = "ü".repeat(1_000_000);
        let error = InputError::new("trials.csv", &long, &long, &long, &long).at_line(3);
        let text = error.to_string();
        assert!(text.chars().count() < 2000, "{} characters", text.chars().count());
        assert!(error.found.ends_with("… (1000000 characters)"), "{}", error.found);
        let short = InputError::new("trials.csv", "force_n", "inf", "a force", "correct the cell");
        assert_eq!(short.found, "inf");
    }
}
