//! Shows the warnings of the libraries as Python warnings.

use std::ffi::CString;

use log::{LevelFilter, Log, Metadata, Record};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

struct Warnings;

impl Log for Warnings {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("underbrush")
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let text = record.args().to_string();
        let text = CString::new(text.trim_start_matches("warning: ").replace('\0', "")).unwrap_or_default();
        Python::attach(|py| {
            // A filter may turn warnings into exceptions, but this call has no caller that could raise them.
            if let Err(error) = PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1) {
                error.write_unraisable(py, None);
            }
        });
    }

    fn flush(&self) {}
}

/// Shows warnings from now on.
pub fn show() {
    // It fails only if the module was loaded before, and then it is set already.
    if log::set_logger(&Warnings).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}
