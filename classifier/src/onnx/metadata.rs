//! The metadata of an ONNX model.

use std::path::Path;

use rten::ModelMetadata;
use underbrush_recording::InputError;

use crate::feature::{FeatureError, FeatureSet};

/// Largest window, samples. Choice: ten seconds at 100 Hz.
const LARGEST_WINDOW: usize = 1000;

/// What the metadata say.
#[derive(Debug)]
pub(super) struct Expected {
    pub(super) features: FeatureSet,
    pub(super) window: usize,
    pub(super) categories: Vec<String>,
    pub(super) is_probability: bool,
}

impl Expected {
    pub(super) fn read(path: &Path, metadata: &ModelMetadata) -> Result<Self, InputError> {
        let get = |key: &str| metadata.get(key);
        let fail = |key: &str, found: &str, allowed: &str| {
            let remedy = "set the model's metadata_props when you export it";
            InputError::new(path, format!("metadata {key}"), found.to_owned(), allowed.to_owned(), remedy.to_owned())
        };
        let need = |key: &str, allowed: &str| get(key).ok_or_else(|| fail(key, "nothing", allowed));
        let features = need("underbrush.features", "names of features, separated by commas")?;
        let window = need("underbrush.window", "a number of samples")?;
        let categories = need("underbrush.categories", "names in alphabetical order, separated by commas")?;
        let categories: Vec<String> = categories.split(',').map(|name| name.trim().to_owned()).collect();
        if categories.len() < 2 || !categories.is_sorted_by(|a, b| a < b) || categories[0].is_empty() {
            let allowed = "two or more names in alphabetical order, none twice";
            return Err(fail("underbrush.categories", &categories.join(","), allowed));
        }
        Ok(Expected {
            features: features
                .parse()
                .map_err(|error: FeatureError| fail("underbrush.features", features, &error.to_string()))?,
            window: match window.trim().parse() {
                Ok(samples) if (1..=LARGEST_WINDOW).contains(&samples) => samples,
                _ => return Err(fail("underbrush.window", window, "a whole number from 1 to 1000")),
            },
            categories,
            is_probability: match get("underbrush.output") {
                None | Some("probabilities") => true,
                Some("log-odds") => false,
                Some(other) => return Err(fail("underbrush.output", other, "probabilities or log-odds")),
            },
        })
    }
}
