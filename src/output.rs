//! All printing: results on stdout, everything else on stderr. Control characters and bidirectional controls, which may
//! come from files, are escaped.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;
use underbrush_recording::{escaped, is_plain};
use underbrush_report::drawing::Rows;

pub use underbrush_experiments::files::{create_parents, write as write_file};
pub use underbrush_report::counted;

use crate::Failure;

/// Whether the JSON object on stdout is the result.
static RESULT_PRINTED: AtomicBool = AtomicBool::new(false);

/// Prints a result as text, or as one JSON object.
pub fn result<T: Serialize>(json: bool, value: &T, text: impl FnOnce() -> String) -> Result<(), Failure> {
    if json {
        RESULT_PRINTED.store(true, Ordering::Relaxed);
        line(&json_line(value)?)
    } else {
        line(text().trim_end())
    }
}

/// A value as a line of JSON.
pub fn json_line(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(|error| Failure::run(error.to_string()))
}

/// Prints a line on stdout, or several that have line breaks between them.
pub fn line(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{}", escaped(text)).and_then(|()| stdout.flush()).map_err(Failure::output)
}

/// Prints a remark on stderr. Errors are ignored: a closed or full stderr must not change the result or the exit status.
pub fn remark(text: impl AsRef<str>) {
    let _ = writeln!(std::io::stderr().lock(), "{}", escaped(text.as_ref()));
}

/// Prints the hint of an interrupted program on stderr, on a new line, because a progress bar or `^C` may be there.
pub fn interruption(hint: &str) {
    let line_break = if std::io::stderr().is_terminal() { "\n" } else { "" };
    remark(format!("{line_break}interrupted: {hint}"));
}

/// Prints the failure of a run on stderr, and with `json` as one object on stdout. A result that has been printed before stays
/// the only object, and says itself what is wrong, as that of `check` does. Returns the exit status.
pub fn status(result: Result<(), Failure>, json: bool) -> u8 {
    let Some(failure) = result.err().filter(|failure| !failure.closed_pipe) else { return 0 };
    if json && !RESULT_PRINTED.load(Ordering::Relaxed) {
        // The exit status and stderr tell the same.
        let _ = line(&failure.json());
    }
    remark(failure.report());
    failure.status()
}

/// Prints what clap has to say about these arguments: the help or the version, or an error. Returns the exit status.
pub fn usage(answer: &clap::Error, arguments: &[OsString]) -> u8 {
    let text = answer.render().to_string();
    if !answer.use_stderr() {
        return status(answer.print().map_err(Failure::output), false);
    }
    if arguments.iter().take_while(|argument| *argument != "--").any(|argument| argument == "--json") {
        let _ = line(&Failure::usage(text.trim_start_matches("error: ").trim_end()).json());
    }
    // An argument, such as the name of a file, may have escape sequences; clap's colours are not worth those.
    if arguments.iter().all(|argument| is_plain(&argument.to_string_lossy())) {
        let _ = answer.print();
    } else {
        remark(text.trim_end());
    }
    2
}

/// Prints things as CSV with these columns, or as one JSON object that lists them under `key`.
pub fn csv<'a, T: Serialize>(
    json: bool,
    key: &str,
    things: &'a [T],
    columns: impl FnOnce(Rows<&'a T>) -> Rows<&'a T>,
) -> Result<(), Failure> {
    if json {
        return result(true, &BTreeMap::from([(key, things)]), String::new);
    }
    line(columns(Rows::of(things)).table("", "").csv().trim_end_matches('\n'))
}

/// A share in per cent, for people; `-` if it is not known.
pub fn percent(share: impl Into<Option<f64>>) -> String {
    share.into().map_or("-".into(), |share| format!("{:.1}", 100.0 * share))
}
