//! The command `underbrush` of the Python package.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Run the command line with these arguments, the program's name first, and return its exit status.
#[pyfunction]
pub fn run_command_line(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| ::underbrush::run_command_line(arguments))
}
