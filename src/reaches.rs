//! Whole reaches of data sets and recordings, read one after the other, so that memory stays bounded.

use std::collections::BTreeSet;
use std::path::PathBuf;

use underbrush_classifier::evaluate::touch_folds::ReadReaches;
use underbrush_recording::disk::{Dataset, is_folder, is_recording, read_recording};
use underbrush_recording::{InputError, Recording};

use crate::{Failure, input, progress};

/// The reaches of some data sets and recordings, in the order in which they are given.
pub struct Reaches {
    sources: Vec<(PathBuf, Source)>,
}

enum Source {
    Dataset(Box<Dataset>),
    Recording,
}

/// What commands that need whole frames accept.
const ALLOWED: &str = "data sets (folders) or recordings (.parquet), which hold whole frames";

impl Reaches {
    /// Finds the reaches of these files and folders.
    ///
    /// # Errors
    /// If one is neither a data set nor a recording, or is given twice: a reach would be in training and test at once.
    pub fn open(paths: &[PathBuf]) -> Result<Self, Failure> {
        let mut places = BTreeSet::new();
        let source = |path: &PathBuf| {
            input::check_exists(path, ALLOWED)?;
            let source = if is_folder(path)? {
                Source::Dataset(Box::new(Dataset::open(path)?))
            } else if is_recording(path)? {
                Source::Recording
            } else {
                let remedy = "give the data set or recording that the trials were taken from";
                return Err(InputError::new(path, "input", "a table of trials or another file", ALLOWED, remedy).into());
            };
            // Two names of one file are one file.
            let place = std::fs::canonicalize(path).unwrap_or_else(|_| path.clone());
            if !places.insert(place) {
                let remedy = "leave it out where it is named again";
                let allowed = "each data set or recording once, so that no reach counts twice";
                return Err(InputError::new(path, "input", "the same input twice", allowed, remedy).into());
            }
            Ok((path.clone(), source))
        };
        let sources: Result<Vec<_>, Failure> = paths.iter().map(source).collect();
        Ok(Reaches { sources: sources? })
    }
}

impl Source {
    /// Number of its reaches.
    fn count(&self) -> usize {
        match self {
            Source::Dataset(dataset) => dataset.episodes().len(),
            Source::Recording => 1,
        }
    }
}

impl ReadReaches for Reaches {
    type Error = Failure;

    fn count(&self) -> usize {
        self.sources.iter().map(|(_, source)| source.count()).sum()
    }

    /// Reads the reaches with a progress bar. It fails if a file is damaged; errors of `each` name the file.
    fn read(
        &self,
        keeps: &dyn Fn(usize) -> bool,
        each: &mut dyn FnMut(&Recording) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let bar = progress::bar((0..self.count()).filter(|position| keeps(*position)).count() as u64, "reaches read");
        let mut position = 0;
        for (path, source) in &self.sources {
            for index in 0..source.count() {
                if keeps(position) {
                    let recording = match source {
                        Source::Dataset(dataset) => dataset.read_reach(index)?,
                        Source::Recording => read_recording(path)?,
                    };
                    each(&recording).map_err(|failure| failure.about(path))?;
                    bar.inc(1);
                }
                position += 1;
            }
        }
        bar.finish_and_clear();
        Ok(())
    }
}
