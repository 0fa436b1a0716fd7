//! All printing: results on stdout, everything else on stderr.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};
use underbrush_recording::{InputError, disk};

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

/// A number with its noun, such as "1 reach" or "2 reaches".
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Prints lines on stdout.
pub fn lines(lines: impl IntoIterator<Item = String>) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    for line in lines {
        writeln!(stdout, "{line}").map_err(Failure::output)?;
    }
    stdout.flush().map_err(Failure::output)
}

/// Prints a remark on stderr.
pub fn remark(text: impl AsRef<str>) {
    say(text.as_ref());
}

/// Shows the warnings of the libraries as remarks.
pub fn show_warnings() {
    struct Remarks;
    impl log::Log for Remarks {
        fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
            metadata.target().starts_with("underbrush")
        }
        fn log(&self, record: &log::Record<'_>) {
            if self.enabled(record.metadata()) {
                remark(record.args().to_string());
            }
        }
        fn flush(&self) {}
    }
    if log::set_logger(&Remarks).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
}

/// Prints remarks on stderr, one per line.
pub fn remarks(texts: impl IntoIterator<Item = String>) {
    texts.into_iter().for_each(remark);
}

/// Prints the hint of an interrupted program on stderr, on a new line, because a progress bar or `^C` may be there.
pub fn interruption(hint: &str) {
    let line_break = if std::io::stderr().is_terminal() { "\n" } else { "" };
    say(&format!("{line_break}interrupted: {hint}"));
}

/// Prints a line on stderr. Errors are ignored: a closed or full stderr must not change the result or the exit status.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// Prints an error on stderr.
pub fn error(failure: &Failure) {
    if !std::io::stderr().is_terminal() {
        // No line breaks in a log, because a path that is broken in two cannot be searched for.
        let unwrapped = miette::set_hook(Box::new(|_| {
            Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())
        }));
        debug_assert!(unwrapped.is_ok(), "nothing else sets a hook");
    }
    say(&format!("{:?}", failure.report()));
}

/// Refuses an output that is one of the inputs, under whatever name: the input would be lost.
pub fn check_not_input<'a>(out: &Path, inputs: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
    let Ok(place) = std::fs::canonicalize(out) else {
        // There is no file that could be lost.
        return Ok(());
    };
    let mut inputs = inputs.into_iter();
    if inputs.any(|input| std::fs::canonicalize(input).is_ok_and(|own| own == place)) {
        return Err(Failure::usage(format!(
            "{}: is an input of this command, and the output would replace it; choose another name for the output",
            out.display()
        )));
    }
    Ok(())
}

/// Demands, before the work, that its result can be written to this file: no folder or device is there, and the parent
/// folders are there or are created.
pub fn prepare(path: &Path) -> Result<(), Failure> {
    if std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(Failure::usage(format!(
            "{}: is a folder or not a regular file; give the name of a file to write",
            path.display()
        )));
    }
    create_parents(path)
}

/// Demands, before the work, that a table of trials can be written to this file: its name ends as [`write_trials`]
/// demands, and the rest is as for [`prepare`].
///
/// [`write_trials`]: underbrush_recording::disk::write_trials
pub fn prepare_table(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    if !["csv", "parquet"].contains(&extension.to_ascii_lowercase().as_str()) {
        let (found, allowed) = (format!("extension {extension:?}"), "trials as .csv or .parquet");
        return Err(InputError::new(path, "file name", found, allowed, "choose such a name").into());
    }
    prepare(path)
}

/// Writes a file completely or not at all, and creates its parent folders.
pub fn write_file(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    create_parents(path)?;
    Ok(disk::write_file(path, contents)?)
}

fn create_parents(path: &Path) -> Result<(), Failure> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| {
            Failure::run(format!(
                "{}: cannot create: {error}; check the path and its permissions",
                folder.display()
            ))
        })?;
    }
    Ok(())
}

/// Prints CSV.
pub fn csv(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Result<(), Failure> {
    let bytes = csv_bytes(header, rows)?;
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(&bytes).map_err(Failure::output)?;
    stdout.flush().map_err(Failure::output)
}

/// The bytes of a CSV file. Cells are quoted if needed: a category in a table of another program may be any text.
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

/// A path as text in a result. Bytes that are not UTF-8 are replaced, which affects only what is shown.
pub fn path<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&path.display())
}
