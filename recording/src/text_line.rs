//! Lines of text files, for error messages. They are counted from 1.

/// The line that contains the byte at `offset`.
pub fn line_at(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1
}

/// The line of the CSV row at `position`. The parser counts from where it started to look for the row, so blank lines before it
/// (and the second half of a line break) have to be added.
#[cfg(feature = "disk")]
pub fn line_of_row(text: &[u8], position: &csv::Position) -> usize {
    let rest = text.get(position.byte() as usize..).unwrap_or_default();
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    position.line() as usize + blank.filter(|byte| **byte == b'\n').count()
}
