//! All kinds of bad input: exit status 2, an error with place, cause and remedy, and no output left behind.

mod corpus;
mod damaged;
mod models;
mod ranges;
mod scenes;
mod suites;
mod tables;
mod terminal;
mod touch;
mod usage;

use std::path::Path;

use crate::support::Answer;

/// What an error about a file must contain.
struct Fault<'a> {
    /// The file.
    file: &'a Path,
    /// The line, if there is one.
    line: Option<usize>,
    /// The field, what was found there, what is allowed, and the remedy.
    parts: &'a [&'a str],
}

impl Fault<'_> {
    /// Demands exit status 2 and an error that contains all of these.
    #[track_caller]
    fn check(&self, answer: &Answer) {
        let file = self.file.display();
        let place = self.line.map_or(file.to_string(), |line| format!("{file}:{line}:"));
        answer.refused(&[&[place.as_str()], self.parts].concat());
    }
}

/// Demands that the folder for the output of a command is empty, without hidden files.
#[track_caller]
fn assert_empty(folder: &Path) {
    let left: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(left.is_empty(), "left behind: {left:?}");
}
