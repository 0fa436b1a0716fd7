//! Why an experiment ended without its result.

use std::io;
use std::path::Path;

use underbrush_recording::fault::Fault;

/// Why a campaign or an experiment ended without its result.
pub type ExperimentError = Fault;

/// For `map_err` after calls of the operating system: what could not be `made`, `read` or `removed`.
pub(crate) fn storage(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> ExperimentError {
    move |source| Fault::Storage(format!("{}: cannot be {action}: {source}", path.display()))
}

/// For `map_err` where a result is written as JSON.
pub(crate) fn json(path: &Path) -> impl Fn(serde_json::Error) -> ExperimentError {
    move |source| Fault::Run(format!("{}: cannot be written: {source}", path.display()))
}
