//! Tests of the pages for people.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders without pages of this project.
const SKIPPED: [&str; 6] = ["target", "node_modules", ".git", "kept", ".venv", "corpus"];

/// Files that the program or a build makes.
const MADE: [&str; 4] =
    ["report/index.html", "report/replay.html", "python/underbrush/_core.abi3.so", "fuzz/artifacts/"];

/// All pages (`.md`) below a folder.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_symlink() || SKIPPED.contains(&name.as_str()) {
            continue;
        }
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
}

/// The targets of links to files.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0));
    let files = targets.filter(|target| !target.contains("://") && !target.starts_with('#'));
    files.map(|target| target.split('#').next().unwrap_or(target))
}

/// The words in backticks that begin with a folder at the root of the project. Words that stand for several paths are
/// left out.
fn quoted<'a>(text: &'a str, folders: &'a BTreeSet<String>) -> impl Iterator<Item = &'a str> {
    let words = text.split('`').skip(1).step_by(2);
    words.filter(|word| {
        let plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || "/_-.".contains(letter);
        let own = word.split_once('/').is_some_and(|(folder, _)| folders.contains(folder));
        own && word.chars().all(plain)
    })
}

/// Tests that every link to a file and every path in backticks, in every page, leads to a file or folder.
#[test]
fn paths_in_the_pages_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let entries = fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path());
    // Builds and users' outputs are not of the project.
    let folders = entries.filter(|path| path.is_dir() && !path.ends_with("target") && !path.ends_with("out"));
    let folders: BTreeSet<String> =
        folders.map(|path| path.file_name().unwrap().to_string_lossy().into_owned()).collect();
    let (mut found, mut paths) = (Vec::new(), 0);
    pages(root, &mut found);
    let mut dead = Vec::new();
    for page in &found {
        let text = fs::read_to_string(page).unwrap();
        let beside = page.parent().unwrap();
        let mut require = |path: &str, exists: bool| {
            paths += 1;
            if !exists {
                dead.push(format!("{}: {path}", page.display()));
            }
        };
        links(&text).for_each(|target| require(target, beside.join(target).exists()));
        for word in quoted(&text, &folders).filter(|word| !MADE.contains(word)) {
            // Pages of a crate name its own files without the crate's folder.
            require(word, root.join(word).exists() || beside.join(word).exists());
        }
    }
    assert!(found.len() > 20 && paths > 200, "{} pages, {paths} paths", found.len());
    assert!(dead.is_empty(), "no such files:\n{}", dead.join("\n"));
}

/// Tests that the code in CONTRIBUTING.md stands in the files that it names, which are built: the examples work as shown.
#[test]
fn examples_of_contributing_are_built() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("CONTRIBUTING.md")).unwrap();
    let blocks: Vec<&str> = text.split("```rust\n").skip(1).map(|rest| rest.split_once("```").unwrap().0).collect();
    for block in &blocks {
        let mut source = String::new();
        for piece in format!("\n{block}").split("\n// ").skip(1) {
            let (head, code) = piece.split_once('\n').unwrap();
            if head.ends_with(".rs") {
                source = fs::read_to_string(root.join(head)).unwrap();
            }
            assert!(source.contains(code), "CONTRIBUTING.md shows what is not in the file:\n{code}");
        }
    }
    assert_eq!(blocks.len(), 4, "one example each for an object, a classifier, a figure and a command");
}
