//! Reads the TOML files of experiments and suites, and finds the lines of their keys for errors; writes the files of results.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use underbrush_recording::disk::{DiskError, write_file};
use underbrush_recording::{Fault, InputError, TEXT_BYTES, line_at, line_giving, parse_toml, read_text, short};

/// Creates a folder with its parents.
pub fn create_folder(folder: &Path) -> Result<(), Fault> {
    Ok(std::fs::create_dir_all(folder).map_err(DiskError::io(folder, "create"))?)
}

/// Creates the folders above a file.
pub fn create_parents(path: &Path) -> Result<(), Fault> {
    path.parent().map_or(Ok(()), create_folder)
}

/// Writes a file completely or not at all, and creates its parent folders.
pub fn write(path: &Path, contents: &[u8]) -> Result<(), Fault> {
    create_parents(path)?;
    Ok(write_file(path, contents)?)
}

/// Writes a value as JSON.
///
/// ```
/// use underbrush_experiments::files::write_json;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("result.json");
/// write_json(&path, &[1, 2])?;
/// assert_eq!(serde_json::from_slice::<Vec<u8>>(&std::fs::read(&path)?)?, [1, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), Fault> {
    write(path, &serde_json::to_vec_pretty(value).map_err(unwritable(path))?)
}

/// For `map_err` where a result is written as JSON.
pub(crate) fn unwritable(path: &Path) -> impl Fn(serde_json::Error) -> Fault {
    move |source| Fault::Run(format!("{}: cannot be written: {source}", path.display()))
}

/// A file's path and text, to which errors refer.
pub(crate) struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

/// A key of the file with its line.
pub(crate) struct Field {
    path: PathBuf,
    name: String,
    line: Option<usize>,
}

/// Reads the text of a file; `kind` is what it should hold, such as `experiment`.
pub(crate) fn read(path: &Path, kind: &str) -> Result<String, InputError> {
    let remedy = format!("check the path; `underbrush schema {kind}` describes the file");
    read_text(path, &TEXT_BYTES, &format!("a readable {kind} file"), &remedy)
}

impl Source<'_> {
    /// The contents of the file; `kind` is the name of its schema, as for `underbrush schema`.
    pub fn parse<T: DeserializeOwned + JsonSchema>(&self, kind: &str) -> Result<T, InputError> {
        parse_toml(self.path, self.text, kind, &format!("the keys that `underbrush schema {kind}` lists"))
    }

    /// A field with this value, or else one whose value has this text in it.
    pub fn field(&self, name: &str, value: &str) -> Field {
        let whole = self.found(name, &|text| text.trim_matches(['"', '\'']) == value);
        if whole.line.is_some() { whole } else { self.found(name, &|text| text.contains(value)) }
    }

    /// An error about the field with this value.
    pub fn fault(&self, name: &str, found: &str, allowed: impl Into<String>) -> InputError {
        self.field(name, found).fault(found, allowed)
    }

    /// The error of [`Source::fault`], unless a rule holds.
    pub fn check(&self, holds: bool, name: &str, found: &str, allowed: &str) -> Result<(), InputError> {
        if holds { Ok(()) } else { Err(self.fault(name, found, allowed)) }
    }

    /// An error about the field with this number, however the file writes it, unless a rule holds.
    pub fn check_number(&self, holds: bool, name: &str, value: f64, allowed: &str) -> Result<(), InputError> {
        let is_value = |text: &str| {
            let number = text.replace('_', "").parse::<f64>();
            number.is_ok_and(|number| number == value || (number.is_nan() && value.is_nan()))
        };
        if holds { Ok(()) } else { Err(self.found(name, &is_value).fault(short(value), allowed)) }
    }

    /// A field with its line, if the file gives it such a value.
    fn found(&self, name: &str, is_value: &dyn Fn(&str) -> bool) -> Field {
        Field { path: self.path.into(), name: name.into(), line: line_giving(self.text, name, is_value) }
    }

    /// A field whose value begins at this byte of the text.
    pub fn field_at(&self, name: &str, start: usize) -> Field {
        Field { path: self.path.into(), name: name.into(), line: Some(line_at(self.text, start)) }
    }
}

impl Field {
    /// An error about the file that this field names.
    pub fn named(&self, error: InputError) -> InputError {
        error.named_in(&self.path, self.line)
    }

    /// The error of this field.
    pub fn fault(&self, found: impl Into<String>, allowed: impl Into<String>) -> InputError {
        InputError::new(&self.path, &self.name, found.into(), allowed, "correct the file").at_line(self.line)
    }
}
