//! Refuses a model file of one kind where the other kind is read, and says what it is.

use std::path::Path;

use serde::Deserialize;
use underbrush_classifier::FORMAT;
use underbrush_classifier::touch::TOUCH_FORMAT;
use underbrush_recording::InputError;

/// The key that tells the kinds apart.
#[derive(Deserialize)]
struct Head {
    format: String,
}

/// Refuses the text of a touch model; the path is for the error only.
///
/// # Errors
/// [`InputError`] for a touch model of any version.
pub fn refuse_touch(path: &Path, text: &str) -> Result<(), InputError> {
    let remedy = "read it with TouchModel.load or TouchModel.from_json";
    refuse(path, text, (TOUCH_FORMAT, "a touch model"), FORMAT, remedy)
}

/// Refuses the text of a classifier of trials; the path is for the error only.
///
/// # Errors
/// [`InputError`] for a classifier of trials of any version.
pub fn refuse_of_trials(path: &Path, text: &str) -> Result<(), InputError> {
    let remedy = "read it with Model.load or Model.from_json";
    refuse(path, text, (FORMAT, "a classifier of trials"), TOUCH_FORMAT, remedy)
}

/// Refuses a text whose format is that of the other kind, which has a name. Any other text is left to its reader, whose
/// errors say more.
fn refuse(path: &Path, text: &str, other: (&str, &str), allowed: &str, remedy: &str) -> Result<(), InputError> {
    let (format, name) = other;
    match serde_json::from_str::<Head>(text) {
        Ok(head) if without_version(&head.format) == without_version(format) => {
            let found = format!("{}, {name}", head.format);
            Err(InputError::new(path, "format", found, allowed, remedy))
        }
        _ => Ok(()),
    }
}

fn without_version(format: &str) -> &str {
    format.split('/').next().unwrap_or(format)
}
