//! Shows the warnings of the libraries as Python warnings.

use std::ffi::CString;

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;

/// Shows a warning.
pub fn show(text: String) {
    let text = CString::new(text.trim_start_matches("warning: ").replace('\0', "")).unwrap_or_default();
    Python::attach(|py| {
        // A filter may turn warnings into exceptions, but this call has no caller that could raise them.
        if let Err(error) = PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1) {
            error.write_unraisable(py, None);
        }
    });
}
