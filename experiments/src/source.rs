//! Reads the TOML files of experiments and suites, and finds the lines of their keys for errors.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use underbrush_recording::{InputError, read_text};

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
    read_text(path, &format!("a readable {kind} file"), &remedy)
}

impl Source<'_> {
    /// The contents of the file; `kind` is the name of its schema, as for `underbrush schema`.
    pub fn parse<T: DeserializeOwned>(&self, kind: &str) -> Result<T, InputError> {
        toml::from_str(self.text).map_err(|error| {
            let line = self.line_of(error.span().unwrap_or_default().start);
            let at = self.text.lines().nth(line - 1).unwrap_or_default();
            let key = at.split_once('=').map_or(at, |(key, _)| key).trim();
            let field = if key.is_empty() {
                kind.to_owned()
            } else {
                format!("{kind}, {key}")
            };
            let allowed = format!("the keys that `underbrush schema {kind}` lists");
            InputError::new(self.path, field, error.message(), allowed, "correct the line").at_line(line)
        })
    }

    /// A field whose value is `value`, found by its text.
    pub fn field(&self, name: &str, value: &str) -> Field {
        let key = name.rsplit('.').next().unwrap_or(name);
        let holds = |line: &&str| {
            let line = line.trim_start();
            (line.starts_with(key) || line.contains(&format!(" {key} ="))) && line.contains(value)
        };
        Field {
            path: self.path.into(),
            name: name.into(),
            line: self.text.lines().position(|line| holds(&line)).map(|index| index + 1),
        }
    }

    /// A field whose value begins at this byte of the text.
    pub fn field_at(&self, name: &str, start: usize) -> Field {
        Field {
            path: self.path.into(),
            name: name.into(),
            line: Some(self.line_of(start)),
        }
    }

    /// The line, counted from 1, of a byte of the text.
    fn line_of(&self, start: usize) -> usize {
        self.text.bytes().take(start).filter(|byte| *byte == b'\n').count() + 1
    }
}

impl Field {
    /// The error of this field.
    pub fn fault(&self, found: impl Into<String>, allowed: impl Into<String>) -> InputError {
        let error = InputError::new(&self.path, &self.name, found.into(), allowed, "correct the file");
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }
}
