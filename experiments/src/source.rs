//! Reads the TOML files of experiments and suites, and finds the lines of their keys for errors.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use underbrush_recording::{InputError, TEXT_BYTES, line_at, line_giving, parse_toml, read_text};

/// A file's path and text, to which errors refer.
pub struct Source<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

/// A key of the file with its line.
pub struct Field {
    path: PathBuf,
    name: String,
    line: Option<usize>,
}

/// Reads the text of a file; `kind` is what it should hold, such as `experiment`.
pub fn read(path: &Path, kind: &str) -> Result<String, InputError> {
    let remedy = format!("check the path; `underbrush schema {kind}` describes the file");
    read_text(path, &TEXT_BYTES, &format!("a readable {kind} file"), &remedy)
}

impl Source<'_> {
    /// The contents of the file; `kind` is the name of its schema, as for `underbrush schema`.
    pub fn parse<T: DeserializeOwned + JsonSchema>(&self, kind: &str) -> Result<T, InputError> {
        parse_toml(self.path, self.text, kind, &format!("the keys that `underbrush schema {kind}` lists"))
    }

    /// A field whose value has this text in it.
    pub fn field(&self, name: &str, value: &str) -> Field {
        self.found(name, &|text| text.contains(value))
    }

    /// An error about the field with this value.
    pub fn fault(&self, name: &str, found: &str, allowed: impl Into<String>) -> InputError {
        self.field(name, found).fault(found, allowed)
    }

    /// A field whose value is this number, however the file writes it.
    pub fn number(&self, name: &str, value: f64) -> Field {
        self.found(name, &|text| {
            let number = text.replace('_', "").parse::<f64>();
            number.is_ok_and(|number| number == value || (number.is_nan() && value.is_nan()))
        })
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
