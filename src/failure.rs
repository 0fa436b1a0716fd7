//! Turns errors into text and an exit status: 1 if the run failed, 2 for bad usage or input.

use std::path::Path;
use std::sync::Mutex;

use serde::Serialize;
use serde_json::json;
use underbrush_recording::{Fault, InputError, TEXT_BYTES, escaped, read_text};

/// The reason why a command ended without a result.
#[derive(Debug)]
pub struct Failure {
    text: String,
    input: Option<InputError>,
    /// File, cause and remedy if the disk failed.
    storage: Option<Box<[String; 3]>>,
    kind: Kind,
    /// Whether the reader of the output closed the pipe, as `| head` does. That is not a failure.
    pub closed_pipe: bool,
}

/// What is at fault.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    /// A file, which [`InputError`] describes.
    Input,
    /// The command line, or what it names.
    Usage,
    /// The run, although usage and input are good.
    Run,
    /// This program.
    Internal,
}

impl Failure {
    /// Bad usage, or bad input that is not in a file.
    pub fn usage(text: impl Into<String>) -> Self {
        Failure { text: text.into(), input: None, storage: None, kind: Kind::Usage, closed_pipe: false }
    }

    /// A run that failed.
    pub fn run(text: impl Into<String>) -> Self {
        Failure { kind: Kind::Run, ..Failure::usage(text) }
    }

    /// A bug in this program, as recorded by [`record_panics`].
    pub fn panic(last_panic: &Mutex<String>) -> Self {
        let what = last_panic.lock().map_or(String::new(), |what| what.clone());
        let text = format!("internal error: {what}; please report it with the command line and the input files");
        Failure { kind: Kind::Internal, ..Failure::usage(text) }
    }

    /// The same failure with the file that it is about, unless it names one already.
    #[must_use]
    pub fn about(self, path: &Path) -> Self {
        if self.input.is_some() || self.storage.is_some() {
            return self;
        }
        Failure { text: format!("{}: {}", path.display(), self.text), ..self }
    }

    /// A failure to write to standard output.
    pub fn output(error: std::io::Error) -> Self {
        let closed_pipe = error.kind() == std::io::ErrorKind::BrokenPipe;
        Failure { closed_pipe, ..Failure::run(format!("cannot write to standard output: {error}")) }
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        match self.kind {
            Kind::Run | Kind::Internal => 1,
            Kind::Input | Kind::Usage => 2,
        }
    }

    /// What `--json` prints: one object with the key `error`, whose values are null if they are not known.
    pub fn json(&self) -> String {
        let input = self.input.as_ref();
        let [file, found, remedy] = match input {
            Some(input) => [input.file.display().to_string(), input.found.clone(), input.remedy.clone()].map(Some),
            None => self.storage.clone().map(|known| (*known).map(Some)).unwrap_or_default(),
        };
        json!({ "error": {
            "kind": self.kind,
            "file": file,
            "line": input.and_then(|input| input.line),
            "field": input.map(|input| &input.field),
            "found": found,
            "allowed": input.map(|input| &input.allowed),
            "remedy": remedy,
            "message": self.text,
        } })
        .to_string()
    }

    /// The text to print, with the offending line of the file if it is known.
    pub fn report(&self) -> String {
        let Some(input) = &self.input else {
            return format!("error: {}", self.text);
        };
        let line = input.line.map_or(String::new(), |line| format!(":{line}"));
        let place = format!("{}{line}", input.file.display());
        let message = format!("{}: found {}", input.field, input.found);
        let help = format!("help: allowed: {}; {}", input.allowed, input.remedy);
        let quoted = input.line.and_then(|line| {
            let text = read_text(&input.file, &TEXT_BYTES, "", "").ok()?;
            quoted(&text, line)
        });
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
        let fault = Fault::from(error);
        let text = fault.to_string();
        match fault {
            Fault::Input(input) => Failure { input: Some(*input), kind: Kind::Input, ..Failure::usage(text) },
            Fault::Storage { file, cause, remedy, .. } => {
                Failure { storage: Some(Box::new([file.display().to_string(), cause, remedy])), ..Failure::run(text) }
            }
            Fault::Usage(_) => Failure::usage(text),
            Fault::Run(_) => Failure::run(text),
        }
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
