//! The replay page: reaches in the browser or in a cell of a notebook.

use std::path::PathBuf;

use pyo3::prelude::*;
use underbrush_recording::disk::check_free;
use underbrush_replay::{Judging, Source, single_file};
use underbrush_report::replayed::{MAX_PAGE_BYTES, known};

use crate::{Failure, pool};

/// The page with some reaches of data sets and recordings inside, as the text of one HTML file.
#[pyfunction]
#[pyo3(signature = (paths, reaches = None, *, model = None, patch = None))]
pub fn replay_page(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    reaches: Option<Vec<usize>>,
    model: Option<PathBuf>,
    patch: Option<String>,
) -> Result<String, Failure> {
    pool::detached(py, None, || {
        let judging = model.map(|path| Judging::load(&path, patch.as_deref())).transpose()?;
        let source = Source::open(&paths, known(), judging)?;
        let all = (0..source.reaches.len()).collect();
        Ok(single_file(&source, &reaches.unwrap_or(all), MAX_PAGE_BYTES)?)
    })
}

/// Refuses a path where a file is already, unless ``force`` says that it may be overwritten.
#[pyfunction]
pub fn _check_free(path: PathBuf, force: bool) -> Result<(), Failure> {
    Ok(check_free(&path, force)?)
}
