//! Results on stdout, everything else on stderr: the only place that prints.
#![allow(clippy::print_stderr, reason = "this is the place for it")]

use std::io::{IsTerminal, Write};
use std::path::Path;

use serde::Serialize;

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
    eprintln!("{}", text.as_ref());
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
    eprintln!("{:?}", failure.report());
}

/// Writes a file whole or not at all: a temporary name in the same folder, sync, rename.
pub fn write_file(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(contents)?;
        file.as_file().sync_all()?;
        // Temporary files are private; a result is readable like any other file.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
        }
        file.persist(path)?;
        Ok(())
    };
    write().map_err(|error| {
        Failure::run(format!(
            "{}: cannot write: {error}; check the path and its permissions",
            path.display()
        ))
    })
}

/// A name as a field of a CSV file: a category may be any text in a foreign table.
pub fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_string()
    }
}

/// A table of columns padded to their widest entry; the first column left, the others right.
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let entries = rows
            .iter()
            .filter_map(|row| row.get(column))
            .map(|entry| entry.chars().count());
        entries.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |row: Vec<&str>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            if column == 0 {
                format!("{cell:<width$}")
            } else {
                format!("{cell:>width$}")
            }
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let mut text = line(header.to_vec());
    text += &(widths
        .iter()
        .map(|width| "-".repeat(*width))
        .collect::<Vec<_>>()
        .join("  ")
        + "\n");
    text.extend(rows.iter().map(|row| line(row.iter().map(String::as_str).collect())));
    text
}
