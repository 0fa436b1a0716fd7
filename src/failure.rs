//! Turns errors into text and an exit status: 1 if the run failed, 2 for bad usage or input.

use std::path::Path;
use std::sync::Mutex;

use serde_json::json;
use underbrush_recording::{Fault, TEXT_BYTES, escaped, read_text};

/// The reason why a command ended without a result.
#[derive(Debug)]
pub struct Failure {
    fault: Fault,
    /// Whether this program is at fault.
    is_internal: bool,
    /// Whether the reader of the output closed the pipe, as `| head` does. That is not a failure.
    pub closed_pipe: bool,
}

impl Failure {
    /// Bad usage, or bad input that is not in a file.
    pub fn usage(text: impl Into<String>) -> Self {
        Fault::Usage(text.into()).into()
    }

    /// A run that failed.
    pub fn run(text: impl Into<String>) -> Self {
        Fault::Run(text.into()).into()
    }

    /// A bug in this program, as recorded by [`record_panics`].
    pub fn panic(last_panic: &Mutex<String>) -> Self {
        let what = last_panic.lock().map_or(String::new(), |what| what.clone());
        let text = format!("internal error: {what}; please report it with the command line and the input files");
        Failure { is_internal: true, ..Failure::run(text) }
    }

    /// The same failure with the file that it is about, unless it names one already.
    #[must_use]
    pub fn about(mut self, path: &Path) -> Self {
        if let Fault::Usage(text) | Fault::Run(text) = &mut self.fault {
            *text = format!("{}: {text}", path.display());
        }
        self
    }

    /// A failure to write to standard output.
    pub fn output(error: std::io::Error) -> Self {
        let closed_pipe = error.kind() == std::io::ErrorKind::BrokenPipe;
        Failure { closed_pipe, ..Failure::run(format!("cannot write to standard output: {error}")) }
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        match self.fault {
            Fault::Run(_) | Fault::Storage { .. } => 1,
            Fault::Input(_) | Fault::Usage(_) => 2,
        }
    }

    /// What `--json` prints: one object with the key `error`, whose values are null if they are not known.
    pub fn json(&self) -> String {
        let input = if let Fault::Input(input) = &self.fault { Some(input) } else { None };
        let [file, found, remedy] = match &self.fault {
            Fault::Input(own) => [own.file.display().to_string(), own.found.clone(), own.remedy.clone()].map(Some),
            Fault::Storage { file, cause, remedy, .. } => {
                [file.display().to_string(), cause.clone(), remedy.clone()].map(Some)
            }
            Fault::Usage(_) | Fault::Run(_) => Default::default(),
        };
        let kind = match self.fault {
            _ if self.is_internal => "internal",
            Fault::Input(_) => "input",
            Fault::Usage(_) => "usage",
            Fault::Run(_) | Fault::Storage { .. } => "run",
        };
        json!({ "error": {
            "kind": kind,
            "file": file,
            "line": input.and_then(|input| input.line),
            "field": input.map(|input| &input.field),
            "found": found,
            "allowed": input.map(|input| &input.allowed),
            "remedy": remedy,
            "message": self.fault.to_string(),
        } })
        .to_string()
    }

    /// The text to print, with the offending line of the file if it is known.
    pub fn report(&self) -> String {
        let Fault::Input(input) = &self.fault else { return format!("error: {}", self.fault) };
        let line = input.line.map_or(String::new(), |line| format!(":{line}"));
        let place = format!("{}{line}", input.file.display());
        let message = format!("{}: found {}", input.field, input.found);
        let help = format!("help: allowed: {}; {}", input.allowed, input.remedy);
        let quoted = input.line.and_then(|line| quoted(&read_text(&input.file, &TEXT_BYTES, "", "").ok()?, line));
        match quoted {
            Some((column, quoted)) => format!("error: {message}\n --> {place}:{column}\n{quoted}\n{help}"),
            None => format!("error: {place}: {message}\n{help}"),
        }
    }
}

/// Longer lines are not shown with an error, and neither are their neighbours. Nobody reads such a line, and it may be
/// a whole file of many megabytes.
const MAX_LINE_BYTES: usize = 1000;

/// A line of a text (from 1), marked, between its neighbours, and the column of its first word. `None` if there is no such
/// line, or if one of these lines is too long. The lines are escaped here, so that the mark is as long as what is shown.
fn quoted(text: &str, line: usize) -> Option<(usize, String)> {
    let first = line.saturating_sub(1).max(1);
    let shown = text.lines().skip(first - 1).take(line + 2 - first);
    let shown: Vec<_> = shown.map(escaped).collect();
    if line < first || shown.len() <= line - first || shown.iter().any(|line| line.len() > MAX_LINE_BYTES) {
        return None;
    }
    let width = (line + 1).to_string().len();
    let mut column = 1;
    let mut quoted = format!("{:width$} |", "");
    for (number, text) in (first..).zip(&shown) {
        quoted += &format!("\n{number:width$} | {text}");
        if number == line {
            // Tabs stay, so that the mark begins under the first word.
            let (indent, words) = text.split_at(text.len() - text.trim_start().len());
            column += indent.chars().count();
            let mark = "^".repeat(words.trim_end().chars().count());
            quoted += &format!("\n{:width$} | {indent}{mark} here", "");
        }
    }
    Some((column, quoted))
}

/// The errors of all libraries, each of which can be converted to a [`Fault`].
impl<E> From<E> for Failure
where
    Fault: From<E>,
{
    fn from(error: E) -> Self {
        Failure { fault: error.into(), is_internal: false, closed_pipe: false }
    }
}

/// Records panics instead of printing them.
///
/// A damaged file can make the Parquet decoder panic, and an extreme scene the physics engine. Both panics are caught
/// where they happen and become errors, so the panic's own message on stderr would only confuse the user.
pub fn record_panics() -> &'static Mutex<String> {
    static LAST: Mutex<String> = Mutex::new(String::new());
    std::panic::set_hook(Box::new(|panic| {
        if let Ok(mut last) = LAST.lock() {
            let place = panic.location().map_or(String::new(), |place| format!(" at {place}"));
            *last = format!("{}{place}", panic.payload_as_str().unwrap_or("no message"));
        }
    }));
    &LAST
}
