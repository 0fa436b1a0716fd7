//! Whole reaches of data sets and recordings, read one after the other, so that memory stays bounded.

use std::collections::BTreeSet;
use std::path::PathBuf;

use underbrush_classifier::evaluate::touch_folds::ReadReaches;
use underbrush_recording::disk::{Dataset, file_blake3, is_folder, is_recording, read_recording};
use underbrush_recording::{InputError, Recording};

use crate::{Failure, input, progress};

/// The reaches of some data sets and recordings, in the order in which they are given.
pub struct Reaches {
    /// Each with its data set; a recording has none.
    sources: Vec<(PathBuf, Option<Dataset>)>,
}

/// What commands that need whole frames accept.
const ALLOWED: &str = "data sets (folders) or recordings (.parquet), which hold whole frames";

impl Reaches {
    /// Finds the reaches of these files and folders.
    ///
    /// # Errors
    /// If one is neither a data set nor a recording, or is given twice, as a copy, too: a reach would be in training and test at once.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut contents = BTreeSet::new();
        let source = |path: &PathBuf| {
            input::check_exists(path, ALLOWED)?;
            let dataset = if is_folder(path)? {
                Some(Dataset::open(path)?)
            } else if is_recording(path)? {
                None
            } else {
                let remedy = "give the data set or recording that the trials were taken from";
                return Err(InputError::new(path, "input", "a table of trials or another file", ALLOWED, remedy).into());
            };
            // Two names and two copies of one file are one file.
            let content = dataset.as_ref().map_or_else(|| file_blake3(path), |dataset| Ok(dataset.data_blake3()))?;
            if !contents.insert(content) {
                let remedy = "leave it out where it is named again";
                let allowed = "each data set or recording once, so that no reach counts twice";
                return Err(InputError::new(path, "input", "the same data twice", allowed, remedy).into());
            }
            Ok((path.clone(), dataset))
        };
        let sources: Result<Vec<_>, Failure> = paths.iter().map(source).collect();
        Ok(Reaches { sources: sources? })
    }
}

/// Number of the reaches of a data set, or of a recording.
fn count(dataset: Option<&Dataset>) -> usize {
    dataset.map_or(1, |dataset| dataset.episodes().len())
}

impl ReadReaches for Reaches {
    type Error = Failure;

    fn count(&self) -> usize {
        self.sources.iter().map(|(_, dataset)| count(dataset.as_ref())).sum()
    }

    /// Reads the reaches with a progress bar. It fails if a file is damaged; errors of `each` name the file.
    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let bar = progress::bar((0..self.count()).filter(|position| keeps(*position)).count() as u64, "reaches read");
        let mut position = 0;
        for (path, dataset) in &self.sources {
            for index in 0..count(dataset.as_ref()) {
                if keeps(position) {
                    let recording = match dataset {
                        Some(dataset) => dataset.read_reach(index)?,
                        None => read_recording(path)?,
                    };
                    each(&recording).map_err(|failure| failure.about(path))?;
                    bar.inc(1);
                }
                position += 1;
            }
        }
        Ok(())
    }
}
