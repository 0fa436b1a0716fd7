//! The live stream: frames of a skin as lines of JSON (docs/live-stream.md). [`Lines`] bounds their length, so that memory stays
//! bounded whatever comes in.

mod json;
mod line;

use std::io::{self, BufRead};

pub use json::LineError;
pub use line::{LineParser, Message};

/// The lines of a stream with their numbers.
///
/// ```
/// use underbrush_exchange::live::Lines;
///
/// let mut lines = Lines::new("short\n\na line that is too long\n".as_bytes(), 10);
/// assert_eq!(lines.next_line()?, Some((1, Ok("short"))));
/// // Blank lines are counted and skipped.
/// assert!(matches!(lines.next_line()?, Some((3, Err(_)))));
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct Lines<R> {
    reader: R,
    max_bytes: usize,
    number: usize,
    buffer: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    /// The lines of a reader. A line longer than `max_bytes` is skipped and becomes an error.
    pub fn new(reader: R, max_bytes: usize) -> Self {
        Lines { reader, max_bytes, number: 0, buffer: Vec::new() }
    }

    /// The next line that is not blank, with its number from 1 and without its line ending; `None` at the end of the
    /// stream. A line that is too long or not UTF-8 is a [`LineError`] of its own, after which the next line can be read.
    ///
    /// # Errors
    /// If the reader fails.
    pub fn next_line(&mut self) -> io::Result<Option<(usize, Result<&str, LineError>)>> {
        let result = loop {
            self.buffer.clear();
            // One byte more than allowed distinguishes a line that is too long from one that just fits.
            let limit = self.max_bytes as u64 + 1;
            let read = io::Read::take(&mut self.reader, limit).read_until(b'\n', &mut self.buffer)?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            if self.number == 1 && self.buffer.starts_with("\u{feff}".as_bytes()) {
                self.buffer.drain(..3);
            }
            if self.buffer.len() > self.max_bytes && self.buffer.last() != Some(&b'\n') {
                self.reader.skip_until(b'\n')?;
                let allowed = format!("at most {} bytes for this skin", self.max_bytes);
                break Err(LineError::new("line", format!("more than {} bytes", self.max_bytes), allowed));
            }
            if !self.buffer.trim_ascii().is_empty() {
                break Ok(());
            }
        };
        let text = result.and_then(|()| {
            std::str::from_utf8(self.buffer.trim_ascii()).map_err(|error| {
                let found = format!("bytes that are not UTF-8 after byte {}", error.valid_up_to());
                LineError::new("line", found, "JSON in UTF-8")
            })
        });
        Ok(Some((self.number, text)))
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use super::*;

    fn read(bytes: &[u8], max_bytes: usize) -> Vec<(usize, Result<String, String>)> {
        // A small buffer, so that lines do not end where reads do.
        let mut lines = Lines::new(BufReader::with_capacity(3, bytes), max_bytes);
        let mut found = Vec::new();
        while let Some((number, line)) = lines.next_line().unwrap() {
            found.push((number, line.map(str::to_owned).map_err(|error| error.found)));
            assert!(lines.buffer.capacity() <= 2 * (max_bytes + 1), "the buffer grows");
        }
        found
    }

    /// Tests that blank lines are skipped but counted, that the last line needs no newline, and that both kinds of line
    /// endings work.
    #[test]
    fn lines_keep_their_numbers() {
        let found = read(b"a\n\n \t\r\nb\r\n  c  \nd", 100);
        let expected = [(1, "a"), (4, "b"), (5, "c"), (6, "d")];
        assert_eq!(found, expected.map(|(number, text)| (number, Ok(text.to_owned()))));
    }

    /// Tests that a byte order mark before the first line is no part of it.
    #[test]
    fn a_byte_order_mark_is_skipped() {
        assert_eq!(read("\u{feff}a\nb".as_bytes(), 100), [(1, Ok("a".to_owned())), (2, Ok("b".to_owned()))]);
    }

    /// Tests that a line that is too long, and bytes that are not UTF-8, are errors of that line alone, and that no
    /// more than the maximum length is kept in memory.
    #[test]
    fn a_bad_line_ends_at_its_end() {
        let long = "x".repeat(1_000_000);
        let bytes = [b"12345\n", long.as_bytes(), b"\n\xff\xfe\n123456\nend"].concat();
        let too_long = || Err("more than 5 bytes".to_owned());
        assert_eq!(
            read(&bytes, 5),
            [
                (1, Ok("12345".to_owned())),
                (2, too_long()),
                (3, Err("bytes that are not UTF-8 after byte 0".to_owned())),
                (4, too_long()),
                (5, Ok("end".to_owned())),
            ]
        );
    }
}
