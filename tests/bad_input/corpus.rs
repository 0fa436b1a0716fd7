//! Files that fuzzing has found, and the seeds from which it started.

use std::fs;
use std::path::Path;

#[path = "../../fuzz/parsers.rs"]
mod parsers;

use crate::support::{tree, underbrush};
use parsers::{PARSERS, SET};

/// Tests that every parser either reads or refuses each file of its corpus without a panic, that each corpus has at
/// least one file that is read, and that every corpus belongs to a parser.
#[test]
fn every_parser_survives_its_corpus() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    for (name, parse) in PARSERS {
        let mut read = 0;
        for file in fs::read_dir(corpus.join(name)).unwrap() {
            let file = file.unwrap().path();
            let bytes = fs::read(&file).unwrap();
            match std::panic::catch_unwind(|| parse(&bytes)) {
                Ok(whole) => read += usize::from(whole),
                Err(_) => panic!("{} makes the parser panic", file.display()),
            }
        }
        assert!(read > 0, "{name}: no file of the corpus is read");
    }
    let known = PARSERS.map(|(name, _)| name);
    for folder in fs::read_dir(corpus).unwrap() {
        let folder = folder.unwrap().file_name().to_string_lossy().into_owned();
        assert!(known.contains(&folder.as_str()), "no parser is called {folder}");
    }
}

/// Tests that the data set of the fuzz target has every file of a set, so that every reader of its files is tried.
#[test]
fn the_fuzzed_set_has_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/thicket.toml");
    underbrush!["generate", scene, "--reaches", "1", "--out", set].success();
    let files = tree(&set);
    let names = files.keys().filter_map(|path| path.to_str()).filter(|name| *name != "meta/checksums.json");
    assert_eq!(names.collect::<Vec<_>>(), SET.map(|(name, _)| name));
}
