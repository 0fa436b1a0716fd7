//! The checksum inside a Parquet file.
//!
//! A data set has a list of checksums, but a single file stands alone. Parquet's page checksums do not cover the
//! footer, and the library does not write them. Therefore the key-value metadata contain the BLAKE3 hash of the whole
//! file, computed with zeros in place of its own 64 digits, so that it covers every bit.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use super::DiskError;
use super::input_file::open_input;
use crate::InputError;

/// Metadata key of the hash.
pub(super) const SEAL_KEY: &str = "underbrush.blake3";
/// Hexadecimal digits of a hash.
const DIGITS: usize = 64;

/// The metadata entry of a file that is to be sealed: zeros in place of the hash.
pub(super) fn unsealed() -> (&'static str, String) {
    (SEAL_KEY, "0".repeat(DIGITS))
}

/// The position of the digits: after the last occurrence of the key as Parquet's footer encodes it, followed by one
/// byte each for type and length of the value.
fn place(bytes: &[u8]) -> Option<Range<usize>> {
    let entry = [SEAL_KEY.as_bytes(), &[0x18, DIGITS as u8]].concat();
    let start = bytes.windows(entry.len()).rposition(|window| window == entry)? + entry.len();
    (start + DIGITS <= bytes.len()).then_some(start..start + DIGITS)
}

fn hash(bytes: &[u8], digits: &Range<usize>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..digits.start]);
    hasher.update(&[b'0'; DIGITS]);
    hasher.update(&bytes[digits.end..]);
    hasher.finalize().to_hex().to_string()
}

/// Writes the hash into a file that was written with [`unsealed`] among its metadata.
pub(super) fn seal(file: &mut File) -> io::Result<()> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    let digits = place(&bytes).ok_or_else(|| io::Error::other("the footer has no place for the checksum"))?;
    let hash = hash(&bytes, &digits);
    file.seek(SeekFrom::Start(digits.start as u64))?;
    file.write_all(hash.as_bytes())
}

/// Checks the hash inside a file, if there is one. Returns whether there is.
pub(super) fn check_if_sealed(path: &Path) -> Result<bool, DiskError> {
    let mut bytes = Vec::new();
    open_input(path)?.read_to_end(&mut bytes).map_err(DiskError::io(path, "read"))?;
    let Some(digits) = place(&bytes) else {
        return Ok(false);
    };
    let found = hash(&bytes, &digits);
    let stored = &bytes[digits];
    if stored == found.as_bytes() {
        return Ok(true);
    }
    let stored = String::from_utf8_lossy(stored).into_owned();
    let remedy = "copy the file again, or make it again";
    Err(InputError::new(path, "checksum", found, stored, remedy).into())
}

/// Checks the hash inside a file. A file without one is refused.
pub(super) fn check(path: &Path) -> Result<(), DiskError> {
    if check_if_sealed(path)? {
        return Ok(());
    }
    let remedy = "copy the file again; other programs drop the checksum when they rewrite the file";
    Err(InputError::new(path, SEAL_KEY, "no checksum", "a file with its own checksum", remedy).into())
}
