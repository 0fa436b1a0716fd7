//! Faults of files.

use std::io;
use std::path::Path;

use underbrush_recording::fault::Fault;

/// For `map_err` after calls of the operating system: what could not be `made`, `read` or `removed`.
pub(crate) fn storage(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Fault {
    move |source| Fault::Storage(format!("{}: cannot be {action}: {source}", path.display()))
}

/// For `map_err` where a result is written as JSON.
pub(crate) fn json(path: &Path) -> impl Fn(serde_json::Error) -> Fault {
    move |source| Fault::Run(format!("{}: cannot be written: {source}", path.display()))
}
