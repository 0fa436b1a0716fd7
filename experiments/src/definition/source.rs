//! Finds the lines of keys in an experiment file, for errors.

use std::path::{Path, PathBuf};

use underbrush_recording::InputError;

/// The text of an experiment file, for errors.
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

impl Source<'_> {
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
}

impl Field {
    /// The error of this field.
    pub fn fault(&self, found: impl Into<String>, allowed: &str) -> InputError {
        let error = InputError::new(&self.path, &self.name, found.into(), allowed, "correct the file");
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }
}
