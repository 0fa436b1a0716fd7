//! One input file of an arm: its text, and errors that name its lines.

use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use underbrush_recording::InputError;

/// A file's path and text.
pub(super) struct Source {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// Reads a file from the disk.
pub(super) fn read_from_disk(path: &Path) -> Result<String, InputError> {
    fs::read_to_string(path).map_err(|error| {
        InputError::new(
            path,
            "file",
            error.to_string(),
            "a readable text file",
            "check the path and the permissions",
        )
    })
}

impl Source {
    /// Parses the text as TOML.
    pub(super) fn toml<T: DeserializeOwned>(&self, remedy: &str) -> Result<T, InputError> {
        toml::from_str(&self.text).map_err(|error| {
            let fault = InputError::new(
                &self.path,
                "TOML",
                error.message(),
                "the keys of this kind of file",
                remedy,
            );
            match error.span() {
                Some(span) => fault.at_line(self.line(span.start)),
                None => fault,
            }
        })
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

    /// An error about `field`, at the first line from byte `offset` on that sets the field's last part, or else at
    /// the line of `offset` itself.
    pub(super) fn fault_after(
        &self,
        offset: usize,
        field: &str,
        found: impl ToString,
        allowed: impl Into<String>,
    ) -> InputError {
        let key = field.rsplit('.').next().unwrap_or(field);
        let first = self.line(offset);
        let line = (first..)
            .zip(self.text.lines().skip(first - 1))
            .find(|(_, line)| {
                line.trim_start()
                    .strip_prefix(key)
                    .is_some_and(|rest| rest.trim_start().starts_with('='))
            })
            .map_or(first, |(number, _)| number);
        let remedy = format!("change `{key}` in {}", self.path.display());
        self.fault(field, found, allowed, remedy).at_line(line)
    }

    /// The line, from 1, of the first `element` tag whose `name` attribute is `name`, in XML.
    pub(super) fn line_of_element(&self, element: &str, name: &str) -> Option<usize> {
        let opening = format!("<{element}");
        let attributes = [format!("name=\"{name}\""), format!("name='{name}'")];
        let mut from = 0;
        while let Some(start) = self.text[from..].find(&opening).map(|place| from + place) {
            let length = self.text[start..].find('>').unwrap_or(self.text.len() - start);
            let tag = &self.text[start..start + length];
            if attributes.iter().any(|attribute| tag.contains(attribute)) {
                return Some(self.line(start));
            }
            from = start + opening.len();
        }
        None
    }

    fn line(&self, offset: usize) -> usize {
        self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
    }
}
