//! Results on stdout, everything else on stderr: the only place that prints.

use std::io::{IsTerminal, Write};
use std::path::Path;

use serde::{Serialize, Serializer};
use underbrush_recording::disk;

pub use underbrush_report::text::table;

use crate::failure::Failure;

/// Prints a result as text, or as one JSON object.
pub fn result<T: Serialize>(json: bool, value: &T, text: impl FnOnce() -> String) -> Result<(), Failure> {
    if json {
        lines([serde_json::to_string(value).map_err(|error| Failure::run(error.to_string()))?])
    } else {
        lines([text().trim_end().to_string()])
    }
}

/// Prints lines on stdout.
pub fn lines(lines: impl IntoIterator<Item = String>) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    for line in lines {
        writeln!(stdout, "{line}").map_err(Failure::output)?;
    }
    stdout.flush().map_err(Failure::output)
}

/// A remark for a person on stderr.
pub fn remark(text: impl AsRef<str>) {
    say(text.as_ref());
}

/// Remarks for a person on stderr, one a line.
pub fn remarks(texts: impl IntoIterator<Item = String>) {
    texts.into_iter().for_each(remark);
}

/// The hint of an interrupted program on stderr, on a line of its own: a bar, or the terminal's `^C`, may stand there.
pub fn interruption(hint: &str) {
    let line_break = if std::io::stderr().is_terminal() { "\n" } else { "" };
    say(&format!("{line_break}interrupted: {hint}"));
}

/// Prints a line on stderr if that is possible. A closed or full stderr changes neither the result nor the exit status,
/// and there is no other place to complain.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// An error on stderr.
pub fn error(failure: &Failure) {
    if !std::io::stderr().is_terminal() {
        // In a log nothing may break a path in two: it would be found by no search.
        let unwrapped = miette::set_hook(Box::new(|_| {
            Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())
        }));
        debug_assert!(unwrapped.is_ok(), "nothing else sets a hook");
    }
    say(&format!("{:?}", failure.report()));
}

/// Writes a file whole or not at all, and the folders above it.
pub fn write_file(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| {
            Failure::run(format!(
                "{}: cannot create: {error}; check the path and its permissions",
                folder.display()
            ))
        })?;
    }
    Ok(disk::write_file(path, contents)?)
}

/// Prints CSV.
pub fn csv(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Result<(), Failure> {
    let bytes = csv_bytes(header, rows)?;
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(&bytes).map_err(Failure::output)?;
    stdout.flush().map_err(Failure::output)
}

/// The bytes of a CSV file. Names are quoted where they have to be: a category may be any text in a foreign table.
pub fn csv_bytes(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Result<Vec<u8>, Failure> {
    let refused = |error: csv::Error| Failure::run(format!("cannot write CSV: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header).map_err(refused)?;
    for row in rows {
        writer.write_record(row).map_err(refused)?;
    }
    writer
        .into_inner()
        .map_err(|error| Failure::run(format!("cannot write CSV: {error}")))
}

/// A path as text in a result. Bytes that are not UTF-8 are replaced: only what is shown suffers.
pub fn path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}
