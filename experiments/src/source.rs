//! Reads the TOML files of experiments and suites, and finds the lines of their keys for errors.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use underbrush_recording::{InputError, TEXT_BYTES, line_at, parse_toml, read_text};

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

    /// A field whose value is `value`, found by its text.
    pub fn field(&self, name: &str, value: &str) -> Field {
        let key = name.rsplit('.').next().unwrap_or(name);
        let holds = |line: &&str| {
            let line = line.trim_start();
            (line.starts_with(key) || given(line, key).next().is_some()) && line.contains(value)
        };
        self.found(name, self.text.lines().position(|line| holds(&line)))
    }

    /// An error about the field with this value. Its line is the one in which both stand.
    pub fn fault(&self, name: &str, found: &str, allowed: impl Into<String>) -> InputError {
        self.field(name, found).fault(found, allowed)
    }

    /// A field whose value is this number, however the file writes it.
    pub fn number(&self, name: &str, value: f64) -> Field {
        let key = name.rsplit('.').next().unwrap_or(name);
        let is_value = |text: &str| {
            let end = text.find([',', '}', ']', '#', ' ', '\t']).unwrap_or(text.len());
            let number = text[..end].replace('_', "").parse::<f64>();
            number.is_ok_and(|number| number == value || (number.is_nan() && value.is_nan()))
        };
        let holds = |line: &str| given(line, key).any(is_value);
        self.found(name, self.text.lines().position(holds))
    }

    /// A field at an index of the lines, if it was found.
    fn found(&self, name: &str, index: Option<usize>) -> Field {
        Field { path: self.path.into(), name: name.into(), line: index.map(|index| index + 1) }
    }

    /// A field whose value begins at this byte of the text.
    pub fn field_at(&self, name: &str, start: usize) -> Field {
        Field { path: self.path.into(), name: name.into(), line: Some(line_at(self.text, start)) }
    }
}

/// What a line gives for a key: the text after each `key =`, also within an inline table and after a dot.
fn given<'a>(line: &'a str, key: &'a str) -> impl Iterator<Item = &'a str> {
    line.match_indices(key).filter_map(move |(start, _)| {
        let before = line[..start].chars().next_back();
        let after = line[start + key.len()..].trim_start_matches(['"', '\'']);
        let value = after.trim_start().strip_prefix('=')?;
        let begins = before.is_none_or(|before| " \t{,.\"'".contains(before));
        begins.then(|| value.trim_start())
    })
}

impl Field {
    /// An error about the file that this field names.
    pub fn named(&self, error: InputError) -> InputError {
        error.named_in(&self.path, self.line)
    }

    /// The error of this field.
    pub fn fault(&self, found: impl Into<String>, allowed: impl Into<String>) -> InputError {
        let error = InputError::new(&self.path, &self.name, found.into(), allowed, "correct the file");
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }
}
