//! The single file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::decompress_to_vec_zlib;

use super::source;
use crate::page::PAGE;
use crate::{page_that_fits, single_file};

/// The text between two others.
fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let from = text.find(start).unwrap() + start.len();
    &text[from..from + text[from..].find(end).unwrap()]
}

/// Tests that the file holds the bytes that the server would send, compressed, for the chosen reaches, which are renumbered.
#[test]
fn a_single_file_holds_the_packed_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let source = source(folder.path());
    let page = single_file(&source, &[1], usize::MAX).unwrap();
    let data = between(&page, "id=\"underbrush-reach-0\">", "</script>");
    let packed = STANDARD.decode(data).unwrap();
    assert_eq!(decompress_to_vec_zlib(&packed).unwrap(), source.pack(1).unwrap());
    assert!(!page.contains("id=\"underbrush-reach-1\">"));
    let list = between(&page, "id=\"underbrush-reaches\">", "</script>");
    let list: serde_json::Value = serde_json::from_str(list).unwrap();
    assert_eq!(list.as_array().unwrap().len(), 1);
    assert_eq!((&list[0]["number"], &list[0]["reach_index"]), (&0.into(), &1.into()));
}

/// Tests that a reach that is named twice is chosen once, and that all are if none is named.
#[test]
fn each_reach_is_chosen_once() {
    let folder = tempfile::tempdir().unwrap();
    let source = source(folder.path());
    assert_eq!(source.chosen(&[1, 0, 1]), [1, 0]);
    assert_eq!(source.chosen(&[]), (0..source.reaches.len()).collect::<Vec<_>>());
}

/// Tests that a file that no browser could open is refused, with the number of reaches that would fit.
#[test]
fn a_file_that_is_too_large_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let source = source(folder.path());
    let one = single_file(&source, &[0], usize::MAX).unwrap().len() - PAGE.len();
    let max_bytes = PAGE.len() + one * 3 / 2;
    let error = single_file(&source, &[0, 1], max_bytes).unwrap_err().to_string();
    assert!(error.contains("only the first 1 reaches fit"), "{error}");
    let fitting = (single_file(&source, &[0], max_bytes).unwrap(), 1);
    assert_eq!(page_that_fits(&source, &[0, 1], max_bytes).unwrap(), fitting);
}

/// Tests that the built page is one file: it has the place for data, its own script and style, and refers to nothing
/// else.
#[test]
fn the_page_needs_no_other_file() {
    assert_eq!(PAGE.matches("<!--underbrush-data-->").count(), 1);
    assert!(PAGE.contains("<script type=\"module\">") && PAGE.contains("<style>"));
    for reference in ["src=\"/", "href=\"/", "src=\"./", "href=\"./", "@import", "src=\"http", "href=\"http"] {
        assert!(!PAGE.contains(reference), "{reference}");
    }
}
