//! Model files as text: reading parts of them, with errors that name the field.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use underbrush_recording::{Category, InputError};

use crate::error::ValueFault;
use crate::seal;

/// The format of models of trials.
pub const FORMAT: &str = "underbrush-model/1";

/// The key that says what a model file is.
#[derive(Deserialize)]
pub(crate) struct Head {
    pub(crate) format: String,
}

const REMEDY: &str = "correct the file, or train the model again";

/// The text of a model file and where it comes from.
#[derive(Clone, Debug)]
pub struct Document {
    /// Where the text comes from.
    pub(crate) path: PathBuf,
    text: String,
    format: &'static str,
}

impl Document {
    /// A text that should have this format, which errors name; the path is for errors only.
    pub(crate) fn of_format(path: impl AsRef<Path>, text: &str, format: &'static str) -> Self {
        Document { path: path.as_ref().to_owned(), text: text.to_owned(), format }
    }

    /// Reads the keys that `T` has; others are skipped.
    ///
    /// # Errors
    /// [`InputError`] with line and field, such as `models.leaf.mean[2]`.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, InputError> {
        let mut deserializer = serde_json::Deserializer::from_str(&self.text);
        let value = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
            let place = error.path().to_string();
            self.broken(&place, error.inner())
        })?;
        deserializer.end().map_err(|error| self.broken(".", &error))?;
        Ok(value)
    }

    /// Checks the seal of the file, if it has one, and warns if it has none.
    ///
    /// # Errors
    /// [`InputError`] if the content does not match the seal.
    pub(crate) fn check_seal(&self) -> Result<(), InputError> {
        seal::check(&self.path, &self.read()?)
    }

    fn broken(&self, place: &str, error: &serde_json::Error) -> InputError {
        let found = error.to_string();
        // For a missing key, serde gives its name, and the object that lacks it as the path.
        let missing = found.strip_prefix("missing field `").and_then(|rest| rest.split('`').next());
        let field = match (error.is_data(), place, missing) {
            (false, ..) => "JSON".to_owned(),
            (true, ".", Some(key)) => key.to_owned(),
            (true, ".", None) => "file".to_owned(),
            (true, place, Some(key)) => format!("{place}.{key}"),
            (true, place, None) => place.to_owned(),
        };
        let found = if error.is_data() { found } else { format!("unreadable JSON: {found}") };
        let allowed = format!("a model file of format {}", self.format);
        InputError::new(&self.path, field, found, allowed, REMEDY).at_line(error.line())
    }

    /// The error about one field.
    pub fn error(&self, field: impl Into<String>, found: impl Into<String>, allowed: impl Into<String>) -> InputError {
        InputError::new(&self.path, field.into(), found.into(), allowed.into(), REMEDY)
    }

    /// Refuses categories that are out of order, those that a terminal would not show as they are, and the verdict uncertain.
    pub(crate) fn check_names(&self, categories: &[String]) -> Result<(), InputError> {
        if categories.is_empty() || !categories.is_sorted_by(|a, b| a < b) {
            let found = categories.join(", ");
            return Err(self.error("categories", found, "one or more names in alphabetical order, none twice"));
        }
        let fault = categories.iter().find_map(|name| Some((name, Category::name_fault(name)?)));
        fault.map_or(Ok(()), |(name, allowed)| Err(self.error("categories", format!("{name:?}"), allowed)))
    }

    pub(crate) fn fault(&self, fault: ValueFault) -> InputError {
        self.error(fault.field, fault.found, fault.allowed)
    }
}
